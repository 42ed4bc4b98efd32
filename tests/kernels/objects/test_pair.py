"""Objects that touch each other against closed forms: impacts, stacks, sliding, what lies across."""

import numpy as np
import pytest

from objects_alone import PLAIN, STEP, played, together
from warpmuscle.core.pose import about, multiply
from warpmuscle.scene import BallObject, BoxObject, CapsuleObject, Ground

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

G, STIFF = 9.8, 2.0e4
X = np.array([1.0, 0.0, 0.0])


def test_a_head_on_impact_keeps_momentum_and_has_the_smaller_restitution():
    objects = {
        "one": BallObject(mass=0.5, restitution=0.7, velocity=(0.0, 0.0, 3.0), position=(0.0, 1.0, -0.5)),
        "other": BallObject(touches=["one"], mass=2.0, restitution=0.9, position=(0.0, 1.0, 0.0)),
    }  # fmt: skip
    _, motion = played(together(objects))
    after = [float(motion[name].velocity[-1, 2]) for name in objects]
    assert after[1] - after[0] == pytest.approx(0.7 * 3.0, rel=0.02)
    assert 0.5 * after[0] + 2.0 * after[1] == pytest.approx(1.5, rel=1e-5)


@pytest.mark.parametrize(
    "other",
    [BallObject(), BoxObject(size=(0.3, 0.2, 0.4), orientation=(0.1, 0.2, 0.3, 0.9)), CapsuleObject(length=0.4)],
    ids=["ball", "box", "capsule"],
)
@pytest.mark.parametrize("one", [BallObject(), BoxObject(orientation=(0.3, -0.2, 0.1, 0.8))], ids=["ball", "box"])
def test_an_oblique_impact_keeps_momentum_and_angular_momentum_and_gains_no_energy(one, other):
    one.mass, one.position, one.velocity, one.touches = 0.7, (0.04, 1.03, -0.5), (0.0, 0.0, 3.0), ["other"]
    one.angular_velocity = (2.0, 5.0, -3.0)
    other.mass, other.position, other.angular_velocity = 1.5, (0.0, 1.0, 0.0), (0.0, 1.0, 0.0)
    scene = together({"one": one, "other": other})
    _, motion = played(scene)
    momentum, turning, energy = (np.zeros((2, 3)), np.zeros((2, 3)), np.zeros(2))
    for name, solid in scene.objects.items():
        m = motion[name]
        inertia = own_inertia(solid)
        for k, frame in enumerate((0, -1)):
            q, spin = m.orientation[frame], m.angular_velocity[frame].astype(float)
            matrix = rotation(q) @ np.diag(inertia) @ rotation(q).T
            velocity = m.velocity[frame].astype(float)
            momentum[k] += solid.mass * velocity
            turning[k] += np.cross(m.position[frame], solid.mass * velocity) + matrix @ spin
            energy[k] += 0.5 * solid.mass * velocity @ velocity + 0.5 * spin @ matrix @ spin
    assert np.abs(motion["other"].velocity[-1]).max() > 0.2
    np.testing.assert_allclose(momentum[1], momentum[0], atol=2e-5)
    np.testing.assert_allclose(turning[1], turning[0], atol=5e-3)
    assert energy[1] < energy[0]


def own_inertia(solid) -> np.ndarray:
    """Principal moments, kg m^2, from textbooks."""
    m = solid.mass
    if isinstance(solid, BallObject):
        return np.full(3, 0.4 * m * solid.radius**2)
    if isinstance(solid, BoxObject):
        edges = np.array(solid.size)
        return m / 12.0 * ((edges**2).sum() - edges**2)
    r, length = solid.radius, solid.length
    ends = m * 4.0 * r / (4.0 * r + 3.0 * length)
    bar = m - ends
    across = bar * (length**2 / 12 + r**2 / 4) + ends * (0.4 * r**2 + 0.25 * length**2 + 0.375 * length * r)
    return np.array([across, 0.4 * ends * r**2 + 0.5 * bar * r**2, across])


def rotation(q: np.ndarray) -> np.ndarray:
    """The matrix of a unit quaternion x, y, z, w."""
    x, y, z, w = (float(v) for v in q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


@pytest.mark.parametrize("restitution", [0.4, 0.8])
def test_a_ball_bounces_on_a_fixed_box(restitution: float):
    objects = {
        "ball": BallObject(mass=0.5, position=(0.1, 1.6, 0.05), restitution=restitution, touches=["table"]),
        "table": BoxObject(size=(1.0, 0.2, 1.0), position=(0.0, 0.4, 0.0), fixed=True, restitution=1.0),
    }
    _, motion = played(together(objects, duration=1.3, gravity=G), 2000.0)
    height = motion["ball"].position[:, 1] - 0.6
    lowest = np.argmin(height[:1200])
    assert height[lowest:].max() == pytest.approx(restitution**2, abs=0.015)
    np.testing.assert_array_equal(motion["table"].position[-1], np.float32([0.0, 0.4, 0.0]))


def test_a_stack_rests_as_deep_as_its_springs_give_way():
    objects = {
        "low": BoxObject(mass=4.0, size=(0.4, 0.2, 0.4), position=(0.0, 0.1, 0.0), restitution=0.0),
        "high": BoxObject(mass=2.0, position=(0.05, 0.3, 0.02), restitution=0.0, touches=["low"]),
    }
    _, motion = played(together(objects, PLAIN, 3.0, G), 50.0)
    low = 0.1 - 6.0 * G / (4.0 * STIFF)  # on four corners, though not evenly
    high = low + 0.2 - 2.0 * G / (4.0 * STIFF)
    assert motion["high"].position[-1, 1] == pytest.approx(high, abs=1e-4)
    np.testing.assert_allclose(
        motion["high"].position[100:], motion["high"].position[-1:].repeat(50, axis=0), atol=2e-5
    )
    np.testing.assert_allclose(np.abs(motion["high"].orientation[-1, 3]), 1.0, atol=1e-6)


@pytest.mark.parametrize("off", [(0.0, 0.0), (0.0, 0.02), (1e-7, 1e-6), (3e-6, 0.02), (0.03, 0.0), (0.03, 0.02)])
def test_equal_boxes_rest_on_each_other_flush_or_with_an_overhang(off: tuple[float, float]):
    """Corners lie on edges, or beyond them, and only where edges cross does the face of the other one bear."""
    objects = {
        "low": BoxObject(mass=2.0, position=(0.0, 0.0999, 0.0)),
        "high": BoxObject(mass=1.0, position=(off[0], 0.2998, off[1]), touches=["low"]),
    }
    _, motion = played(together(objects, PLAIN, 1.0, G), 50.0)
    low = 0.1 - 3.0 * G / (4.0 * STIFF)
    lies = (off[0], low + 0.2 - G / (4.0 * STIFF), off[1])
    np.testing.assert_allclose(motion["high"].position[-1], lies, atol=2.5e-4)
    np.testing.assert_allclose(motion["high"].velocity[-1], 0.0, atol=1e-3)


def test_three_equal_boxes_stand_on_each_other():
    objects = {
        f"box{n}": BoxObject(mass=2.0 - 0.5 * n, position=(0.01 * n, 0.1 + 0.2 * n, 0.0), touches=[f"box{n - 1}"][:n])
        for n in range(3)
    }
    _, motion = played(together(objects, PLAIN, 2.0, G), 50.0)
    lowest = motion["box0"].position[-1, 1]
    assert lowest == pytest.approx(0.1 - 4.5 * G / (4.0 * STIFF), abs=2e-5)
    assert motion["box2"].position[-1] == pytest.approx([0.02, lowest + 0.4 - 3.5 * G / (4.0 * STIFF), 0.0], abs=1e-3)


def test_a_box_that_slides_on_a_box_comes_to_the_velocity_of_both():
    """From v, on what slides without friction itself: v m/(m + M), after v^2 M/(2 mu g (m + M)) of sliding."""
    mass, below, friction, v = 1.0, 3.0, 0.4, 1.5
    objects = {
        "low": BoxObject(mass=below, size=(0.4, 0.2, 1.6), position=(0.0, 0.0999, 0.0), friction=0.0),
        "high": BoxObject(
            mass=mass, position=(0.0, 0.2998, -0.4), velocity=(0.0, 0.0, v), friction=friction, touches=["low"]
        ),
    }
    objects["low"].friction = 1.0
    ground = Ground(stiffness=1e5, damping=1e3, friction=0.0)
    _, motion = played(together(objects, ground, 1.0, G))
    both = v * mass / (mass + below)
    for name in objects:
        np.testing.assert_allclose(motion[name].velocity[-1], [0.0, 0.0, both], atol=2e-3)
    slid = (motion["high"].position - motion["low"].position)[[0, -1], 2]
    assert slid[1] - slid[0] == pytest.approx(v**2 * below / (2.0 * friction * G * (mass + below)), rel=0.01)


def test_a_bar_rests_across_a_box_that_both_its_ends_are_beyond():
    """It is borne where its part over the box begins and ends, each with half of the stiffness."""
    turn = about(X, 0.5 * np.pi)
    objects = {
        "bar": CapsuleObject(
            mass=3.0, length=1.0, position=(0.0, 0.55, 0.0), orientation=tuple(turn), restitution=0.0, touches=["bench"]
        ),
        "bench": BoxObject(size=(0.4, 0.5, 0.4), position=(0.0, 0.25, 0.0), fixed=True),
    }
    _, motion = played(together(objects, PLAIN, 2.0, G), 50.0)
    assert motion["bar"].position[-1, 1] == pytest.approx(0.55 - 3.0 * G / STIFF, abs=2e-5)
    np.testing.assert_allclose(np.abs(motion["bar"].orientation[-1] @ turn), 1.0, atol=1e-6)


@pytest.mark.parametrize(("angle", "off"), [(90.0, 0.0), (90.0, 0.15), (35.0, -0.1)])
@pytest.mark.parametrize("names", [("bar", "rail"), ("rail", "bar")])
def test_bars_that_cross_push_each_other_once(angle: float, off: float, names: tuple[str, str]):
    """With the stiffness of one place, whichever is named first, and at whatever places of both they cross."""
    turns = [about(np.array([0.0, 1.0, 0.0]), np.radians(a)) for a in (0.0, angle)]
    flat = about(X, 0.5 * np.pi)
    along = [rotation(turn) @ np.array([0.0, 0.0, 1.0]) for turn in turns]
    bars = [
        CapsuleObject(mass=2.0, radius=r, length=0.8, orientation=tuple(multiply(turn, flat)),
                      position=tuple(place), restitution=0.0, friction=0.0)
        for r, turn, place in zip((0.1, 0.05), turns, (off * along[0], (0.0, 0.149, 0.0) - off * along[1]), strict=True)
    ]  # fmt: skip
    bars[1].touches = [names[0]]
    _, motion = played(together(dict(zip(names, bars, strict=True)), duration=0.002), 2000.0)
    wanted = STIFF * 0.001 / 2.0 * 0.5 * STEP  # after half a step, of the middles
    for name, sign in zip(names, (-1.0, 1.0), strict=True):
        np.testing.assert_allclose(motion[name].velocity[1], [0.0, sign * wanted, 0.0], rtol=0.02, atol=1e-7)


def test_a_bar_rests_across_a_fixed_one_as_deep_as_its_spring_gives_way():
    objects = {
        "rail": CapsuleObject(mass=1.0, radius=0.05, length=1.0, position=(0.0, 0.5, 0.0), fixed=True),
        "bar": CapsuleObject(
            mass=3.0, radius=0.05, length=0.6, position=(0.0, 0.6, 0.0), orientation=tuple(about(X, 0.5 * np.pi)),
            restitution=0.0, touches=["rail"],
        ),
    }  # fmt: skip
    objects["rail"].orientation = tuple(about(np.array([0.0, 0.0, 1.0]), 0.5 * np.pi))
    _, motion = played(together(objects, duration=1.0, gravity=G), 50.0)
    np.testing.assert_allclose(motion["bar"].position[-1], [0.0, 0.6 - 3.0 * G / STIFF, 0.0], atol=2e-5)


def test_a_ball_near_the_edge_of_a_box_is_pushed_once():
    """Its face pushes it, and not the corner as well, which is inside the ball."""
    objects = {
        "ball": BallObject(mass=2.0, position=(0.1995, 0.599, 0.1995), restitution=0.0, friction=0.0, touches=["box"]),
        "box": BoxObject(size=(0.4, 0.5, 0.4), position=(0.0, 0.25, 0.0), fixed=True),
    }  # fmt: skip
    _, motion = played(together(objects, PLAIN, 0.002, 0.0), 2000.0)
    first = float(motion["ball"].velocity[1, 1])  # after half a step
    assert first == pytest.approx(STIFF * 0.001 / 2.0 * 0.5 * STEP, rel=0.02)


def test_the_end_of_a_bar_and_the_corner_of_a_box_push_each_other_once():
    """Where each is the nearest place of its object to the other; the bar goes on towards the box's other end."""
    half, radius = np.array([0.05, 0.05, 1.0]), 0.05
    end, along = half + np.array([0.03, 0.03, 0.01]), np.array([0.55, 0.55, -1.5])
    length = float(np.linalg.norm(along))
    along /= length
    across = np.cross([0.0, 1.0, 0.0], along)
    turn = about(across / np.linalg.norm(across), float(np.arccos(along[1])))
    bar = CapsuleObject(
        mass=2.0, length=length, radius=radius, position=tuple(end + 0.5 * length * along), orientation=tuple(turn),
        restitution=0.0, friction=0.0, touches=["box"],
    )  # fmt: skip
    box = BoxObject(size=tuple(2.0 * half), position=(0.0, 0.0, 0.0), fixed=True)
    _, motion = played(together({"bar": bar, "box": box}, duration=0.002), 2000.0)
    gap = end - half
    distance = float(np.linalg.norm(gap))
    wanted = STIFF * (radius - distance) / 2.0 * 0.5 * STEP * gap / distance  # after half a step
    np.testing.assert_allclose(motion["bar"].velocity[1], wanted, rtol=0.03)


@pytest.mark.parametrize("solid", [BallObject(radius=0.2), CapsuleObject(radius=0.2, length=0.4)])
def test_round_objects_of_two_radii_push_as_deep_as_both_reach(solid):
    """One is 1 mm deep in a ball, or in the middle of a capsule's side."""
    solid.position, solid.restitution, solid.friction, solid.mass = (0.0, 0.0, 0.299), 0.0, 0.0, 2.0
    ball = BallObject(mass=2.0, radius=0.1, position=(0.0, 0.0, 0.0), restitution=0.0, friction=0.0, touches=["other"])
    _, motion = played(together({"ball": ball, "other": solid}, duration=0.002), 2000.0)
    wanted = STIFF * 0.001 / 2.0 * 0.5 * STEP  # after half a step
    np.testing.assert_allclose(motion["ball"].velocity[1], [0.0, 0.0, -wanted], rtol=0.02, atol=1e-7)
    np.testing.assert_allclose(motion["other"].velocity[1], [0.0, 0.0, wanted], rtol=0.02, atol=1e-7)


def test_the_end_of_a_bar_whose_side_lies_on_a_corner_does_not_push_as_well():
    """The corner is the nearest place of the box to the end, too, 1 cm away from where the bar is nearest to it."""
    half, off, along = np.array([0.05, 0.05, 1.0]), np.full(3, 0.02), np.array([-1.0, -1.0, 2.0]) / np.sqrt(6.0)
    across = np.cross([0.0, 1.0, 0.0], along)
    turn = about(across / np.linalg.norm(across), float(np.arccos(along[1])))
    distance = float(np.linalg.norm(off))
    wanted = STIFF * (0.05 - distance) / 2.0 * 0.5 * STEP * off / distance  # after half a step
    for past in (0.01, 0.3):
        bar = CapsuleObject(
            mass=2.0, length=1.0, radius=0.05, position=tuple(half + off + (0.5 - past) * along),
            orientation=tuple(turn), restitution=0.0, friction=0.0, touches=["box"],
        )  # fmt: skip
        box = BoxObject(size=tuple(2.0 * half), position=(0.0, 0.0, 0.0), fixed=True)
        _, motion = played(together({"bar": bar, "box": box}, duration=0.002), 2000.0)
        np.testing.assert_allclose(motion["bar"].velocity[1], wanted, rtol=0.03)


def test_a_ball_that_strikes_the_side_of_a_bar_has_the_restitution_that_was_asked_for():
    bar = CapsuleObject(mass=1.0, radius=0.1, length=0.6, position=(0.0, 1.0, 0.0), restitution=0.6, friction=0.0)
    ball = BallObject(mass=2.0, radius=0.2, position=(0.0, 1.0, -0.4), velocity=(0.0, 0.0, 2.0), touches=["bar"])
    ball.restitution = 0.6
    _, motion = played(together({"bar": bar, "ball": ball}))
    after = [float(motion[name].velocity[-1, 2]) for name in ("bar", "ball")]
    assert after[0] - after[1] == pytest.approx(0.6 * 2.0, rel=0.02)
    assert after[0] + 2.0 * after[1] == pytest.approx(4.0, rel=1e-5)


def test_objects_that_do_not_name_each_other_pass_through():
    objects = {
        "one": BallObject(velocity=(0.0, 0.0, 3.0), position=(0.0, 1.0, -0.5)),
        "other": BallObject(position=(0.0, 1.0, 0.0)),
    }
    _, motion = played(together(objects))
    np.testing.assert_allclose(motion["one"].velocity[-1], [0.0, 0.0, 3.0], atol=1e-6)


@pytest.mark.parametrize(("yaw", "off"), [(0.0, 0.0), (0.4, 0.03)])
def test_a_plank_lies_across_a_beam(yaw: float, off: float):
    """No corner of either is on the other: four crossings of edges, half as stiff as corners, bear it."""
    mass, gravity = 2.0, 9.8
    beam = BoxObject(size=(2.0, 0.2, 0.2), position=(0.0, 0.1, 0.0), fixed=True, stiffness=STIFF)
    turn = tuple(about(np.array([0.0, 1.0, 0.0]), yaw))
    plank = BoxObject(
        size=(0.1, 0.1, 1.0), mass=mass, position=(0.3, 0.252, off), orientation=turn, touches=["beam"],
        restitution=0.1, friction=0.8, stiffness=STIFF,
    )  # fmt: skip
    _, motion = played(together({"plank": plank, "beam": beam}, duration=1.0, gravity=gravity))
    deep = mass * gravity / (4.0 * 0.5 * STIFF)
    assert motion["plank"].position[-1, 1] == pytest.approx(0.25 - deep, abs=2e-4)
    np.testing.assert_allclose(motion["plank"].position[-1, [0, 2]], (0.3, off), atol=1e-3)
    assert np.abs(motion["plank"].angular_velocity[-1]).max() < 1e-3


def test_bars_that_meet_crosswise_in_the_air_keep_their_momentum():
    one = BoxObject(
        size=(0.1, 0.1, 1.0), mass=1.0, position=(0.05, 1.15, 0.1), velocity=(0.0, -2.0, 0.0), touches=["other"],
        restitution=0.5,
    )  # fmt: skip
    other = BoxObject(size=(1.0, 0.1, 0.1), mass=2.0, position=(0.0, 1.0, 0.0), restitution=0.5)
    _, motion = played(together({"one": one, "other": other}, duration=0.3))
    momentum = 1.0 * motion["one"].velocity[-1] + 2.0 * motion["other"].velocity[-1]
    np.testing.assert_allclose(momentum, (0.0, -2.0, 0.0), atol=2e-5)
    assert motion["other"].velocity[-1, 1] < -0.5
    assert motion["one"].position[-1, 1] > motion["other"].position[-1, 1]
