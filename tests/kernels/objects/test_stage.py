"""Objects against closed forms: flight, bounces, sliding, rolling, rest, collisions, and what is held."""

import msgspec
import numpy as np
import pytest

from warpmuscle.core.pose import about, rotate
from warpmuscle.results.recording import Recording
from warpmuscle.scene import (
    BallObject,
    Body,
    BoxObject,
    CapsuleObject,
    Character,
    Failure,
    Ground,
    Held,
    InitialState,
    Scene,
    Sphere,
    Terrain,
)
from warpmuscle.scene.number import Free
from warpmuscle.scene.objects.motion import ObjectMotion, object_motion
from warpmuscle.scene.terrain.tiles import Flat, Slope, Stairs
from warpmuscle.simulation.rollout import Rollout

G, STEP = 9.8, 0.0005
X = np.array([1.0, 0.0, 0.0])
PLAIN = Ground(stiffness=1e5, damping=1e3)
NOTHING = Ground(stiffness=0.0)


def beside(solid, ground=PLAIN, duration=1.0, gravity=G, place=(5.0, 0.0999, 0.0), **start) -> Scene:
    """An object and, out of its way, a body of 5 kg with a sphere of 0.1 m."""
    body = Body(5.0, (0.05, 0.05, 0.05), [Sphere((0.0, 0.0, 0.0), 0.1)])
    return Scene(
        "beside", Character("block", {"block": body}), initial_state=InitialState(place, **start), ground=ground,
        objects={"one": solid}, failure=Failure(com_height=0.0, heading=0.0), duration=duration, gravity=gravity,
        time_step=STEP,
    )  # fmt: skip


def played(scene: Scene, rate: float = 2000.0) -> tuple[Recording, ObjectMotion]:
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=rate)
    rollout.run()
    recording = rollout.recording(0)
    motion = object_motion(recording, "one")
    return recording, motion


def energy(motion: ObjectMotion, mass: float, inertia: float) -> np.ndarray:
    """Of a ball, J."""
    moving = 0.5 * mass * np.sum(motion.velocity**2, axis=1) + 0.5 * inertia * np.sum(
        motion.angular_velocity**2, axis=1
    )
    return moving + mass * G * motion.position[:, 1]


def test_a_ball_flies_along_a_parabola():
    start = np.array([0.3, 1.0, -0.2])
    recording, motion = played(beside(BallObject(position=(0.3, 1.0, -0.2), velocity=(1.0, 4.0, -0.5)), duration=0.5))
    t = recording.time.astype(float)[:, None]
    expected = start + np.array([1.0, 4.0, -0.5]) * t - 0.5 * G * t**2 * np.array([0.0, 1.0, 0.0])
    np.testing.assert_allclose(motion.position, expected, atol=2e-5)


def test_a_ball_that_loses_nothing_keeps_its_energy_over_five_bounces():
    solid = BallObject(position=(0.0, 0.6, 0.0), velocity=(0.5, 0.0, 0.3), restitution=1.0, friction=0.0, mass=0.5)
    _, motion = played(beside(solid, duration=3.5))
    flying = motion.position[:, 1] > 0.11
    bounces = np.sum(flying[:-1] & ~flying[1:])
    total = energy(motion, 0.5, 0.002)[flying]
    assert bounces == 5
    np.testing.assert_allclose(total, total[0], rtol=0.01)
    np.testing.assert_allclose(motion.velocity[-1, [0, 2]], [0.5, 0.3], rtol=1e-5)


@pytest.mark.parametrize("restitution", [0.3, 0.6, 0.9])
def test_a_ball_bounces_to_the_square_of_its_restitution_of_the_height(restitution: float):
    _, motion = played(beside(BallObject(position=(0.0, 1.1, 0.0), restitution=restitution, mass=0.5), duration=1.2))
    height = motion.position[:, 1] - 0.1
    lowest = np.argmin(height[:1000])
    assert height[lowest:].max() == pytest.approx(restitution**2, abs=0.015)


def test_a_box_that_slides_stops_where_coulomb_says():
    solid = BoxObject(position=(0.0, 0.0998, 0.0), velocity=(0.0, 0.0, 2.0), friction=0.4, mass=2.0)
    _, motion = played(beside(solid, duration=1.0))
    assert motion.position[-1, 2] == pytest.approx(2.0**2 / (2.0 * 0.4 * G), rel=0.01)
    np.testing.assert_allclose(motion.velocity[-1], 0.0, atol=1e-4)
    np.testing.assert_allclose(np.abs(motion.orientation[-1]), [0.0, 0.0, 0.0, 1.0], atol=1e-3)


def test_a_ball_that_slides_rolls_at_five_sevenths_of_its_speed():
    solid = BallObject(position=(0.0, 0.0999, 0.0), velocity=(0.0, 0.0, 2.0), friction=0.3)
    recording, motion = played(beside(solid, duration=1.0))
    assert motion.velocity[-1, 2] == pytest.approx(2.0 * 5.0 / 7.0, rel=2e-3)
    assert motion.angular_velocity[-1, 0] == pytest.approx(2.0 * 5.0 / 7.0 / 0.1, rel=5e-3)
    rolling = recording.time[np.argmax(motion.velocity[:, 2] < 2.0 * 5.0 / 7.0 * 1.002)]
    assert rolling == pytest.approx(2.0 * 2.0 / (7.0 * 0.3 * G), rel=0.05)  # 2 v/(7 mu g)


def test_a_box_at_rest_keeps_still_for_ten_seconds():
    _, motion = played(beside(BoxObject(position=(0.0, 0.1, 0.0), mass=2.0), duration=10.0), rate=50.0)
    np.testing.assert_allclose(motion.position[50:], motion.position[-1:].repeat(450, axis=0), atol=1e-6)
    depth = 2.0 * G / (4.0 * 2.0e4)  # on four corners
    assert motion.position[-1, 1] == pytest.approx(0.1 - depth, abs=1e-6)


def test_a_box_that_turns_in_flight_keeps_angular_momentum_and_energy():
    solid = BoxObject(position=(0.0, 50.0, 0.0), size=(0.1, 0.3, 0.5), angular_velocity=(0.1, 8.0, 0.05), mass=3.0)
    _, motion = played(beside(solid, gravity=0.0, duration=4.0), rate=100.0)
    edges = np.array([0.1, 0.3, 0.5])
    inertia = 3.0 / 12.0 * (np.sum(edges**2) - edges**2)
    own = rotate(motion.orientation * [-1, -1, -1, 1], motion.angular_velocity)
    momentum = rotate(motion.orientation, inertia * own)
    np.testing.assert_allclose(momentum, momentum[:1].repeat(len(momentum), axis=0), atol=2e-4)
    np.testing.assert_allclose(np.sum(inertia * own**2, axis=1), np.sum(inertia * own[0] ** 2), rtol=0.01)
    assert own[:, 1].min() < -7.0  # about its middle axis it tumbles


@pytest.mark.parametrize(
    "solid",
    [BallObject(), BoxObject(size=(0.2, 0.3, 0.4), orientation=(0.1, 0.2, 0.3, 0.9)), CapsuleObject(length=0.3)],
    ids=["ball", "box", "capsule"],
)
def test_a_collision_with_a_body_keeps_momentum_and_has_the_restitution(solid):
    solid.mass, solid.restitution, solid.friction = 0.5, 0.8, 0.3
    solid.position, solid.velocity, solid.angular_velocity = (0.02, 1.0, -0.6), (0.0, 0.0, 3.0), (0.0, 15.0, 2.0)
    recording, motion = played(beside(solid, NOTHING, 0.5, 0.0, (0.0, 1.0, 0.0)))
    body = np.asarray(recording.root_velocity[-1], dtype=float)
    spin = np.asarray(recording.root_angular_velocity[-1], dtype=float)
    assert body[2] > 0.3
    np.testing.assert_allclose(0.5 * motion.velocity[-1] + 5.0 * body, [0.0, 0.0, 1.5], atol=2e-5)
    if isinstance(solid, BallObject):
        place = np.asarray(recording.root_position[-1], dtype=float)
        own = 0.002 * motion.angular_velocity
        start = np.cross(motion.position[0], 0.5 * motion.velocity[0]) + own[0]
        end = np.cross(motion.position[-1], 0.5 * motion.velocity[-1]) + own[-1]
        end += np.cross(place, 5.0 * body) + 0.05 * spin
        np.testing.assert_allclose(end, start, atol=2e-3)
        apart = motion.position[-1] - place
        away = (motion.velocity[-1] - body) @ apart / np.linalg.norm(apart)
        assert away > 0.0


def test_a_head_on_impact_of_a_ball_has_its_restitution():
    solid = BallObject(mass=0.5, restitution=0.7, position=(0.0, 1.0, -0.6), velocity=(0.0, 0.0, 3.0))
    recording, motion = played(beside(solid, NOTHING, 0.5, 0.0, (0.0, 1.0, 0.0)))
    body = float(recording.root_velocity[-1, 2])
    assert body - motion.velocity[-1, 2] == pytest.approx(0.7 * 3.0, rel=0.02)


def test_a_body_rests_on_a_fixed_box_as_deep_as_its_spring_gives_way():
    seat = BoxObject(position=(5.0, 0.2, 0.0), size=(0.4, 0.4, 0.4), fixed=True, restitution=0.0)
    recording, motion = played(beside(seat, place=(5.0, 0.52, 0.0), duration=2.0), rate=100.0)
    assert recording.root_position[-1, 1] == pytest.approx(0.5 - 5.0 * G / 2.0e4, abs=1e-5)
    np.testing.assert_array_equal(motion.position, np.tile(np.float32([5.0, 0.2, 0.0]), (200, 1)))


def test_a_body_with_a_held_ball_moves_as_one_body_of_both_and_lets_go_with_its_velocity():
    arm, mass, ball = np.array([0.0, -0.3, 0.1]), 2.0, 0.4 * 2.0 * 0.1**2
    held = BallObject(mass=mass, held=Held("block", tuple(arm), until=0.3))
    start = {"root_velocity": (0.5, 2.0, 0.0), "root_angular_velocity": (0.0, 0.0, 6.0)}
    recording, motion = played(beside(held, NOTHING, 0.6, G, (0.0, 3.0, 0.0), **start))
    center = 5.0 * recording.root_position + mass * motion.position
    velocity = 5.0 * np.array([0.5, 2.0, 0.0]) + mass * (np.array([0.5, 2.0, 0.0]) + np.cross([0.0, 0.0, 6.0], arm))
    t = recording.time.astype(float)[:, None]
    expected = center[0] + velocity * t - 0.5 * 7.0 * G * t**2 * np.array([0.0, 1.0, 0.0])
    np.testing.assert_allclose(center, expected, atol=3e-4)  # also after it was let go
    turned = rotate(recording.body_orientation[:, 0], arm)
    holding = recording.time < 0.3
    np.testing.assert_allclose((motion.position - recording.root_position)[holding], turned[holding], atol=1e-5)
    assert np.abs((motion.position - recording.root_position) - turned)[-1].max() > 0.05
    relative = motion.position - recording.root_position
    moving = np.diff(relative, axis=0) / np.diff(recording.time)[:, None]
    spin = np.asarray(recording.root_angular_velocity, dtype=float)
    reduced = 5.0 * mass / 7.0
    momentum = reduced * np.cross(relative[1:], moving) + (0.05 + ball) * spin[1:]
    held_there = holding[1:] & (np.arange(len(momentum)) > 2)
    np.testing.assert_allclose(momentum[held_there][:, 2], momentum[held_there][0, 2], rtol=5e-3)


def test_each_instance_has_its_own_object_and_the_bits_of_one_alone():
    scene = beside(BallObject(position=(0.0, 1.0, 0.0), mass=Free(1.0, 0.5, 2.0), radius=Free(0.1, 0.05, 0.2)))
    ends = {}
    for values in ([[1.0, 0.1]], [[0.5, 0.2], [1.0, 0.1], [2.0, 0.05]]):
        rollout = Rollout(scene, len(values), "cpu", record=range(len(values)), record_rate=100.0)
        mass, radius = np.array(values).T
        rollout.set_parameters({"objects.one.mass": mass, "objects.one.radius": radius})
        rollout.run()
        for number, value in enumerate(values):
            motion = object_motion(rollout.recording(number), "one")
            ends.setdefault(tuple(value), []).append(motion.position)
    np.testing.assert_array_equal(*ends[1.0, 0.1])
    np.testing.assert_allclose([found[0][-1, 1] for found in ends.values()], [0.1, 0.2, 0.05], atol=0.01)


def test_an_instance_that_starts_again_has_its_object_where_it_was():
    rollout = Rollout(beside(BallObject(position=(0.0, 1.0, 0.0), velocity=(1.0, 0.0, 0.0))), 2, "cpu")
    rollout.run(0.2)
    once = rollout._extensions.memories[0].numpy().copy()
    rollout.reset(mask=np.array([False, True]))
    rollout.run(0.2)
    then = rollout._extensions.memories[0].numpy()
    np.testing.assert_array_equal(then[1], once[1])
    assert then[0, 0, 1] == pytest.approx(0.4, abs=1e-3)  # on x, without a new start


def test_a_box_slides_down_a_slope_of_terrain_by_gravity_less_friction():
    angle, friction = 0.5, 0.3
    terrain = Terrain([Slope(-angle), Flat()])
    turn = about(X, angle)
    up = np.array([0.0, np.cos(angle), np.sin(angle)])
    place = tuple(up * 0.0998)
    solid = BoxObject(position=place, orientation=tuple(turn), friction=friction, mass=2.0)
    _, motion = played(beside(solid, Ground(terrain=terrain), 0.5, place=(5.0, 3.0, 0.0)))
    down = np.array([0.0, -np.sin(angle), np.cos(angle)])
    acceleration = G * (np.sin(angle) - friction * np.cos(angle))
    assert motion.velocity[-1] @ down == pytest.approx(acceleration * 0.5, rel=0.01)
    np.testing.assert_allclose(np.abs(motion.orientation[-1] @ turn), 1.0, atol=1e-4)


@pytest.mark.parametrize("speed", [0.5, 1.0])
def test_a_ball_bounces_off_a_stair_with_less_energy_than_it_had(speed):
    mass, radius = 2.0, 0.15
    solid = BallObject(
        mass=mass, radius=radius, position=(0.0, radius, 0.2), velocity=(0.0, 0.0, speed), restitution=0.4, friction=0.4
    )
    ground = Ground(terrain=Terrain([Stairs(0.05, 0.4, 3, start=0.5)]))
    _, motion = played(beside(solid, ground, 1.0, place=(5.0, 3.0, 0.0)))
    total = energy(motion, mass, 0.4 * mass * radius**2) - mass * G * radius
    edge = 0.5 - np.sqrt(radius**2 - (radius - 0.05) ** 2)  # where the ball meets it
    assert motion.position[:, 2].max() == pytest.approx(edge, abs=0.025)
    assert motion.velocity[-1, 2] < 0.0
    assert total.max() < 1.01 * total[0]
    assert total[-1] < 0.5 * total[0]


ALONG_Z = (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))


@pytest.mark.parametrize(
    ("solid", "lies"),
    [
        (BoxObject(size=(0.3, 0.2, 0.5), friction=1.0), 0.1),
        (BoxObject(size=(0.3, 0.1, 1.2), friction=1.0), 0.05),
        (CapsuleObject(radius=0.05, length=0.6, orientation=ALONG_Z, friction=1.0), 0.05),
    ],
)
def test_what_is_longer_than_a_wall_rests_on_it(solid, lies):
    """Its corners are in the air on both sides."""
    top = 0.3
    terrain = Terrain([Stairs(top, 0.3, 1, start=1.0, landing=0.3)])
    place = (0.0, top + lies + 0.005, 1.14)
    one = msgspec.structs.replace(solid, position=place, mass=2.0, restitution=0.1)
    _, motion = played(beside(one, Ground(terrain=terrain), 0.5, place=(5.0, 3.0, 0.0)))
    assert motion.position[-1, 1] == pytest.approx(top + lies, abs=1e-3)
    np.testing.assert_allclose(motion.position[-1, [0, 2]], (0.0, 1.14), atol=0.02)


def test_on_a_slope_the_corners_of_a_box_bear_it_alone():
    """Each is pressed in by a quarter of the weight across the slope over the stiffness."""
    angle, stiffness, mass, half = 0.1, 1e4, 2.0, 0.1
    up = np.array([0.0, np.cos(angle), np.sin(angle)])
    solid = BoxObject(
        size=(0.3, 2.0 * half, 0.4), position=tuple(up * (half - 4e-4)), orientation=tuple(about(X, angle)), mass=mass,
        stiffness=stiffness, friction=1.0, tangential_damping=1e4,
    )  # fmt: skip
    ground = Ground(terrain=Terrain([Slope(-angle), Flat()]))
    _, motion = played(beside(solid, ground, 0.5, place=(5.0, 3.0, 0.0)))
    depth = half - motion.position[-1] @ up
    assert depth == pytest.approx(mass * G * np.cos(angle) / (4.0 * stiffness), rel=0.01)
