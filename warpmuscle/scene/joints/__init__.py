"""The table of joint types: what the host must know of each, in one entry.

`joint_type(joint)` and `root_type(character)` give the entry; no other code asks for a type's name. An entry is a
`JointType`: how many coordinates, speeds, axes and limits, their names, how coordinates follow from orientation and
angular velocity and the other way round, the motion subspace with its rate, what is checked, what MuJoCo and the
original program call it, and which constant of `kernels.structs` stands for it on the device.

May import: core, scene.
To add: a type, as a `JointType` in a file here, and into `TYPES`.
"""

from __future__ import annotations

from warpmuscle.scene import Character, Joint
from warpmuscle.scene.joints.coordinate import SLIDE
from warpmuscle.scene.joints.joint_type import JointType as JointType
from warpmuscle.scene.joints.joint_type import Motion as Motion
from warpmuscle.scene.joints.roots import FIXED_ROOT, FREE, PLANAR
from warpmuscle.scene.joints.roots import RootType as RootType
from warpmuscle.scene.joints.turning import BALL, FIXED, HINGE, UNIVERSAL

TYPES: dict[str, JointType] = {entry.name: entry for entry in (BALL, UNIVERSAL, HINGE, FIXED, SLIDE)}
ROOT_TYPES: dict[str, RootType] = {entry.name: entry for entry in (FREE, PLANAR, FIXED_ROOT)}


def joint_type(joint: Joint) -> JointType:
    """The entry of a joint of a checked scene."""
    return TYPES[joint.type]


def root_type(character: Character) -> RootType:
    """The entry of the root of a character."""
    return ROOT_TYPES[character.root_joint]
