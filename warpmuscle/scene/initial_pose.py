"""Where the bodies of a character are in the initial pose, as far as the host has to know."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import multiply, rotate
from warpmuscle.scene import JointState, Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.number import Number
from warpmuscle.scene.topology import topology


def initial_pose(scene: Scene) -> tuple[dict[str, tuple[Floats, Floats]], dict[str, Floats]]:
    """Position, m, and orientation of every body in the root's frame, and the angles, rad, of every joint.

    Args:
        scene: checked scene without free parameters.
    """
    character = scene.character
    poses: dict[str, tuple[Floats, Floats]] = {character.root: (np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]))}
    angles, moved = {}, {}
    for name in topology(character).joints:
        joint = character.joints[name]
        kind = joint_type(joint)
        q, v = kind.start(joint, scene.initial_state.joints.get(name, JointState()))
        moved[name], angles[name] = (q, v), kind.angles_of(joint, q)[0]
        motion = kind.motion(joint, *moved[joint.follows or name])
        position, orientation = poses[joint.parent]
        anchor = position + rotate(orientation, plain_vector(joint.position_in_parent) + motion.place[0])
        turned = multiply(orientation, motion.orientation[0])
        poses[joint.child] = np.asarray(anchor - rotate(turned, plain_vector(joint.position_in_child))), turned
    return poses, angles


def plain_vector(numbers: Sequence[Number]) -> Floats:
    """Numbers (n,) of a scene that has no free parameters as an array (n,)."""
    return np.array([plain_number(number) for number in numbers])


def plain_number(number: Number) -> float:
    """A number of a scene that has no free parameters."""
    assert isinstance(number, int | float)
    return float(number)
