"""Bodies and types of joints on the device: numbers, and what is compiled in for them."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import warp as wp

from warpmuscle.core.errors import Error
from warpmuscle.kernels import structs
from warpmuscle.kernels.body.joint_motion import MotionOf, turning_motion
from warpmuscle.kernels.body.joint_stages import SkeletonKind
from warpmuscle.kernels.contact.contact_laws import LAWS
from warpmuscle.kernels.contact.terrain import BOUNDED, FLAT, PATCHED, RISES, WALLED
from warpmuscle.scene import Body, Character, Ground, Joint
from warpmuscle.scene.constraints.pose import ROWS, row_count
from warpmuscle.scene.joints import TYPES, JointType, RootType, joint_type, root_type
from warpmuscle.scene.masses import is_zero
from warpmuscle.scene.terrain.surface import is_bounded, walls_of
from warpmuscle.scene.topology import Topology, followed_drivers, followers, topology


def root_number(character: Character) -> int:
    """The number that stands for the type of a character's root in a model."""
    return _number(root_type(character))


def joint_number(name: str, character: Character) -> int:
    """The number that stands for the type of a joint in a model; of a hinge, also for whether others follow it."""
    entry = joint_type(character.joints[name])
    driving = entry.device == "HINGE" and bool(followers(character, name))
    return int(structs.DRIVING_HINGE) if driving else _number(entry)


def by_coordinate(name: str, character: Character) -> bool:
    """Whether a joint is one of those that are as in `kernels.body.coordinate_joint` on the device."""
    return joint_number(name, character) >= int(structs.FIRST_COORDINATE_JOINT)


def compiled_skeleton(character: Character, ground: Ground | None = None) -> SkeletonKind:
    """What a step has compiled in for the bodies and joints of a character, and for their contacts with the ground."""
    ground = ground or Ground()
    motions = {}
    for name, joint in character.joints.items():
        number = joint_number(name, character)
        if number == structs.DRIVING_HINGE:
            motions[number] = turning_motion
        elif joint_type(joint).by_coordinate:
            motions[number] = motion_of(joint_type(joint))
    joints = tuple(MotionOf(number, motions[number]) for number in sorted(motions))
    names = topology(character)
    followed = len(followed_drivers(character, names))
    entries = sum(map(len, acting_unknowns(character, names)))
    rows = row_count(character)
    single = all(len(joint_type(joint).speeds) < 2 for joint in character.joints.values())
    turned = any(map(has_turned_axes, character.bodies.values()))
    return SkeletonKind(
        joints, turned, LAWS[ground.law], followed, rows, compiled_terrain(ground),
        any(map(resists, character.joints.values())), ground.treadmill is not None,
        any(joint.beside for joint in character.joints.values()),
        entries, single and followed + rows > 0,
    )  # fmt: skip


def motion_of(entry: JointType) -> Any:
    """The Warp function of a type's motion; raises Error if what it names is none."""
    module, _, name = entry.kernel.partition(":")
    try:
        function = getattr(import_module(module), name, None)
    except (ModuleNotFoundError, ValueError):
        function = None
    if not isinstance(function, wp.Function):
        raise Error(f"joint type {entry.name!r}: its kernel {entry.kernel!r} is not a Warp function 'module:function'")
    return function


def acting_unknowns(character: Character, names: Topology) -> list[list[int]]:
    """The unknowns that stay open to the root and act on each body, or on one that hangs on it; on the root all do.

    Followed coordinates come first, then the rows of constraints (see `kernels.body.followed`).
    """
    drivers = followed_drivers(character, names)
    moved = [{drivers.index(driver)} if driver in drivers else set[int]() for driver in names.driver]
    first = len(drivers)
    for one in character.constraints.values():
        for end in (one.body, one.other_body):
            moved[names.bodies.index(end)] |= set(range(first, first + ROWS[one.type]))
        first += ROWS[one.type]
    for body in range(len(moved) - 1, 0, -1):
        moved[names.parents[body]] |= moved[body]
    moved[0] = set(range(first))
    return [sorted(of_body) for of_body in moved]


def compiled_terrain(ground: Ground) -> int:
    """What a step has compiled in for ground that is not flat."""
    if ground.terrain is None:
        return int(FLAT)
    tiles = ground.terrain.tiles
    walls = WALLED if any(map(walls_of, tiles)) else FLAT
    bounds = BOUNDED if any(map(is_bounded, tiles)) else FLAT
    return int((PATCHED if any(tile.patches for tile in tiles) else RISES) + walls + bounds)


def has_turned_axes(body: Body) -> bool:
    """Whether the principal axes of a body, in some instance, are not those of its frame."""
    return not all(map(is_zero, body.inertia_axes[:3]))


def resists(joint: Joint) -> bool:
    """Whether a joint has armature or damping of its own, in some instance."""
    return not (is_zero(joint.armature) and is_zero(joint.damping))


def _number(entry: JointType | RootType) -> int:
    if entry.device:
        return int(getattr(structs, entry.device))
    kernels = [name for name, other in TYPES.items() if not other.device]
    return int(structs.FIRST_OF_TABLE) + kernels.index(entry.name)
