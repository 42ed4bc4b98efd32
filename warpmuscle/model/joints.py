"""Types of joints on the device."""

from __future__ import annotations

from importlib import import_module

from warpmuscle.kernels import structs
from warpmuscle.kernels.joint_motion import MotionOf
from warpmuscle.scene import Character
from warpmuscle.scene.joints import TYPES, JointType, RootType, joint_type


def device_number(entry: JointType | RootType) -> int:
    """The number that stands for a type of joint in a model."""
    if entry.device:
        return int(getattr(structs, entry.device))
    kernels = [name for name, other in TYPES.items() if not other.device]
    return int(structs.FIRST_COORDINATE_JOINT) + kernels.index(entry.name)


def compiled_joints(character: Character) -> tuple[MotionOf, ...]:
    """What a step has compiled in for the joints of one coordinate that a character has."""
    present = {joint.type for joint in character.joints.values() if not joint_type(joint).device}
    found = []
    for name in TYPES:
        if name in present:
            module, _, function = TYPES[name].kernel.partition(":")
            found.append(MotionOf(device_number(TYPES[name]), getattr(import_module(module), function)))
    return tuple(found)
