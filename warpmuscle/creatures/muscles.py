"""Muscles of a creature: paths through boxes, cylinders about joints, and their free properties."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from warpmuscle.core.pose import about, multiply, normalized, rotate, rotation_vector
from warpmuscle.creatures.description import (
    Attachment,
    Bend,
    Creature,
    CreatureMuscle,
    Place,
    Range,
    is_paired,
    joint_of,
    sided,
)
from warpmuscle.creatures.skeleton import JOINT_AXIS, middle, place, rounded
from warpmuscle.scene import Character, CylinderSurface, Muscle, Surface, ViaPoint, Wrap
from warpmuscle.scene.initial_pose import Poses
from warpmuscle.scene.number import Free, Number
from warpmuscle.scene.wrapping.path import path_length
from warpmuscle.scene.wrapping.route import route_stops

NAMED_SIDES = {"front": (0.0, 0.0, 1.0), "back": (0.0, 0.0, -1.0), "up": (0.0, 1.0, 0.0), "down": (0.0, -1.0, 0.0)}
WRAPPING: Final = "mujoco"  # over several joints in their order, which keeps a path on its side of each of them
CYLINDER_LENGTH = 1.0  # m; paths never cross its ends
SLACK_RANGE = 1.0  # fibre lengths, by which a slack length may be less or more than where a search begins
LEAST_SLACK = 0.02  # of the length of the path
IN_PLANE = np.array([0.0, 1.0, 1.0])
CLEARANCE = 1e-6  # m; coordinates of a box closer than that are one number


def muscles(creature: Creature, character: Character, poses: Poses) -> Character:
    """A character with its muscles and the surfaces that they wrap around.

    Args:
        character: bodies and joints. poses: of the bodies in the standing pose, world.
    """
    made: dict[str, Muscle] = {}
    surfaces: dict[str, CylinderSurface] = {}
    for name, muscle in creature.muscles.items():
        names = [sided(name, side) for side in "lr"] if is_paired(creature, muscle) else [name]
        own = dict(_surfaces(creature, muscle, names[0], "l" if len(names) == 2 else ""))
        surfaces |= own
        made[names[0]] = _muscle(creature, muscle, names[0], _length(creature, character, muscle, own, poses))
        if len(names) == 2:
            for number, bend in enumerate(muscle.over):
                key = _surface_name(names[0], number)
                surfaces[_surface_name(names[1], number)] = _other_surface(creature, bend, surfaces[key], key)
            made[names[1]] = _other_side(creature, muscle, made[names[0]], *names)
    return Character(
        root=character.root, bodies=character.bodies, joints=character.joints, root_joint=character.root_joint,
        feet=character.feet, muscles=made, surfaces=dict(surfaces), wrapping=WRAPPING,
    )  # fmt: skip


def _surface_name(muscle: str, number: int) -> str:
    return f"{muscle}_{number}"


def _surfaces(
    creature: Creature, muscle: CreatureMuscle, name: str, side: str
) -> Iterator[tuple[str, CylinderSurface]]:
    """The cylinders of a muscle on the left, or in the middle, by name."""
    for number, bend in enumerate(muscle.over):
        segment, carrier = _jointed(creature, bend.joint)
        at = np.array(segment.start if segment.at is None else segment.at)
        parent = creature.segments[segment.parent]
        yield _surface_name(name, number), CylinderSurface(
            body=sided(carrier, side) if parent.paired else carrier,
            position=place(at - middle(parent)),
            radius=_within(bend.radius, bend.radius[0]), length=CYLINDER_LENGTH,
            orientation=_facing(creature, bend), side_point=(2.0 * bend.radius[1], 0.0, 0.0),
        )  # fmt: skip


def _jointed(creature: Creature, joint: str) -> tuple[Any, str]:
    for name, segment in creature.segments.items():
        if segment.parent and joint_of(name, segment) == joint:
            return segment, segment.parent
    raise AssertionError(joint)  # checked before


def _facing(creature: Creature, bend: Bend) -> Place:
    """Rotation vector of a cylinder along a joint's axis, whose own x is where the path goes round.

    That is across the line from the child's to the parent's bone in the middle of the joint's range, so that the path
    keeps to its side over the whole range. The name of the side only says which one of the two is meant.
    """
    segment, carrier = _jointed(creature, bend.joint)
    at = np.array(segment.start if segment.at is None else segment.at)
    assert segment.range is not None
    turned = about(np.array(JOINT_AXIS), np.array(0.5 * sum(segment.range)))
    inwards = normalized((middle(creature.segments[carrier]) - at) * IN_PLANE)
    outwards = normalized(rotate(turned, (middle(segment) - at) * IN_PLANE))
    across = np.cross(np.array(JOINT_AXIS), inwards - outwards)
    if across @ np.array(NAMED_SIDES[bend.side]) < 0.0:
        across = -across
    angle = np.arctan2(across[1], -across[2])  # from backwards
    along = about(np.array([0.0, 1.0, 0.0]), np.array(0.5 * np.pi))  # turns z to x, and x to backwards
    return place(rotation_vector(multiply(about(np.array(JOINT_AXIS), angle), along)))


def _other_surface(creature: Creature, bend: Bend, left: CylinderSurface, key: str) -> CylinderSurface:
    """The mirror image of a cylinder, as wide as that one."""
    _, carrier = _jointed(creature, bend.joint)
    x, y, z = left.position
    assert isinstance(x, float)
    radius = Free(same_as=f"character.surfaces.{key}.radius") if isinstance(left.radius, Free) else left.radius
    return CylinderSurface(
        body=sided(carrier, "r") if creature.segments[carrier].paired else carrier,
        position=(-x or 0.0, y, z), radius=radius, length=left.length, orientation=left.orientation,
        side_point=left.side_point,
    )  # fmt: skip


def _length(
    creature: Creature,
    character: Character,
    muscle: CreatureMuscle,
    surfaces: dict[str, CylinderSurface],
    poses: Poses,
) -> float:
    """Length of a path in the standing pose where a search begins, m."""
    side = "l" if is_paired(creature, muscle) else ""
    plain: dict[str, Surface] = {name: _plain_surface(surface) for name, surface in surfaces.items()}
    whole = Character(
        root=character.root, bodies=character.bodies, joints=character.joints, surfaces=plain, wrapping=WRAPPING
    )
    points = []
    for point in muscle.path:
        segment = creature.segments[point.on]
        on = sided(point.on, side) if segment.paired else point.on
        points.append(ViaPoint(body=on, position=place(np.array(start_of(point)) - middle(segment))))
    path = Muscle(path=points, wraps=[Wrap(surface=name) for name in surfaces], f_max=1.0, l_opt=1.0, l_slack=1.0)
    return path_length(route_stops(whole, path, poses, {}))


def _plain_surface(surface: CylinderSurface) -> CylinderSurface:
    radius = surface.radius.value if isinstance(surface.radius, Free) else surface.radius
    assert radius is not None
    return CylinderSurface(
        body=surface.body, position=surface.position, radius=radius, length=surface.length,
        orientation=surface.orientation, side_point=surface.side_point,
    )  # fmt: skip


def start_of(point: Attachment) -> Place:
    """Where a search begins, m, in the standing pose."""
    if point.start is not None:
        return point.start
    x, y, z = (0.5 * (a + b) for a, b in zip(point.low, point.high, strict=True))
    return (x, y, z)


def _muscle(creature: Creature, muscle: CreatureMuscle, name: str, length: float) -> Muscle:
    """The muscle on the left, or in the middle."""
    side = "l" if is_paired(creature, muscle) else ""
    low, high = (rounded(length * part) for part in muscle.l_opt)
    l_opt = _within((low, high), math.sqrt(low * high), log=True)
    fibre = muscle.fibre * (l_opt.value if isinstance(l_opt, Free) and l_opt.value is not None else low)
    least_slack = rounded(LEAST_SLACK * length)
    slack = max(length - fibre, least_slack)
    least, most = (rounded(slack + sign * SLACK_RANGE * fibre) for sign in (-1.0, 1.0))
    return Muscle(
        path=[_point(creature, point, side) for point in muscle.path],
        wraps=[Wrap(surface=_surface_name(name, number)) for number in range(len(muscle.over))],
        f_max=_within(muscle.f_max, math.sqrt(muscle.f_max[0] * muscle.f_max[1]), log=True),
        l_opt=l_opt, delay=muscle.delay,
        l_slack=_within((max(least, least_slack), min(most, rounded(1.1 * length))), slack),
    )  # fmt: skip


def _point(creature: Creature, point: Attachment, side: str) -> ViaPoint:
    """A point of a path, each coordinate free within its box."""
    segment = creature.segments[point.on]
    centre, start = middle(segment), start_of(point)
    x, y, z = (
        _within((rounded(low - c), rounded(high - c)), at - c)
        for low, high, at, c in zip(point.low, point.high, start, centre, strict=True)
    )
    return ViaPoint(body=sided(point.on, side) if segment.paired else point.on, position=(x, y, z))


def _other_side(creature: Creature, muscle: CreatureMuscle, left: Muscle, name: str, other: str) -> Muscle:
    """The mirror image of a muscle, whose numbers follow those of the left one."""
    key = f"character.muscles.{name}"
    path = []
    for number, (point, own) in enumerate(zip(muscle.path, left.path, strict=True)):
        assert own.position is not None
        x, y, z = (
            _follow(value, f"{key}.path.{number}.position.{axis}", -1.0 if axis == 0 else 1.0)
            for axis, value in enumerate(own.position)
        )
        on = sided(point.on, "r") if creature.segments[point.on].paired else point.on
        path.append(ViaPoint(body=on, position=(x, y, z)))
    return Muscle(
        path=path, wraps=[Wrap(surface=_surface_name(other, number)) for number in range(len(muscle.over))],
        f_max=_follow(left.f_max, f"{key}.f_max"), l_opt=_follow(left.l_opt, f"{key}.l_opt"),
        l_slack=_follow(left.l_slack, f"{key}.l_slack"), delay=left.delay,
    )  # fmt: skip


def _follow(number: Number, key: str, factor: float = 1.0) -> Number:
    """A number that follows one of the other side."""
    if isinstance(number, Free):
        return Free(same_as=key, factor=factor)
    return factor * number if number else 0.0


def _within(interval: Range, start: float, log: bool = False) -> Number:
    """A free parameter, or a number where the interval has no width."""
    low, high = interval
    value = rounded(min(max(start, low), high))
    if high - low < CLEARANCE:
        return value
    return Free(value, low, high, scale="log") if log else Free(value, low, high)
