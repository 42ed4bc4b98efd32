"""Walks along routes whose points move or come and go: lengths by hand, moment arms by differences of them."""

import numpy as np
import pytest

from muscle_arm import arm, leg, muscle
from warpmuscle.core.pose import from_rotation_vector, rotate
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.coordinates import States
from warpmuscle.inverse.dynamics import prepare
from warpmuscle.inverse.reactions.joint_reactions import muscle_wrenches
from warpmuscle.inverse.trial import Coordinates
from warpmuscle.kernels.path.route_bends import LEVER_BITS
from warpmuscle.scene import (
    Body,
    Character,
    Condition,
    CylinderSurface,
    Failure,
    Joint,
    PointMotion,
    Scene,
    ViaPoint,
    Wrap,
)
from warpmuscle.scene.wrapping import route
from warpmuscle.scene.wrapping.touch import THROUGH
from warpmuscle.simulation.stages import MusclePaths, Stages

Q = np.linspace(-1.2, 1.2, 25)  # rad, of the elbow about x
SPEED, STEP = 1.7, 2e-3
LOW, HIGH = -0.55, 0.65  # rad, within which the extensor runs through a point
BASE, TIP = np.array([0.0, 0.0, 0.0]), np.array([0.0, 0.2, 0.0])  # the elbow from both centres of mass


def paths_at(q: np.ndarray, moving_points: str = "slopes") -> MusclePaths:
    """Of an arm whose flexor has a moving point in its middle and at its end, and whose extensor a conditional one."""
    scene = arm(flexor={})
    scene.character.moving_points = moving_points
    flexor, extensor = scene.character.muscles["flexor"], scene.character.muscles["extensor"]
    flexor.path[1].motion = [
        PointMotion((0.0, 0.0, 1.0), slope=0.03, joint="elbow"),
        PointMotion((0.0, 1.0, 0.0), slope=-0.015, joint="elbow"),
    ]
    flexor.path[2].motion = [PointMotion((0.0, 1.0, 0.0), slope=-0.02, joint="elbow")]
    extensor.path.insert(2, ViaPoint("tip", (0.0, 0.19, -0.07), Condition("elbow", LOW, HIGH, 0.0)))
    scene.character.muscles["third"] = muscle(("base", (0.0, 0.2, 0.05)), ("tip", (0.0, 0.1, 0.06)))
    stages = Stages(scene, len(q), "cpu")
    coordinates, speeds = stages.state.coordinates.numpy(), np.full((len(q), 1), SPEED, np.float32)
    coordinates[:, 7] = q
    stages.state.coordinates.assign(coordinates)
    stages.state.speeds.assign(speeds)
    return stages.muscle_paths()


@pytest.fixture(scope="module")
def found() -> MusclePaths:
    """At the angles, then a little before and after each."""
    return paths_at(np.concatenate([Q, Q - STEP, Q + STEP]))


def in_base(q: float, place: tuple[float, float, float]) -> np.ndarray:
    """A place of the forearm, from its centre of mass, in the axes of the base, from the elbow."""
    y, z = np.array(place)[1:] - TIP[1:]
    return np.array([place[0], np.cos(q) * y - np.sin(q) * z, np.sin(q) * y + np.cos(q) * z])


def test_a_point_with_a_hard_condition_is_on_the_route_within_its_interval_alone(found: MusclePaths):
    first, second = np.array([0.0, 0.2, -0.04]), np.array([0.0, 0.12, -0.04])
    for k, q in enumerate(Q):
        stops = [first, second, in_base(q, (0.0, 0.1, -0.04))]
        if LOW <= q <= HIGH:
            stops.insert(2, in_base(q, (0.0, 0.19, -0.07)))
        expected = np.linalg.norm(np.diff(stops, axis=0), axis=1).sum()
        assert found.length[k, 1] == pytest.approx(expected, abs=1e-6), q
    straight = [np.linalg.norm(in_base(q, (0.0, 0.1, 0.06)) - [0.0, 0.2, 0.05]) for q in Q]
    np.testing.assert_allclose(found.length[: len(Q), 2], straight, atol=1e-6)


def test_moving_points_pull_by_the_derivative_of_the_length_wherever_they_are_on_the_route(found: MusclePaths):
    count = len(Q)
    slope = (found.length[2 * count :].astype(float) - found.length[count : 2 * count]) / (2.0 * STEP)
    arms = np.zeros((count, 3))
    for crossing, number in enumerate(found.muscle):
        arms[:, number] += found.moment_arm[:count, crossing, 0]
    away = np.minimum(np.abs(Q - LOW), np.abs(Q - HIGH)) > 2.0 * STEP
    for number, where in ((0, Q < 9.0), (1, away), (2, Q < 9.0)):
        np.testing.assert_allclose(arms[where, number], slope[where, number], atol=3e-4)
        np.testing.assert_allclose(found.speed[:count][where, number], SPEED * slope[where, number], atol=5e-4)
    assert np.ptp(slope[:, 0]) > 0.02


def test_the_length_of_a_route_with_moving_points_is_that_of_their_places(found: MusclePaths):
    for k, q in enumerate(Q):
        stops = [
            np.array([0.0, 0.2, 0.04]),
            np.array([0.0, 0.12 - 0.015 * q, 0.04 + 0.03 * q]),
            in_base(q, (0.0, 0.1 - 0.02 * q, 0.04)),
        ]
        expected = np.linalg.norm(np.diff(stops, axis=0), axis=1).sum()
        assert found.length[k, 0] == pytest.approx(expected, abs=1e-6), q


def test_moment_arms_of_opensim_leave_out_what_a_motion_does_within_one_body(found: MusclePaths):
    """The flexor's first two points are both on the base, and the second one moves there."""
    along = np.stack([-0.08 - 0.015 * Q, 0.03 * Q])  # from the first to the second, y and z
    slope = (along * np.array([[-0.015], [0.03]])).sum(axis=0) / np.linalg.norm(along, axis=0)
    theirs = paths_at(Q, "opensim")
    np.testing.assert_allclose(theirs.length, found.length[: len(Q)], atol=1e-7)
    ours, left_out = (sum(one.moment_arm[: len(Q), k, 0] for k, number in enumerate(one.muscle) if number == 0)
                      for one in (found, theirs))  # fmt: skip
    np.testing.assert_allclose(ours - left_out, slope, atol=2e-6)
    assert np.ptp(slope) > 0.02


def test_a_muscle_pulls_on_bodies_where_its_moving_points_are_however_these_move():
    """Force and moment about the elbow on the forearm, along the segment between a moving point and the end."""
    scene, tension, slope = arm(), 100.0, 0.03
    scene.character.muscles["extensor"].path[1].motion = [PointMotion((0.0, 0.0, 1.0), slope=slope, joint="elbow")]
    body = BodyModel(scene, "cpu")
    times = np.arange(5) * 0.01
    q = np.linspace(-0.8, 0.9, 5)
    trials = prepare(body, Coordinates(("elbow",), times, q[:, None]), None, None, None)
    pulling = np.zeros((5, len(body.muscles)))
    pulling[:, body.muscles.index("extensor")] = tension
    moment, force = (
        array.numpy().astype(float) for array in muscle_wrenches(body, trials.states, slice(0, 5), pulling)
    )
    for k, angle in enumerate(trials.states.coordinates[:, -1]):
        end, middle = in_base(angle, (0.0, 0.1, -0.04)), np.array([0.0, 0.12, slope * angle - 0.04])
        pull = tension * (middle - end) / np.linalg.norm(middle - end)
        np.testing.assert_allclose(force[k, 1], pull, atol=1e-3)
        np.testing.assert_allclose(moment[k, 1], np.cross(end, pull), atol=1e-3)


POSES = 60


def test_a_route_round_two_surfaces_pulls_at_its_last_places_along_segments_between_the_first(monkeypatch):
    """In float64, from velocities of points: moment arms, those of the hip that it does not cross, and the speed."""
    scene = leg()
    character = scene.character
    character.wrapping = "opensim"
    character.surfaces = {
        "condyle": CylinderSurface("thigh", (0.0, -0.18, 0.0), 0.03, 0.4, (0.1, 1.4, 0.2)),
        "shin": CylinderSurface("shank", (0.0, 0.1, -0.01), 0.03, 0.4, (0.2, 1.5, 0.1)),
    }
    long = muscle(("thigh", (0.01, 0.05, -0.04)), ("shank", (0.0, -0.05, -0.035)))
    long.wraps = [Wrap("condyle"), Wrap("shin")]
    character.muscles = {"long": long, "hip": character.muscles["hip"]}
    rng = np.random.default_rng(3)
    q, v = np.zeros((POSES, 12)), rng.normal(size=(POSES, 4))
    q[:, 6] = 1.0
    q[:, 7:11] = from_rotation_vector(rng.normal(size=(POSES, 3), scale=0.6))
    q[:, 11] = rng.uniform(-1.2, 0.0, POSES)
    body = BodyModel(scene, "cpu")
    frames = body.muscle_frames(States(q, v, np.zeros((POSES, 4)), np.zeros((POSES, 0, 0))), slice(0, POSES))
    moves = [moving_bodies(scene, q, speeds) for speeds in [v, *np.tile(np.eye(4)[:, None], (1, POSES, 1))]]
    touch, last = route.touch, {}

    def noted(surface, *given, **named):
        found = touch(surface, *given, **named)
        if found.kind == THROUGH:
            last[surface.body] = found.first, found.second
        return found

    monkeypatch.setattr(route, "touch", noted)
    turned = 0
    for i in range(POSES):
        last.clear()
        poses = {name: (moves[0]["position"][i, k], moves[0]["orientation"][i, k])
                 for k, name in enumerate(("pelvis", "thigh", "shank"))}  # fmt: skip
        stops = route.route_stops(character, long, poses, {})
        on = [("thigh", "shank")[stop.point if stop.point >= 0 else stop.wrap] for stop in stops]
        places = [stop.place for stop in stops]
        for wrap, surface in enumerate(character.surfaces.values()):
            for stop, place in zip([k for k, one in enumerate(stops) if one.wrap == wrap], last.get(surface.body, ()),
                                   strict=False):  # fmt: skip
                along = rotate(from_rotation_vector(np.array(surface.orientation, float)), place)
                at, turn = poses[surface.body]
                places[stop] = at + rotate(turn, np.array(surface.position) + along)
        growth = np.array([grows(moved, i, on, [stop.place for stop in stops], places) for moved in moves])
        arms = np.zeros(4)
        for lever, (number, speed) in enumerate(zip(body.lever_muscle, body.lever_speed, strict=True)):
            arms[speed] += frames.moment_arm.numpy()[i, lever] * (number == 0)
        np.testing.assert_allclose(arms, -growth[1:, 0], atol=2e-6)
        assert frames.speed.numpy()[i, 0] == pytest.approx(growth[0].sum(), abs=5e-6)
        turned += np.abs(growth[1:4, 0]).max() > 1e-4
    assert turned > 10


def moving_bodies(scene, q: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
    """Bodies of a scene in some states, as `Stages.forward_kinematics` has them."""
    stages = Stages(scene, len(q), "cpu")
    stages.state.coordinates.assign(q.astype(np.float32))
    stages.state.speeds.assign(v.astype(np.float32))
    return {name: values.astype(float) for name, values in stages.forward_kinematics().items()}


def grows(moved: dict[str, np.ndarray], i: int, on: list[str], first: list, last: list) -> np.ndarray:
    """How fast segments grow, m/s: those from one body to another, and those within one."""
    found = np.zeros(2)
    bodies = [("pelvis", "thigh", "shank").index(name) for name in on]
    speed = [moved["velocity"][i, k] + np.cross(moved["angular_velocity"][i, k], place - moved["position"][i, k])
             for k, place in zip(bodies, last, strict=True)]  # fmt: skip
    for k in range(len(on) - 1):
        along = first[k + 1] - first[k]
        found[int(on[k] == on[k + 1])] += (speed[k + 1] - speed[k]) @ along / np.linalg.norm(along)
    return found


@pytest.mark.parametrize("joints", [3, LEVER_BITS + 3])
def test_a_route_over_any_number_of_joints_has_the_moment_arms_of_a_path_of_segments(joints: int):
    """A rope of vertebrae, and the same muscle twice: one has a point that always counts, which makes it a route."""
    bodies = {f"b{k}": Body(1.0, (0.01, 0.01, 0.01)) for k in range(joints + 1)}
    below, above = (0.0, -0.02, 0.0), (0.0, 0.02, 0.0)
    hinges = {
        f"j{k}": Joint("hinge", f"b{k}", f"b{k + 1}", below, above, [(1.0, 0.1 * (k % 3), 0.2)]) for k in range(joints)
    }
    middle = f"b{joints // 2}"
    places = [("b0", (0.01, 0.0, 0.03)), (middle, (0.02, 0.0, 0.04)), (f"b{joints}", (0.0, 0.0, 0.03))]
    muscles = {"segments": muscle(*places), "route": muscle(*places)}
    muscles["route"].path[1].condition = Condition("j0", -9.0, 9.0, 0.0)
    scene = Scene("rope", Character("b0", bodies, hinges, "fixed", muscles), failure=Failure(0.0, 0.0))
    stages = Stages(scene, 20, "cpu")
    q = stages.state.coordinates.numpy().copy()
    q[:, 7:] = np.random.default_rng(2).uniform(-0.1, 0.1, (20, joints))
    stages.state.coordinates.assign(q)
    paths = stages.muscle_paths()
    assert len(paths.muscle) == 2 * joints
    arms = [np.stack([paths.moment_arm[:, k] for k, m in enumerate(paths.muscle) if m == one]) for one in (0, 1)]
    assert np.linalg.norm(arms[0], axis=-1).min() > 1e-3
    axis = stages.forward_kinematics()["orientation"]
    for k in range(joints):  # what acts about the hinge: a route has no more
        own = rotate(axis[:, k + 1].astype(float), np.array(hinges[f"j{k}"].axes[0])[None])
        own /= np.linalg.norm(own, axis=-1, keepdims=True)
        about = [np.sum(arms[one][k] * own, axis=-1) for one in (0, 1)]
        np.testing.assert_allclose(about[1], about[0], atol=2e-7)
