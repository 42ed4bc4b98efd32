"""Musculotendon paths by number: points, segments and pulleys, and which muscle acts on which joint."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from warpmuscle.model.routes import fixed_segments, moved_by, stops_beyond
from warpmuscle.scene import Character, Condition, Muscle, Pulley, ViaPoint
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.number import Free
from warpmuscle.scene.topology import Topology, carried
from warpmuscle.scene.validation.paths import check_path, check_polynomial, check_pulleys, check_wraps, is_route

MusclePath = Sequence[ViaPoint] | Muscle  # the points of a path, or a muscle with points or pulleys


class Lever(NamedTuple):
    """A muscle and a speed that it acts on."""

    crossing: int  # number of it
    body: int  # that the joint carries
    axis: int  # of the joint
    muscle: int
    speed: int


@dataclass(frozen=True)
class Crossing:
    """A muscle that acts on a joint, and through which segments or pulleys."""

    joint: int  # number of the body that the joint carries
    muscle: int
    terms: tuple[tuple[int, int, int], ...]  # segment; 1 if it ends beyond the mover, -1 if it starts there, else 0;
    # the mover: number of the body that the joint, or one that follows it, carries
    pulleys: tuple[int, ...] = ()
    levers: tuple[tuple[int, int], ...] = ()  # of a route: number of the body that a joint carries; stops beyond it

    @property
    def gathers(self) -> bool:
        """Whether a segment acts on it by several joints."""
        segments = [segment for segment, _, _ in self.terms]
        return len(set(segments)) < len(segments)


@dataclass(frozen=True)
class PathTable:
    """Paths of all muscles by number, one behind the other; see `kernels.structs.Paths`."""

    muscles: tuple[str, ...]
    points: tuple[ViaPoint, ...]
    fixed: list[list[tuple[int, int]]] = field(default_factory=list)  # by muscle: segments of unchanging length
    segments: list[tuple[int, int]] = field(default_factory=list)
    segment_start: list[int] = field(default_factory=lambda: [0])  # (muscles + 1,)
    point_start: list[int] = field(default_factory=lambda: [0])  # (muscles + 1,)
    crossings: list[Crossing] = field(default_factory=list)  # sorted by joint, then by muscle
    pulleys: list[Pulley] = field(default_factory=list)
    pulley_start: list[int] = field(default_factory=lambda: [0])  # (muscles + 1,)
    rest_length: list[Any] = field(default_factory=list)  # by muscle: None without pulleys

    @property
    def most_levers(self) -> int:
        """The most that a route has, see `Crossing.levers`."""
        counts = [0] * len(self.muscles)
        for crossing in self.crossings:
            counts[crossing.muscle] += len(crossing.levers)
        return max(counts, default=0)

    def levers(self, speed_start: Sequence[int]) -> list[Lever]:
        """A lever for each muscle and speed of a joint that it acts on, in the order of the crossings."""
        return [
            Lever(number, one.joint, axis, one.muscle, speed_start[one.joint] + axis)
            for number, one in enumerate(self.crossings)
            for axis in range(speed_start[one.joint + 1] - speed_start[one.joint])
        ]

    def conditional(self, segment: int) -> list[Condition]:
        """The conditions that the weight of a segment depends on."""
        a, b = self.segments[segment]
        return [c for c in (point.condition for point in self.points[a : b + 1]) if c is not None]


def path_table(
    paths: Mapping[str, MusclePath], names: Topology, character: Character, couples: bool = False
) -> PathTable:
    """Number points and segments, and find the muscles that act on each joint; fixed joints have none.

    Args:
        couples: whether a path round several surfaces acts on joints that carry all of it, too, where others act, as
            OpenSim's paths do (see `kernels.path.route_walk`).

    Raises:
        SceneError: an unknown body or joint, fewer than two points, or a point or condition that cannot be used.
    """
    for muscle, path in paths.items():
        _check(f"muscles.{muscle}", path, character)
    table = PathTable(tuple(paths), tuple(point for path in paths.values() for point in _points(path)))
    for path in paths.values():
        _add_pulleys(table, path)
        _add_segments(table, path)
    for i, joint in enumerate(names.joints, 1):
        if joint_type(character.joints[joint]).moves:
            _add_crossings(table, i, paths, names, character, couples)
    return table


def _points(path: MusclePath) -> Sequence[ViaPoint]:
    return path.path if isinstance(path, Muscle) else path


def _add_pulleys(table: PathTable, path: MusclePath) -> None:
    """Number the pulleys of the next muscle."""
    pulleys = path.pulleys if isinstance(path, Muscle) else []
    table.pulleys.extend(pulleys)
    table.pulley_start.append(len(table.pulleys))
    table.rest_length.append(path.rest_length if isinstance(path, Muscle) and pulleys else None)


def _add_segments(table: PathTable, path: MusclePath) -> None:
    """Number the points and the segments of the next muscle."""
    first = table.point_start[-1]
    local = fixed_segments(path) if isinstance(path, Muscle) and is_route(path) else _segments(_points(path))
    pairs = [(first + a, first + b) for a, b in local]
    table.point_start.append(first + len(_points(path)))
    table.fixed.append([pair for pair in pairs if _is_fixed(pair, table)])
    table.segments.extend(pair for pair in pairs if not _is_fixed(pair, table))
    table.segment_start.append(len(table.segments))


def _add_crossings(
    table: PathTable, joint: int, paths: Mapping[str, MusclePath], names: Topology, character: Character, couples: bool
) -> None:
    """Find the muscles that act on a joint, the number of the body that it carries."""
    movers = [i for i, driver in enumerate(names.driver) if driver == joint]  # some before it, if they follow it
    beyond = [(mover, {names.bodies[body] for body in carried(names.joints[mover - 1], names)}) for mover in movers]
    found, crossed = [], False
    for muscle, path in enumerate(paths.values()):
        segments = range(table.segment_start[muscle], table.segment_start[muscle + 1])
        terms = tuple(
            term for segment in segments for mover in beyond for term in _terms(segment, *mover, table, names)
        )
        own = range(table.pulley_start[muscle], table.pulley_start[muscle + 1])
        over = tuple(k for k in own if table.pulleys[k].joint == names.joints[joint - 1])
        levers, acts = _levers(path, joint, beyond, names, character, couples)
        crossed |= bool(terms or over or acts)
        if terms or over or acts or levers:
            found.append(Crossing(joint, muscle, terms, over, levers))
    if crossed:
        table.crossings.extend(found)


def _levers(
    path: MusclePath, joint: int, beyond: list[tuple[int, set[str]]], names: Topology, character: Character,
    couples: bool,
) -> tuple[tuple[tuple[int, int], ...], bool]:  # fmt: skip
    """What of a route moves with a joint, see `Crossing.levers`; and whether a route or polynomial depends on it."""
    if not isinstance(path, Muscle):
        return (), False
    name = names.joints[joint - 1]
    if path.polynomial is not None:
        return (), name in path.polynomial.joints
    if not is_route(path):
        return (), False
    turns = couples and character.wrapping == "opensim" and len(path.wraps) > 1
    stops = [(mover, *stops_beyond(path, bodies, character)) for mover, bodies in beyond]
    levers = tuple((mover, bits) for mover, bits, whole in stops if bits and (turns or not whole))
    return levers, any(bits and not whole for _, bits, whole in stops) or moved_by(path, name)


def _check(key: str, path: MusclePath, character: Character) -> None:
    if not isinstance(path, Muscle):
        check_path(f"{key}.path", path, character, _extent)
    elif path.pulleys:
        check_pulleys(f"{key}.pulleys", path.pulleys, character)
    elif path.polynomial is not None:
        check_polynomial(f"{key}.polynomial", path.polynomial, character)
    else:
        check_path(f"{key}.path", path.path, character, _extent)
        check_wraps(f"{key}.wraps", path, character)


def _extent(number: Any) -> tuple[float, float]:
    """Lowest and highest value of a number over all instances."""
    if isinstance(number, Free):
        return math.nan, math.nan  # only the whole scene knows them, and checking that has checked this number, too
    return float(np.min(number)), float(np.max(number))


def _segments(path: Sequence[ViaPoint]) -> list[tuple[int, int]]:
    """All pairs of points of a path with none but conditional points between them, in order."""
    pairs = []
    for a in range(len(path) - 1):
        for b in range(a + 1, len(path)):
            pairs.append((a, b))
            if path[b].condition is None:
                break
    return pairs


def joints_of_muscles(character: Character, names: Topology) -> dict[str, list[str]]:
    """Joints that each muscle of a character acts on, nearest to the root first."""
    table = path_table(character.muscles, names, character)
    joints: dict[str, list[str]] = {name: [] for name in table.muscles}
    for crossing in table.crossings:
        joints[table.muscles[crossing.muscle]].append(names.joints[crossing.joint - 1])
    return joints


def _is_fixed(pair: tuple[int, int], table: PathTable) -> bool:
    """Whether a segment lies within one body and does not depend on conditions."""
    points = table.points[pair[0] : pair[1] + 1]
    return points[0].body == points[-1].body and all(point.condition is None for point in points)


def _terms(segment: int, mover: int, beyond: set[str], table: PathTable, names: Topology) -> list[tuple[int, int, int]]:
    """What a segment contributes to a joint by what moves with it: see `Crossing.terms`; or nothing."""
    a, b = (table.points[number].body in beyond for number in table.segments[segment])
    hangs = any(condition.joint == names.joints[mover - 1] for condition in table.conditional(segment))
    return [(segment, int(b) - int(a), mover)] if a != b or hangs else []
