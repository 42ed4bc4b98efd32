"""Moment arms over joint angles against differences of path lengths, and muscles that cannot act."""

import numpy as np
import pytest

from muscle_arm import arm, muscle
from warpmuscle.core.pose import about, multiply
from warpmuscle.formats import load
from warpmuscle.scene import JointState, Scene
from warpmuscle.scene.joints import TYPES
from warpmuscle.scene.number import Free
from warpmuscle.simulation.stages import Stages
from warpmuscle.studies.moment_arms import moment_arms, muscle_geometry, useless_muscles

STEP = 4e-3  # rad


def length(scene: Scene, orientation: np.ndarray) -> np.ndarray:
    """Path lengths with an arm's elbow in these orientations (n, 4)."""
    n, zero = len(orientation), np.zeros((len(orientation), 3))
    stages = Stages(scene, n, "cpu")
    root = np.tile([0.0, 0.0, 0.0, 1.0], (n, 1))
    stages.set_state(zero, root, zero, zero, orientation[:, None], np.zeros((n, 1, 3)))
    return stages.muscle_paths().length.astype(float)


def turned(scene: Scene, axis: int, angle: np.ndarray) -> np.ndarray:
    """Orientations (n, 4) of the elbow; the other angle of a universal joint does not change and is not zero."""
    joint = scene.character.joints["elbow"]
    if joint.type == "ball":
        return about(np.eye(3)[axis], angle)
    axes = [np.array(given) / np.linalg.norm(given) for given in joint.axes]
    if joint.type == "hinge":
        return about(axes[0], angle)
    angles = [np.full_like(angle, 0.3), np.full_like(angle, 0.3)]
    angles[axis] = angle
    return multiply(about(axes[1], angles[1]), about(axes[0], angles[0]))


@pytest.mark.parametrize(
    ("kind", "axis"), [(k, i) for k in ("hinge", "universal", "ball") for i in range(len(TYPES[k].speeds))]
)
def test_moment_arms_are_minus_the_derivatives_of_the_length(kind: str, axis: int):
    scene = arm(kind)
    scene.character.muscles["aside"] = muscle(("base", (0.06, 0.1, 0.01)), ("tip", (0.04, 0.15, 0.03)))
    scene.initial_state.joints = {"elbow": JointState(tuple(turned(scene, axis, np.zeros(1))[0].tolist()))}
    angles = np.linspace(-0.8, 0.9, 9)
    ahead, behind = (length(scene, turned(scene, axis, angles + d)) for d in (STEP, -STEP))
    got = moment_arms(scene, "elbow", axis, angles)
    assert (got.joint, got.axis, got.muscles) == ("elbow", axis, ("flexor", "extensor", "aside"))
    assert np.array_equal(got.angle, angles)
    expected = -(ahead - behind) / (2.0 * STEP)
    assert np.abs(expected).max() > 0.01
    np.testing.assert_allclose(got.arm, expected, atol=1e-4)


def test_muscle_in_front_turns_a_hanging_arm_forwards_and_the_one_behind_backwards():
    """A turn by a positive angle about x, which points to the left, takes what hangs backwards."""
    front, behind = moment_arms(arm(), "elbow", 0, np.zeros(1)).arm[0]
    assert front == pytest.approx(-behind, abs=1e-6)
    assert front < -0.03


def test_free_numbers_count_with_their_start_values():
    scene = arm()
    expected = moment_arms(scene, "elbow", 0, np.zeros(2)).arm
    for path in (own.path for own in scene.character.muscles.values()):
        x, y, z = path[0].position
        path[0].position = (x, Free(y, 0.0, 1.0), z)
    assert np.array_equal(moment_arms(scene, "elbow", 0, np.zeros(2)).arm, expected)


def test_muscle_through_the_centre_of_a_joint_is_useless():
    scene = arm()
    places = ("base", (0.0, 0.2, 0.0)), ("base", (0.0, 0.0, 0.0)), ("tip", (0.0, 0.0, 0.0))
    scene.character.muscles["through"] = muscle(*places)
    ((name, joint, greatest),) = useless_muscles(scene)
    assert (name, joint) == ("through", "elbow")
    assert greatest < 1e-4


def test_no_muscle_of_the_biped_is_useless():
    assert useless_muscles(load("walk56")) == []


@pytest.mark.parametrize("kind", ["hinge", "universal", "ball"])
def test_lengths_and_arms_of_poses_are_those_of_virtual_work(kind: str):
    """Arms are minus the derivatives of lengths by a turn about each degree of freedom, of a ball the child's axes."""
    scene = arm(kind)
    scene.character.muscles["aside"] = muscle(("base", (0.06, 0.1, 0.01)), ("tip", (0.04, 0.15, 0.03)))
    names = Stages(scene, 1, "cpu").names
    first, end = names.coordinate_start[1], names.coordinate_start[2]
    poses = np.zeros((5, end))
    poses[:, 6:first] = 1.0  # the root's orientation
    if kind == "ball":
        poses[:, first:end] = multiply(about(np.eye(3)[0], np.linspace(-0.6, 0.7, 5)), about(np.eye(3)[1], 0.3))
    else:
        poses[:, first:end] = np.random.default_rng(3).uniform(-0.6, 0.6, (5, end - first))
    lengths, arms = muscle_geometry(scene, poses)
    assert lengths.shape == (5, 3)
    for axis in range(names.speeds - names.speed_start[1]):
        turned_by = []
        for step in (STEP, -STEP):
            moved = poses.copy()
            if kind == "ball":
                moved[:, first:end] = multiply(poses[:, first:end], about(np.eye(3)[axis], step))
            else:
                moved[:, first + axis] += step
            turned_by.append(muscle_geometry(scene, moved)[0])
        expected = -(turned_by[0] - turned_by[1]) / (2.0 * STEP)
        np.testing.assert_allclose(arms[:, :, names.speed_start[1] + axis], expected, atol=1e-4)
        assert np.abs(expected).max() > 0.003
