"""Joints that one coordinate moves and that a path crosses together: for the path they are one joint.

A segment of a path puts a force and a moment on each joint that it crosses, and its moment arm of a coordinate is what
all joints which that moves get of it. They all get the same force, so that their motions can be added up once a step,
for all paths that cross the same of them, in place of a product for each joint and each segment.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple

from warpmuscle.kernels.path.stretch import PathKind
from warpmuscle.model.joints import by_coordinate
from warpmuscle.model.path_table import Crossing, PathTable
from warpmuscle.model.routes import path_kind
from warpmuscle.scene import Character, Muscle
from warpmuscle.scene.topology import Topology

Group = tuple[
    tuple[int, int], ...
]  # joints, by the number of the body that each carries, with 1 or -1; the first has 1


class GroupTerm(NamedTuple):
    """What a segment contributes to a crossing by a joint or a group."""

    segment: int
    sign: int  # 1 if it ends beyond the joint, -1 if it starts there, else 0
    joint: int  # number of the body that it carries; of a group, that of the first
    group: int  # -1: none


class GroupLever(NamedTuple):
    """A joint or a group that moves stops of a route."""

    joint: int  # as above
    beyond: int  # a bit a stop
    group: int


@dataclass(frozen=True)
class GroupedPaths:
    """What acts on each crossing of a `PathTable`.

    Attributes:
        groups: the largest first. terms, levers: by crossing.
    """

    groups: list[Group]
    terms: list[list[GroupTerm]]
    levers: list[list[GroupLever]]
    most_levers: int  # that a route has

    @property
    def gathers(self) -> bool:
        """Whether a segment acts on a crossing by several joints or groups."""
        return any(len({term.segment for term in own}) < len(own) for own in self.terms)

    def kind_of(self, muscles: Iterable[Muscle], character: Character) -> PathKind:
        """What a step has compiled in for the paths of some muscles, which these are."""
        kind = path_kind(muscles, character, self.most_levers)
        routes = kind.routes
        if routes is not None:
            routes = routes._replace(groups=any(lever.group >= 0 for own in self.levers for lever in own))
        return kind._replace(routes=routes, groups=len(self.groups))


def grouped_paths(table: PathTable, names: Topology, character: Character, together: bool = True) -> GroupedPaths:
    """What acts on each crossing.

    Args:
        together: whether to take joints together that may be.
    """
    may = [together and joint_moves_alone(body, names, character) for body in range(len(names.bodies))]
    terms = [_by_segment(crossing, table, names, may) for crossing in table.crossings]
    round_alone = character.wrapping == "opensim"  # whose slips ask for each joint, see `kernels.path.route_slip`
    levers = [_by_stops(crossing, may, round_alone) for crossing in table.crossings]
    found = {_normalized(group) for own in terms for _, group in own} | {group for own in levers for _, group in own}
    groups = sorted((group for group in found if len(group) > 1), key=lambda group: (-len(group), group))
    number = {group: k for k, group in enumerate(groups)}
    count: dict[int, int] = defaultdict(int)
    for crossing, own in zip(table.crossings, levers, strict=True):
        count[crossing.muscle] += len(own)
    return GroupedPaths(
        groups,
        [[_term(segment, group, number) for segment, group in own] for own in terms],
        [[GroupLever(group[0][0], bits, number.get(group, -1)) for bits, group in own] for own in levers],
        max(count.values(), default=0),
    )


def joint_moves_alone(body: int, names: Topology, character: Character) -> bool:
    """Whether the joint of a body has one coordinate, or follows one, whose motion the working set has as a column."""
    return body > 0 and by_coordinate(names.joints[body - 1], character)


def _by_segment(
    crossing: Crossing, table: PathTable, names: Topology, may: list[bool]
) -> list[tuple[int, Group]]:  # fmt: skip
    """What of a crossing each segment acts on, and with which sign: all joints that it crosses together, others apart.

    Joints that the weight of the segment depends on stay apart, since their moment arms are of the weight, too.
    """
    found: list[tuple[int, Group]] = []
    for segment, own in groupby(crossing.terms, key=lambda term: term[0]):
        weighing = {names.body_of_joint(condition.joint) for condition in table.conditional(segment)}
        signs = [(mover, sign) for _, sign, mover in own]
        together, apart = _split(signs, lambda one: may[one[0]] and one[1] != 0 and one[0] not in weighing)  # noqa: B023
        found += [(segment, group) for group in (*([together] if together else []), *((one,) for one in apart))]
    return found


def _by_stops(crossing: Crossing, may: list[bool], each_alone: bool) -> list[tuple[int, Group]]:
    """Joints of a crossing beyond which the same stops of a route are, with these stops."""
    by_bits: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for mover, bits in crossing.levers:
        by_bits[bits].append((mover, 1))
    found: list[tuple[int, Group]] = []
    for bits, own in by_bits.items():
        together, apart = _split(own, lambda one: may[one[0]] and not each_alone)
        found += [(bits, group) for group in (*([together] if together else []), *((one,) for one in apart))]
    return found


def _split(joints: Iterable[tuple[int, int]], may: Callable[[tuple[int, int]], bool]) -> tuple[Group, Group]:
    """Those that may be taken together, and the others."""
    joints = list(joints)
    return tuple(one for one in joints if may(one)), tuple(one for one in joints if not may(one))


def _normalized(group: Group) -> Group:
    """The group, or its opposite, whose first joint has 1."""
    first = group[0][1] or 1
    return tuple((joint, sign * first) for joint, sign in group)


def _term(segment: int, group: Group, number: dict[Group, int]) -> GroupTerm:
    return GroupTerm(segment, group[0][1], group[0][0], number.get(_normalized(group), -1))
