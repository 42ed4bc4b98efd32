"""Where joints are in a recorded motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import rows
from warpmuscle.core.pose import conjugate, normalized, rotate
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Character
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.joints.joint_type import JointType


def joint_angles(motion: Recording, character: Character, name: str, breaks: ArrayLike = ()) -> Floats:
    """The angles of a joint in all frames, (F, A), rad or m, as its type shows them.

    Args:
        character: without free parameters. breaks: frames at which other motions begin.
    """
    joint = character.joints[name]
    entry, orientation = joint_type(joint), normalized(motion.joint_orientation[:, motion.joint_names.index(name)])
    turns = type(entry).shown is JointType.shown  # which looks at no place
    place = np.zeros((len(orientation), 3)) if turns else joint_places(motion, character, name)
    return entry.shown(joint, orientation, place, breaks)


def joint_places(motion: Recording, character: Character, name: str) -> Floats:
    """How far the child's joint point is from that of the parent in all frames, (F, 3) m, along the parent's axes."""
    joint = character.joints[name]
    parent, child = (motion.body_names.index(body) for body in (joint.parent, joint.child))
    turned = normalized(motion.body_orientation[:, [parent, child]])
    point = motion.body_position[:, child] + rotate(turned[:, 1], rows(joint.position_in_child))
    away = rotate(conjugate(turned[:, 0]), point - motion.body_position[:, parent])
    return np.asarray(away - rows(joint.position_in_parent))
