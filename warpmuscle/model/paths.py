"""Musculotendon paths as a kernel wants them: points and segments by number, and which muscle acts on which joint."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import records_to_device, rows, starts, structs_to_device, to_device
from warpmuscle.kernels import structs
from warpmuscle.model.bodies import stacked
from warpmuscle.model.routes import fixed_segments, moved_by, routes_struct, stops_beyond
from warpmuscle.scene import Character, Condition, Muscle, Pulley, ViaPoint
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.number import Free
from warpmuscle.scene.topology import Topology
from warpmuscle.scene.validation.paths import check_path, check_polynomial, check_pulleys, check_wraps, is_route

ZERO = (0.0, 0.0, 0.0)


MusclePath = Sequence[ViaPoint] | Muscle  # the points of a path, or a muscle with points or pulleys


@dataclass(frozen=True)
class Crossing:
    """A muscle that acts on a joint, and through which segments or pulleys."""

    joint: int  # number of the body that the joint carries
    muscle: int
    terms: tuple[tuple[int, int, int], ...]  # segment; 1 if it ends beyond the mover, -1 if it starts there, else 0;
    # the mover: number of the body that the joint, or one that follows it, carries
    pulleys: tuple[int, ...] = ()
    levers: tuple[tuple[int, int], ...] = ()  # of a route: number of the body that a joint carries; stops beyond it


@dataclass(frozen=True)
class PathTable:
    """Paths of all muscles by number, one behind the other; see `kernels.structs.Paths`."""

    muscles: tuple[str, ...]
    points: tuple[ViaPoint, ...]
    fixed: list[list[tuple[int, int]]] = field(default_factory=list)  # by muscle: segments of unchanging length
    segments: list[tuple[int, int]] = field(default_factory=list)
    segment_start: list[int] = field(default_factory=lambda: [0])  # (muscles + 1,)
    point_start: list[int] = field(default_factory=list)  # by muscle
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

    def conditional(self, segment: int) -> list[Condition]:
        """The conditions that the weight of a segment depends on."""
        a, b = self.segments[segment]
        return [c for c in (point.condition for point in self.points[a : b + 1]) if c is not None]


def path_table(paths: Mapping[str, MusclePath], names: Topology, character: Character) -> PathTable:
    """Number points and segments, and find the muscles that act on each joint; fixed joints have none.

    Raises:
        SceneError: an unknown body or joint, fewer than two points, or a point or condition that cannot be used.
    """
    for muscle, path in paths.items():
        _check(f"muscles.{muscle}", path, character)
    points = [route.path if isinstance(route, Muscle) else route for route in paths.values()]
    table = PathTable(tuple(paths), tuple(point for path in points for point in path))
    for route in paths.values():
        pulleyed = isinstance(route, Muscle) and bool(route.pulleys)
        table.pulleys.extend(route.pulleys if isinstance(route, Muscle) else ())
        table.pulley_start.append(len(table.pulleys))
        table.rest_length.append(route.rest_length if isinstance(route, Muscle) and pulleyed else None)
    routes = [route if isinstance(route, Muscle) and is_route(route) else None for route in paths.values()]
    first = 0
    for through, muscle_route in zip(points, routes, strict=True):
        table.point_start.append(first)
        local = _segments(through) if muscle_route is None else fixed_segments(muscle_route)
        pairs = [(first + a, first + b) for a, b in local]
        first += len(through)
        table.fixed.append([pair for pair in pairs if _is_fixed(pair, table)])
        table.segments.extend(pair for pair in pairs if not _is_fixed(pair, table))
        table.segment_start.append(len(table.segments))
    movable = [i for i, joint in enumerate(names.joints, 1) if joint_type(character.joints[joint]).moves]
    for joint in movable:
        movers = [i for i, driver in enumerate(names.driver) if driver == joint]  # some before it, if they follow it
        beyond = [(mover, _beyond(mover, names)) for mover in movers]
        for muscle_number in range(len(paths)):
            segments = range(table.segment_start[muscle_number], table.segment_start[muscle_number + 1])
            terms = tuple(
                term for segment in segments for mover in beyond for term in _terms(segment, *mover, table, names)
            )
            own = range(table.pulley_start[muscle_number], table.pulley_start[muscle_number + 1])
            over = tuple(k for k in own if table.pulleys[k].joint == names.joints[joint - 1])
            levers, acts = _levers(list(paths.values())[muscle_number], joint, beyond, names, character)
            if terms or over or acts:
                table.crossings.append(Crossing(joint, muscle_number, terms, over, levers))
    return table


def _levers(
    path: MusclePath, joint: int, beyond: list[tuple[int, set[str]]], names: Topology, character: Character
) -> tuple[tuple[tuple[int, int], ...], bool]:
    """What of a route moves with a joint, see `Crossing.levers`; and whether a route or polynomial depends on it."""
    if not isinstance(path, Muscle):
        return (), False
    name = names.joints[joint - 1]
    if path.polynomial is not None:
        return (), name in path.polynomial.joints
    if not is_route(path):
        return (), False
    stops = [(mover, stops_beyond(path, bodies, character)) for mover, bodies in beyond]
    levers = tuple((mover, bits) for mover, bits in stops if bits)
    return levers, bool(levers) or moved_by(path, name)


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


def _beyond(joint: int, names: Topology) -> set[str]:
    """Names of the bodies that a joint carries."""
    carried = {joint}
    for body in range(joint + 1, len(names.bodies)):
        if names.parents[body] in carried:
            carried.add(body)
    return {names.bodies[body] for body in carried}


def _terms(segment: int, mover: int, beyond: set[str], table: PathTable, names: Topology) -> list[tuple[int, int, int]]:
    """What a segment contributes to a joint by what moves with it: see `Crossing.terms`; or nothing."""
    a, b = (table.points[number].body in beyond for number in table.segments[segment])
    hangs = any(condition.joint == names.joints[mover - 1] for condition in table.conditional(segment))
    return [(segment, int(b) - int(a), mover)] if a != b or hangs else []


def paths_struct(table: PathTable, names: Topology, character: Character, device: Any) -> structs.Paths:
    """The device structure of the paths of all muscles (see `kernels.structs.Paths`).

    Args:
        table: of the paths, whose numbers are floats, or (n,) arrays with one value an instance.
    """
    ends = [_ends(segment, table, names, character) for segment in table.segments]
    conditions = [point.condition for point in table.points if point.condition is not None]
    numbers = iter(range(len(conditions)))
    by_muscle = [
        [i for i, crossing in enumerate(table.crossings) if crossing.muscle == muscle]
        for muscle in range(len(table.muscles))
    ]
    joints = [crossing.joint for crossing in table.crossings]
    by_segment: list[list[dict[str, int]]] = [[] for _ in table.segments]
    for i, crossing in enumerate(table.crossings):
        for place, (segment, sign, mover) in enumerate(crossing.terms):
            first, last = place == 0, place == len(crossing.terms) - 1
            term = {"crossing": i, "joint": mover, "sign": sign, "first": first, "last": last}
            by_segment[segment].append(term)
    segment_start, term_start = table.segment_start, starts(map(len, by_segment))
    crossing_start = starts(map(len, by_muscle))

    p = structs.Paths()
    p.fixed_length = to_device(_fixed_lengths(table), float, device)
    p.point_condition = _numbers([-1 if q.condition is None else next(numbers) for q in table.points], device)
    p.condition_joint = _numbers([names.body_of_joint(c.joint) for c in conditions], device)
    p.condition_axis = _numbers([c.axis for c in conditions], device)
    p.condition_slope = _numbers([c.moment_arms == "slope" for c in conditions], device)
    p.condition_interval = to_device(rows([[c.low, c.high, c.blend] for c in conditions] or [ZERO]), wp.vec3, device)
    p.span = records_to_device(
        structs.PathSpan, device,
        first_segment=segment_start[:-1], end_segment=segment_start[1:],
        first_crossing=crossing_start[:-1], end_crossing=crossing_start[1:],
        first_pulley=table.pulley_start[:-1], end_pulley=table.pulley_start[1:],
    )  # fmt: skip
    p.segment = records_to_device(
        structs.Segment, device,
        body_a=[end.bodies[0] for end in ends], body_b=[end.bodies[1] for end in ends],
        origin=[end.origin for end in ends], far=[end.far for end in ends],
        varies=[bool(table.conditional(i)) for i in range(len(table.segments))],
        first_term=term_start[:-1], end_term=term_start[1:],
    )  # fmt: skip
    a, b = (stacked([end.points[k] for end in ends] or [rows(ZERO)]) for k in range(2))
    p.ends = structs_to_device(structs.SegmentEnds, {"a": a, "b": b}, device)
    terms = [term for group in by_segment for term in group]
    p.term = records_to_device(
        structs.Term, device, **{name: [term[name] for term in terms] for name in structs.Term.vars}
    )
    of_muscle = [i for crossings in by_muscle for i in crossings]
    p.of_muscle = records_to_device(structs.Crossing, device, number=of_muscle, joint=[joints[i] for i in of_muscle])
    p.straight = records_to_device(structs.Straight, device, **_straight(table, names, character))
    p.segment_points = to_device(table.segments or [(0, 0)], int, device)
    p.crossing_start = to_device(np.searchsorted(joints, np.arange(len(names.bodies) + 1)), int, device)
    p.crossing_muscle = _numbers([crossing.muscle for crossing in table.crossings], device)
    over = {k: (i, k == c.pulleys[0], k == c.pulleys[-1]) for i, c in enumerate(table.crossings) for k in c.pulleys}
    places = [over[k] for k in range(len(over))]
    p.pulley = records_to_device(
        structs.Pulley, device,
        crossing=[i for i, _, _ in places], joint=[joints[i] for i, _, _ in places],
        axis=[pulley.axis for pulley in table.pulleys],
        first=[first for _, first, _ in places], last=[last for _, _, last in places],
    )  # fmt: skip
    pulleys = rows([[pulley.moment_arm, pulley.rest_angle] for pulley in table.pulleys] or [(0.0, 0.0)])
    p.pulley_row = to_device(pulleys, wp.vec2, device)
    return p


def route_struct(
    table: PathTable, paths: Mapping[str, MusclePath], names: Topology, character: Character, device: Any
) -> structs.Routes:
    """The device structure of the routes and polynomials of all muscles, by name, which the table is of.

    See `kernels.structs.Routes`.
    """
    levers: list[list[tuple[int, int, int]]] = [[] for _ in table.muscles]
    for i, crossing in enumerate(table.crossings):
        levers[crossing.muscle] += [(i, *lever) for lever in crossing.levers]
    number = {(crossing.muscle, crossing.joint): i for i, crossing in enumerate(table.crossings)}
    first = [sum(point.condition is not None for point in table.points[:start]) for start in table.point_start]
    return routes_struct(paths, levers, number, first, names, character, device)


def all_straight(table: PathTable, names: Topology, character: Character) -> bool:
    """Whether every path is one segment between neighbouring bodies that crosses the joint between them."""
    muscles = len(table.muscles)
    single = table.segment_start == list(range(muscles + 1)) and not any(c.pulleys or c.levers for c in table.crossings)
    if not single or sorted(crossing.muscle for crossing in table.crossings) != list(range(muscles)):
        return False
    bodies = (_bodies(segment, table, names) for segment in table.segments)
    neighbours = all(_joined(max(pair), min(pair), names, character) for pair in bodies)
    return neighbours and not any(map(table.conditional, range(muscles)))


def _joined(child: int, parent: int, names: Topology, character: Character) -> bool:
    """Whether a joint that stays where it is in the parent carries the child."""
    return names.parents[child] == parent and not joint_type(character.joints[names.joints[child - 1]]).by_coordinate


def _bodies(segment: tuple[int, int], table: PathTable, names: Topology) -> tuple[int, int]:
    """Numbers of the bodies that a segment starts and ends at."""
    a, b = (names.bodies.index(table.points[number].body) for number in segment)
    return a, b


def _straight(table: PathTable, names: Topology, character: Character) -> dict[str, list[int]]:
    """The fields of `kernels.structs.Straight` by muscle if all paths are straight, else of none that counts."""
    if not all_straight(table, names, character):
        return {field: [0] for field in structs.Straight.vars}
    by_muscle = sorted(enumerate(table.crossings), key=lambda crossing: crossing[1].muscle)
    bodies = [_bodies(segment, table, names) for segment in table.segments]
    return {
        "body_a": [a for a, _ in bodies], "body_b": [b for _, b in bodies],
        "crossing": [number for number, _ in by_muscle],
        "sign": [crossing.terms[0][1] for _, crossing in by_muscle],
    }  # fmt: skip


@dataclass(frozen=True)
class _Ends:
    """Both ends of a segment, measured from the joint of one body where that body and the other are neighbours."""

    bodies: tuple[int, int]
    origin: int
    far: bool  # no neighbours: each end is measured from its own body's joint
    points: Sequence[Floats]  # (rows, 3) m, along the axes of its own body


def _ends(segment: tuple[int, int], table: PathTable, names: Topology, character: Character) -> _Ends:
    """Ends of a segment; between neighbours from the child's joint, so that no large numbers are subtracted."""

    def joint_in(body: int) -> Floats:  # the joint of a body, from its centre of mass
        return rows(character.joints[names.joints[body - 1]].position_in_child if body > 0 else ZERO)

    points = [table.points[number] for number in segment]
    a, b = _bodies(segment, table, names)
    own = [rows(point.place()) - joint_in(body) for point, body in zip(points, (a, b), strict=True)]
    for origin, other, end in ((b, a, 0), (a, b, 1)):
        if _joined(origin, other, names, character):
            anchor = rows(character.joints[names.joints[origin - 1]].position_in_parent)
            own[end] = rows(points[end].place()) - anchor
            return _Ends((a, b), origin, False, own)
    return _Ends((a, b), b, a != b, own)


def _fixed_lengths(table: PathTable) -> Floats:
    """What the segments within bodies add to the length of each muscle, or its rest length, (rows, muscles), m."""
    lengths = []
    for pairs, rest in zip(table.fixed or [[]], table.rest_length or [None], strict=True):
        total = np.zeros(1) if rest is None else rows(rest)
        for a, b in pairs:
            start, end = (rows(table.points[number].place()) for number in (a, b))
            total = total + np.linalg.norm(end - start, axis=-1)
        lengths.append(total)
    return stacked(lengths)


def _numbers(values: Sequence[int], device: Any) -> wp.array:
    """Whole numbers on the device, a zero if there are none."""
    return to_device(values or [0], int, device)
