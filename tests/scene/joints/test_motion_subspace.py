"""The motion subspace of every type of joint, against differences of its pose in float64."""

import numpy as np
import pytest

from warpmuscle.core.pose import conjugate, multiply, normalized, rotate
from warpmuscle.scene import Displacement, Joint
from warpmuscle.scene.joints import TYPES, JointType

ZERO = (0.0, 0.0, 0.0)
STEP = 1.0e-5  # s


def joint_of(kind: JointType) -> Joint:
    """A joint of a type about oblique axes."""
    joint = Joint(kind.name, "a", "b", ZERO, ZERO, [(0.3, -0.8, 0.5), (0.9, 0.2, -0.4)][: kind.axes])
    if kind.displaced:
        wave = Displacement((0.5, 0.1, 0.9), x=[-3.0, -1.0, 0.2, 1.0, 3.0], y=[0.3, -0.2, 0.1, 0.4, -0.1])
        joint.rotations = [Displacement((0.3, -0.8, 0.5), 0.2, 1.1), wave]
        joint.translations = [Displacement((0.9, 0.2, -0.4), slope=0.05), wave]
    return joint


def moved(kind: JointType, q: np.ndarray, v: np.ndarray, time: float) -> np.ndarray:
    """Coordinates after a time at constant speeds; those of a quaternion turn about the child's axes."""
    if not kind.quaternion:
        return q + time * v
    half = 0.5 * time * np.linalg.norm(v, axis=1, keepdims=True)
    axis = v / np.linalg.norm(v, axis=1, keepdims=True)
    return multiply(normalized(q), np.concatenate([np.sin(half) * axis, np.cos(half)], axis=1))


@pytest.mark.parametrize("name", sorted(TYPES))
def test_velocity_and_its_rate_are_the_differences_of_the_pose(name: str):
    kind, rng = TYPES[name], np.random.default_rng(3)
    joint = joint_of(kind)
    q, v = rng.normal(size=(20, len(kind.coordinates))), rng.normal(size=(20, len(kind.speeds)))
    before, here, after = (kind.motion(joint, moved(kind, q, v, k * STEP), v) for k in (-1.0, 0.0, 1.0))
    turned = multiply(after.orientation, conjugate(before.orientation))
    turned = turned * np.sign(turned[:, 3:])
    zero = np.zeros((20, 3))

    def rates(axes: list[np.ndarray]) -> np.ndarray:
        return sum((axis * v[:, i : i + 1] for i, axis in enumerate(axes)), start=zero)

    np.testing.assert_allclose(rates(here.turning), turned[:, :3] / STEP, atol=1e-8)
    np.testing.assert_allclose(rates(here.moving), (after.place - before.place) / (2.0 * STEP), atol=1e-8)
    for drift, axes in (("turning_drift", "turning"), ("moving_drift", "moving")):
        change = (rates(getattr(after, axes)) - rates(getattr(before, axes))) / (2.0 * STEP)
        np.testing.assert_allclose(getattr(here, drift), change, atol=1e-7)


@pytest.mark.parametrize("name", sorted(TYPES))
def test_coordinates_come_back_from_the_pose(name: str):
    kind, rng = TYPES[name], np.random.default_rng(4)
    joint = joint_of(kind)
    q, v = rng.uniform(-1.0, 1.0, (20, len(kind.coordinates))), rng.normal(size=(20, len(kind.speeds)))
    if kind.quaternion:
        q = normalized(q)
    motion = kind.motion(joint, q, v)
    angular = sum((axis * v[:, i : i + 1] for i, axis in enumerate(motion.turning)), start=np.zeros((20, 3)))
    if kind.by_coordinate:
        np.testing.assert_allclose(kind.shown(joint, motion.orientation, motion.place), q, atol=1e-7)
        return
    found = kind.nearest(joint, motion.orientation, angular)
    np.testing.assert_allclose(found[0], q, atol=1e-9)
    np.testing.assert_allclose(found[1], v, atol=1e-9)
    shown = kind.shown(joint, motion.orientation, motion.place)
    same = kind.turned(joint, shown)
    np.testing.assert_allclose(rotate(same, np.ones(3)), rotate(motion.orientation, np.ones(3)), atol=1e-9)
