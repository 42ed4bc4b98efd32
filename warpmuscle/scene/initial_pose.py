"""Where the bodies of a character are in the initial pose, as far as the host has to know."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import about, multiply, normalized, rotate, twist_angle, universal_coordinates
from warpmuscle.scene import Joint, JointState, Scene
from warpmuscle.scene.number import Number
from warpmuscle.scene.topology import topology


def initial_pose(scene: Scene) -> tuple[dict[str, tuple[Floats, Floats]], dict[str, Floats]]:
    """Position, m, and orientation of every body in the root's frame, and the angles, rad, of every joint.

    Args:
        scene: checked scene without free parameters.
    """
    character = scene.character
    poses: dict[str, tuple[Floats, Floats]] = {character.root: (np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]))}
    angles = {}
    for name in topology(character).joints:
        joint = character.joints[name]
        turn, angles[name] = _joint_turn(joint, scene.initial_state.joints.get(name, JointState()))
        position, orientation = poses[joint.parent]
        anchor = position + rotate(orientation, plain_vector(joint.position_in_parent))
        turned = multiply(orientation, turn)
        poses[joint.child] = np.asarray(anchor - rotate(turned, plain_vector(joint.position_in_child))), turned
    return poses, angles


def _joint_turn(joint: Joint, state: JointState) -> tuple[Floats, Floats]:
    """The child's orientation in its parent, as far as the joint can turn, and the joint's angles, rad."""
    q = normalized(plain_vector(state.orientation))
    axes = [normalized(plain_vector(axis)) for axis in joint.axes]
    if joint.type == "hinge":
        angle = twist_angle(q, axes[0])
        return about(axes[0], angle), angle[None]
    if joint.type == "universal":
        angles, _ = universal_coordinates(q, np.zeros(3), *axes)
        return multiply(about(axes[1], angles[1]), about(axes[0], angles[0])), angles
    return (q if joint.type == "ball" else np.array([0.0, 0.0, 0.0, 1.0])), np.zeros(0)


def plain_vector(numbers: Sequence[Number]) -> Floats:
    """Numbers of a scene that has no free parameters as an array."""
    return np.array([plain_number(number) for number in numbers])


def plain_number(number: Number) -> float:
    """A number of a scene that has no free parameters."""
    assert isinstance(number, int | float)
    return float(number)
