"""Musculotendon paths as a kernel wants them: points and segments by number, and which muscle acts on which joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.arrays import rows, to_device
from warpmuscle.bodies import stacked
from warpmuscle.errors import SceneError
from warpmuscle.kernels import path as kernel
from warpmuscle.number import Number, Vector
from warpmuscle.scene import Character, Part
from warpmuscle.topology import SPEEDS, Topology

ZERO = (0.0, 0.0, 0.0)


class Condition(Part):
    """The interval of a joint angle in which a via point counts; the path slides on and off it about both ends."""

    joint: str  # a hinge or a universal joint
    low: Number  # rad
    high: Number
    blend: Number = 0.1  # rad, width of the transition about each end
    axis: int = 0  # which angle of a universal joint


class ViaPoint(Part):
    """A point of a muscle's path, fixed to a body."""

    body: str
    position: Vector  # m, in the body's frame: from its centre of mass
    condition: Condition | None = None  # never for the first and the last point


MusclePath = Sequence[ViaPoint]


@dataclass(frozen=True)
class Crossing:
    """A muscle that acts on a joint, and through which segments."""

    joint: int  # number of the body that the joint carries
    muscle: int
    terms: tuple[tuple[int, int], ...]  # segment; 1 if it ends beyond the joint, -1 if it starts there, else 0


@dataclass(frozen=True)
class PathTable:
    """Paths of all muscles by number, one behind the other; see `kernels.path.Paths`."""

    muscles: tuple[str, ...]
    points: tuple[ViaPoint, ...]
    start: list[int] = field(default_factory=lambda: [0])  # (muscles + 1,)
    segments: list[tuple[int, int]] = field(default_factory=list)
    segment_start: list[int] = field(default_factory=lambda: [0])  # (muscles + 1,)
    crossings: list[Crossing] = field(default_factory=list)  # sorted by joint, then by muscle

    def conditional(self, segment: int) -> list[Condition]:
        """The conditions that the weight of a segment depends on."""
        a, b = self.segments[segment]
        return [c for c in (point.condition for point in self.points[a : b + 1]) if c is not None]


def path_table(paths: Mapping[str, MusclePath], names: Topology, character: Character) -> PathTable:
    """Number points and segments, and find the muscles that act on each joint; fixed joints have none.

    Raises:
        SceneError: an unknown body or joint, fewer than two points, or a condition that cannot be used.
    """
    for muscle, path in paths.items():
        _check(f"muscles.{muscle}.path", path, names, character)
    table = PathTable(tuple(paths), tuple(point for path in paths.values() for point in path))
    for path in paths.values():
        first = table.start[-1]
        table.start.append(first + len(path))
        table.segments.extend((first + a, first + b) for a, b in _segments(path))
        table.segment_start.append(len(table.segments))
    movable = [i for i, joint in enumerate(names.joints, 1) if character.joints[joint].type != "fixed"]
    for joint in movable:
        beyond = _beyond(joint, names)
        for muscle_number in range(len(paths)):
            segments = range(table.segment_start[muscle_number], table.segment_start[muscle_number + 1])
            terms = tuple(term for segment in segments for term in _terms(segment, joint, beyond, table, names))
            if terms:
                table.crossings.append(Crossing(joint, muscle_number, terms))
    return table


def _check(key: str, path: MusclePath, names: Topology, character: Character) -> None:
    if len(path) < 2:
        raise SceneError(f"a path needs at least two points, got {len(path)}", key=key)
    for index, point in enumerate(path):
        place, condition = f"{key}.{index}", point.condition
        if point.body not in names.bodies:
            raise SceneError(f"there is no body {point.body!r}", key=f"{place}.body")
        if condition is None:
            continue
        place += ".condition"
        if index in (0, len(path) - 1):
            raise SceneError("the first and the last point of a path take no condition", key=place)
        if condition.joint not in names.joints:
            raise SceneError(f"there is no joint {condition.joint!r}", key=f"{place}.joint")
        kind = character.joints[condition.joint].type
        if kind not in ("hinge", "universal"):
            raise SceneError(f"a {kind} joint has no angle for a condition", key=f"{place}.joint")
        if not 0 <= condition.axis < SPEEDS[kind]:
            raise SceneError(f"a {kind} joint has no angle {condition.axis}", key=f"{place}.axis")
        if np.any(rows(condition.low) >= rows(condition.high)):
            raise SceneError("low is not less than high", key=f"{place}.low")
        if np.any(rows(condition.blend) <= 0.0):
            raise SceneError("the blend must be positive", key=f"{place}.blend")


def _segments(path: MusclePath) -> list[tuple[int, int]]:
    """All pairs of points of a path with none but conditional points between them, in order."""
    pairs = []
    for a in range(len(path) - 1):
        for b in range(a + 1, len(path)):
            pairs.append((a, b))
            if path[b].condition is None:
                break
    return pairs


def _beyond(joint: int, names: Topology) -> set[str]:
    """Names of the bodies that a joint carries."""
    carried = {joint}
    for body in range(joint + 1, len(names.bodies)):
        if names.parents[body] in carried:
            carried.add(body)
    return {names.bodies[body] for body in carried}


def _terms(segment: int, joint: int, beyond: set[str], table: PathTable, names: Topology) -> list[tuple[int, int]]:
    """What a segment contributes to a joint: itself and the sign of its moment arm, or nothing."""
    a, b = (table.points[number].body in beyond for number in table.segments[segment])
    hangs = any(condition.joint == names.joints[joint - 1] for condition in table.conditional(segment))
    return [(segment, int(b) - int(a))] if a != b or hangs else []


def paths_struct(paths: Mapping[str, MusclePath], names: Topology, character: Character, device: Any) -> kernel.Paths:
    """The device structure of the paths of all muscles, by name (see `kernels.path.Paths`).

    Args:
        paths: numbers are floats, or (n,) arrays with one value an instance.

    Raises:
        SceneError: see `path_table`.
    """
    table = path_table(paths, names, character)
    offsets = [ZERO, *(character.joints[name].position_in_child for name in names.joints)]
    bodies = [names.bodies.index(point.body) for point in table.points]
    points = [rows(point.position) - rows(offsets[body]) for point, body in zip(table.points, bodies, strict=True)]
    conditions = [point.condition for point in table.points if point.condition is not None]
    numbers = iter(range(len(conditions)))
    terms = [term for crossing in table.crossings for term in crossing.terms]
    by_muscle = [
        [i for i, crossing in enumerate(table.crossings) if crossing.muscle == muscle]
        for muscle in range(len(table.muscles))
    ]
    joints = [crossing.joint for crossing in table.crossings]

    p = kernel.Paths()
    p.muscle_count = len(table.muscles)
    p.start = to_device(table.start, int, device)
    p.point_body = _numbers(bodies, device)
    p.point = to_device(stacked(points or [rows(ZERO)]), wp.vec3, device)
    p.point_condition = _numbers([-1 if q.condition is None else next(numbers) for q in table.points], device)
    p.condition_joint = _numbers([names.body_of_joint(c.joint) for c in conditions], device)
    p.condition_axis = _numbers([c.axis for c in conditions], device)
    p.condition_interval = to_device(rows([[c.low, c.high, c.blend] for c in conditions] or [ZERO]), wp.vec3, device)
    p.segment_start = to_device(table.segment_start, int, device)
    p.segment = to_device(table.segments or [(0, 0)], int, device)
    p.segment_varies = _numbers([int(bool(table.conditional(i))) for i in range(len(table.segments))], device)
    p.crossing_start = to_device(np.searchsorted(joints, np.arange(len(names.bodies) + 1)), int, device)
    p.crossing_joint = _numbers(joints, device)
    p.crossing_muscle = _numbers([crossing.muscle for crossing in table.crossings], device)
    p.term_start = to_device(_starts([crossing.terms for crossing in table.crossings]), int, device)
    p.term_segment = _numbers([segment for segment, _ in terms], device)
    p.term_sign = _numbers([sign for _, sign in terms], device)
    p.muscle_crossing_start = to_device(_starts(by_muscle), int, device)
    p.muscle_crossing = _numbers([i for crossings in by_muscle for i in crossings], device)
    return p


def _starts(groups: Sequence[Sequence[Any]]) -> list[int]:
    """Where each group starts when all are put one behind the other, and where the last one ends."""
    return [0, *np.cumsum([len(group) for group in groups], dtype=int).tolist()]


def _numbers(values: Sequence[int], device: Any) -> wp.array:
    """Whole numbers on the device, a zero if there are none."""
    return to_device(values or [0], int, device)
