"""Musculotendon paths as a kernel wants them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import records_to_device, rows, starts, structs_to_device, to_device
from warpmuscle.kernels import muscle_structs, structs
from warpmuscle.kernels.force.torque_parts import MANY_CROSSINGS, PART
from warpmuscle.model.bodies import stacked
from warpmuscle.model.joint_groups import GroupedPaths
from warpmuscle.model.joints import by_coordinate
from warpmuscle.model.path_table import MusclePath, PathTable
from warpmuscle.model.routes import routes_struct
from warpmuscle.scene import Character
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.topology import Topology

ZERO = (0.0, 0.0, 0.0)


def paths_struct(
    table: PathTable, grouped: GroupedPaths, names: Topology, character: Character, device: Any
) -> structs.Paths:
    """The device structure of the paths of all muscles (see `kernels.structs.Paths`).

    Args:
        table: of the paths, whose numbers are floats, or (n,) arrays with one value an instance.
        grouped: what acts on each crossing of the table.
    """
    p = structs.Paths()
    p.fixed_length = to_device(_fixed_lengths(table), float, device)
    by_segment = _contributions(table, grouped, names, character)
    _put_conditions(p, table, names, device)
    _put_segments(p, table, names, character, starts(map(len, by_segment)), device)
    flat = [one for group in by_segment for one in group]
    columns = {name: [one[name] for one in flat] for name in structs.Contribution.vars}
    p.contribution = records_to_device(structs.Contribution, device, **columns)
    p.straight = records_to_device(structs.Straight, device, **_straight(table, names, character))
    _put_groups(p, grouped, device)
    _put_crossings(p, table, names, device)
    _put_pulleys(p, table, device)
    return p


def _contributions(
    table: PathTable, grouped: GroupedPaths, names: Topology, character: Character
) -> list[list[dict[str, int]]]:
    """What each segment contributes to crossings, by field of `kernels.structs.Contribution`."""
    found: list[list[dict[str, int]]] = [[] for _ in table.segments]
    for i, terms in enumerate(grouped.terms):
        segments = [term.segment for term in terms]
        for place, (segment, sign, mover, group) in enumerate(terms):
            marks = {
                muscle_structs.END_BEYOND: sign > 0, muscle_structs.START_BEYOND: sign < 0,
                muscle_structs.FIRST_OF_CROSSING: place == 0,
                muscle_structs.IN_FIRST_SEGMENT: segment == segments[0],
                muscle_structs.LAST_OF_CROSSING: place == len(segments) - 1,
                muscle_structs.LAST_OF_SEGMENT: segments[place + 1 : place + 2] != [segment],
                muscle_structs.BY_COORDINATE: by_coordinate(names.joints[mover - 1], character),
            }  # fmt: skip
            found[segment].append({
                "crossing": i, "joint": mover, "driver": names.driver[mover],
                "marks": sum(mark for mark, is_so in marks.items() if is_so) + muscle_structs.GROUPS * (group + 1),
            })  # fmt: skip
    return found


def _put_groups(p: structs.Paths, grouped: GroupedPaths, device: Any) -> None:
    """Put in the groups of joints that move as one."""
    members = [member for group in grouped.groups for member in group]
    bounds = starts(map(len, grouped.groups))
    of = [min(place, len(grouped.groups) - 1) for place in range(len(members))]
    p.member = records_to_device(
        muscle_structs.GroupMember, device,
        joint=[joint for joint, _ in members], sign=[sign for _, sign in members],
        start=[bounds[k] for k in of], end=[bounds[k + 1] for k in of],
    )  # fmt: skip


def _put_conditions(p: structs.Paths, table: PathTable, names: Topology, device: Any) -> None:
    """Put in the conditions of all points."""
    conditions = [point.condition for point in table.points if point.condition is not None]
    numbers = iter(range(len(conditions)))
    p.point_condition = _numbers([-1 if q.condition is None else next(numbers) for q in table.points], device)
    p.condition_joint = _numbers([names.body_of_joint(c.joint) for c in conditions], device)
    p.condition_axis = _numbers([c.axis for c in conditions], device)
    p.condition_slope = _numbers([c.moment_arms == "slope" for c in conditions], device)
    p.condition_interval = to_device(rows([[c.low, c.high, c.blend] for c in conditions] or [ZERO]), wp.vec3, device)


def _put_segments(
    p: structs.Paths, table: PathTable, names: Topology, character: Character, start: list[int], device: Any
) -> None:
    """Put in the segments and their ends; `start` says where the contributions of each start."""
    ends = [_ends(segment, table, names, character) for segment in table.segments]
    p.segment = records_to_device(
        structs.Segment, device,
        body_a=[end.bodies[0] for end in ends], body_b=[end.bodies[1] for end in ends],
        origin=[end.origin for end in ends], far=[end.far for end in ends],
        varies=[bool(table.conditional(i)) for i in range(len(table.segments))],
        first_contribution=start[:-1], end_contribution=start[1:],
    )  # fmt: skip
    a, b = (stacked([end.points[k] for end in ends] or [rows(ZERO)]) for k in range(2))
    p.ends = structs_to_device(structs.SegmentEnds, {"a": a, "b": b}, device)
    p.segment_points = to_device(table.segments or [(0, 0)], int, device)


def _put_crossings(p: structs.Paths, table: PathTable, names: Topology, device: Any) -> None:
    """Put in where each muscle stands in the lists, and the crossings by muscle and by joint."""
    joints = [crossing.joint for crossing in table.crossings]
    by_muscle: list[list[int]] = [[] for _ in table.muscles]
    for i, crossing in enumerate(table.crossings):
        by_muscle[crossing.muscle].append(i)
    crossing_start = starts(map(len, by_muscle))
    p.span = records_to_device(
        structs.PathSpan, device,
        first_segment=table.segment_start[:-1], end_segment=table.segment_start[1:],
        first_crossing=crossing_start[:-1], end_crossing=crossing_start[1:],
        first_pulley=table.pulley_start[:-1], end_pulley=table.pulley_start[1:],
    )  # fmt: skip
    of_muscle = [i for crossings in by_muscle for i in crossings]
    p.of_muscle = records_to_device(structs.Crossing, device, number=of_muscle, joint=[joints[i] for i in of_muscle])
    p.crossing_start = to_device(np.searchsorted(joints, np.arange(len(names.bodies) + 1)), int, device)
    p.crossing_muscle = _numbers([crossing.muscle for crossing in table.crossings], device)
    parts = torque_parts(table)
    order = sorted(range(len(parts)), key=lambda k: parts[k].start - parts[k].stop)
    p.torque_part = records_to_device(
        structs.TorquePart, device,
        first=[parts[k].start for k in order], end=[parts[k].stop for k in order], place=order,
    )  # fmt: skip
    of_part = [joints[part.start] for part in parts]
    p.torque_part_start = to_device(np.searchsorted(of_part, np.arange(len(names.bodies) + 1)), int, device)


def torque_parts(table: PathTable) -> list[range]:
    """Crossings whose torques are added up together, by joint; none unless very many muscles cross some joint."""
    numbers = np.unique([crossing.joint for crossing in table.crossings], return_index=True)[1].tolist()
    of_joint = list(pairwise([*numbers, len(table.crossings)]))
    if all(end - first <= MANY_CROSSINGS for first, end in of_joint):
        return []
    parts = []
    for first, end in of_joint:
        count = -(-(end - first) // PART)
        bounds = [first + (end - first) * k // count for k in range(count + 1)]
        parts += [range(*ends) for ends in pairwise(bounds)]
    return parts


def _put_pulleys(p: structs.Paths, table: PathTable, device: Any) -> None:
    """Put in the pulleys, with the crossing that each belongs to."""
    over = {k: (i, k == c.pulleys[0], k == c.pulleys[-1]) for i, c in enumerate(table.crossings) for k in c.pulleys}
    places = [over[k] for k in range(len(over))]
    p.pulley = records_to_device(
        structs.Pulley, device,
        crossing=[i for i, _, _ in places], joint=[table.crossings[i].joint for i, _, _ in places],
        axis=[pulley.axis for pulley in table.pulleys],
        first=[first for _, first, _ in places], last=[last for _, _, last in places],
    )  # fmt: skip
    pulleys = rows([[pulley.moment_arm, pulley.rest_angle] for pulley in table.pulleys] or [(0.0, 0.0)])
    p.pulley_row = to_device(pulleys, wp.vec2, device)


def route_struct(
    table: PathTable, grouped: GroupedPaths, paths: Mapping[str, MusclePath], names: Topology, character: Character,
    device: Any,
) -> structs.Routes:  # fmt: skip
    """The device structure of the routes and polynomials of all muscles, by name, which the table is of.

    See `kernels.structs.Routes`.
    """
    levers: list[list[tuple[int, int, int, int]]] = [[] for _ in table.muscles]
    for i, (crossing, own) in enumerate(zip(table.crossings, grouped.levers, strict=True)):
        levers[crossing.muscle] += [(i, *lever) for lever in own]
    number = {(crossing.muscle, crossing.joint): i for i, crossing in enumerate(table.crossings)}
    first = [sum(point.condition is not None for point in table.points[:start]) for start in table.point_start[:-1]]
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
