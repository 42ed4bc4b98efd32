"""Bodies that run into each other: which ones are tested, and when an instance fails by it."""

import math

import msgspec
import numpy as np
import pytest
from scipy.optimize import lsq_linear

from warpmuscle.core.errors import SceneError
from warpmuscle.core.status import Status
from warpmuscle.formats import load, toml
from warpmuscle.model.collisions import TEST_TIME, capsule_of, collision_pairs, segment_distance
from warpmuscle.scene import (
    Body,
    Box,
    Capsule,
    Character,
    Failure,
    Ground,
    InitialState,
    Joint,
    JointState,
    Scene,
    Sphere,
)
from warpmuscle.scene.number import Free
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.rollout import Rollout

ZERO, X, Z = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
APART, LENGTH, RADIUS = 0.2, 0.5, 0.06  # m, between the hinges; of a leg's segment; of the leg


def two_legs(root_joint: str = "free", depth: object = 0.01, **changes) -> Scene:
    """Two legs on hinges below a body, beside each other; nothing else acts on them."""
    ends = (0.0, LENGTH / 2, 0.0), (0.0, -LENGTH / 2, 0.0)
    bodies = {"base": Body(50.0, (1.0, 1.0, 1.0), [Sphere((0.0, 0.3, 0.0), 0.1)])}
    bodies |= {name: Body(1.0, (0.1, 0.1, 0.1), [Capsule(*ends, RADIUS)]) for name in ("left", "right")}
    joints = {
        side + "Hip": Joint("hinge", "base", side, (x, 0.0, 0.0), (0.0, LENGTH / 2, 0.0), [Z])
        for side, x in (("left", APART / 2), ("right", -APART / 2))
    }
    scene = Scene("legs", Character("base", bodies, joints, root_joint))
    scene.initial_state = InitialState((0.3, 1.0, -0.2), (0.0, 0.0, 0.6, 0.8) if root_joint == "free" else (*ZERO, 1.0))
    scene.failure = Failure(com_height=0.0, heading=0.0, self_collision=depth)
    scene.ground, scene.gravity, scene.duration = Ground(stiffness=0.0), 0.0, 0.01
    for name, value in changes.items():
        setattr(scene, name, value)
    return scene


def outcome(scene: Scene, values: np.ndarray | None = None) -> np.ndarray:
    """Status of one instance, or of one a value of the only free parameter."""
    rollout = Rollout(scene, 1 if values is None else len(values), "cpu")
    if values is not None:
        rollout.set_parameters(values[:, None])
    rollout.run()
    return rollout.status()


def pairs_of(scene: Scene) -> set[tuple[str, str]]:
    return set(collision_pairs(scene, topology(scene.character)))


@pytest.mark.parametrize("root_joint", ["free", "planar", "fixed"])
def test_an_instance_fails_where_its_own_shapes_penetrate_by_more_than_the_limit(root_joint: str):
    scene = two_legs(root_joint)
    scene.character.bodies["left"].shapes[0].radius = Free(0.05, 0.0, 1.0)
    radii = np.array([0.0, 0.1, 0.1499, 0.1501, 0.3, 0.12])
    penetration = radii + RADIUS - APART
    expected = np.where(penetration > 0.01, Status.COLLIDED, Status.COMPLETED)
    np.testing.assert_array_equal(outcome(scene, radii), expected)


def test_the_limit_may_differ_by_instance_and_zero_switches_the_test_off():
    scene = two_legs(depth=Free(0.0, 0.0, 1.0))
    scene.character.bodies["left"].shapes[0].radius = 0.2  # 0.06 m deep
    scene.failure.self_collision_pairs = [("left", "right")]
    status = outcome(scene, np.array([0.0, 0.01, 0.0599, 0.0601, 0.5]))
    assert status.tolist() == [Status.COMPLETED, *[Status.COLLIDED] * 2, *[Status.COMPLETED] * 2]


def test_legs_that_turn_to_each_other_collide_when_their_ends_meet():
    speed = 5.0  # rad/s
    scene = two_legs("fixed", depth=0.02, duration=0.5)
    scene.initial_state.joints = {
        side + "Hip": JointState(angular_velocity=(0.0, 0.0, sign * speed))
        for side, sign in (("left", -1), ("right", 1))
    }
    rollout = Rollout(scene, 1, "cpu")
    rollout.run()
    assert rollout.status()[0] == Status.COLLIDED
    when = math.asin((APART / 2 - RADIUS + 0.01) / LENGTH) / speed
    assert when <= rollout.end_time()[0] <= when + TEST_TIME + scene.time_step


def test_off_by_default_and_without_effect_on_what_does_not_collide():
    scene = msgspec.structs.replace(load("walk56"), duration=0.2)
    assert scene.failure.self_collision == 0.0
    assert pairs_of(scene) == set()
    states = []
    for depth in (0.0, 0.02):
        scene.failure.self_collision = depth
        rollout = Rollout(scene, 2, "cpu")
        rollout.run()
        assert rollout.status().tolist() == [Status.COMPLETED] * 2
        states.append((rollout.state.coordinates.numpy(), rollout.state.speeds.numpy(), rollout.cost()))
    for off, on in zip(*states, strict=True):
        np.testing.assert_array_equal(off, on)


def test_a_walk_fails_whose_legs_run_through_each_other():
    scene = msgspec.structs.replace(load("walk56"), duration=0.05)
    scene.failure = Failure(com_height=0.0, heading=0.0, self_collision=0.01)
    for hip, angle in (("lHip", -0.35), ("rHip", 0.35)):
        scene.initial_state.joints[hip] = JointState((0.0, 0.0, np.sin(angle / 2), np.cos(angle / 2)))
    scene.failure.self_collision_pairs = [("lLowerleg", "rLowerleg"), ("lUpperleg", "rUpperleg")]
    assert outcome(scene).tolist() == [Status.COLLIDED]
    scene.failure.self_collision_pairs = [("head", "rLowerleg")]
    assert outcome(scene).tolist() == [Status.COMPLETED]


def test_distances_of_segments_are_those_of_bounded_least_squares():
    random, count = np.random.default_rng(1), 60
    middle, half_a, half_b = random.normal(size=(3, count, 3)) * np.array([0.6, 1.0, 1.0])[:, None, None]
    half_a[:5] = 0.0
    expected = [  # |m + t b - s a| at its least for s, t within -1..1
        np.sqrt(2.0 * lsq_linear(np.stack([-a, b], axis=1), -m, (-1.0, 1.0), tol=1e-14).cost)
        for m, a, b in zip(middle, half_a, half_b, strict=True)
    ]
    np.testing.assert_allclose(segment_distance(middle, half_a, half_b), expected, atol=1e-6)


def test_all_bodies_are_paired_but_those_that_a_joint_joins():
    pairs = pairs_of(two_legs())
    assert pairs == {("left", "right")}
    scene = load("fwalk")
    scene.failure.self_collision = 0.02
    assert ("lLowerleg", "rLowerleg") in pairs_of(scene)
    assert len(pairs_of(scene)) == 15 * 14 // 2 - 14  # and no two with a common neighbour overlap


def test_neighbours_of_one_body_are_not_paired_if_they_overlap_in_the_initial_pose():
    scene = two_legs()
    scene.character.bodies["third"] = Body(1.0, (0.1, 0.1, 0.1), [Sphere((0.0, 0.0, 0.1), 0.02), Sphere(ZERO, 0.03)])
    scene.character.joints["thirdHip"] = Joint("fixed", "base", "third", ZERO, (0.0, LENGTH / 4, 0.0))
    assert pairs_of(scene) == {("left", "right"), ("left", "third"), ("right", "third")}
    turn = 0.15  # rad, towards the middle
    scene.initial_state.joints["leftHip"] = JointState((0.0, 0.0, -math.sin(turn / 2), math.cos(turn / 2)))
    assert pairs_of(scene) == {("left", "right"), ("right", "third")}


def test_a_box_is_the_capsule_inside_it_along_its_longest_edge():
    middle, half, radius = capsule_of(Box((-1.0, 0.0, -0.1), (1.0, 0.4, 0.5)))
    np.testing.assert_allclose(middle, [[0.0, 0.2, 0.2]])
    np.testing.assert_allclose(half, [[0.8, 0.0, 0.0]])
    np.testing.assert_allclose(radius, [0.2])


def test_a_box_may_be_longest_elsewhere_in_each_instance():
    middle, half, radius = capsule_of(Box(ZERO, (np.array([1.0, 2.0, 8.0]), 4.0, 2.0)))
    np.testing.assert_allclose(middle, [[0.5, 2.0, 1.0], [1.0, 2.0, 1.0], [4.0, 2.0, 1.0]])
    np.testing.assert_allclose(half, [[0.0, 1.5, 0.0], [0.0, 1.0, 0.0], [3.0, 0.0, 0.0]])
    np.testing.assert_allclose(radius, [0.5, 1.0, 1.0])


def test_a_scene_without_two_shapes_that_could_meet_is_an_error():
    scene = two_legs()
    scene.character.bodies["left"].shapes = []
    with pytest.raises(SceneError, match=r"failure\.self_collision: no two bodies with shapes could collide"):
        Rollout(scene, 1, "cpu")


def test_more_shapes_than_there_is_room_for_are_an_error():
    scene = two_legs()
    scene.character.bodies["left"].shapes *= 20
    with pytest.raises(SceneError, match=r"21 shapes may collide, more than the 20"):
        Rollout(scene, 1, "cpu")


def test_limit_and_pairs_are_written_and_read_back_equal():
    failure = Failure(self_collision=Free(0.01, 0.0, 0.02), self_collision_pairs=[("left", "right"), ("left", "base")])
    scene = two_legs(failure=failure)
    assert toml.loads(toml.dumps(scene)) == scene
