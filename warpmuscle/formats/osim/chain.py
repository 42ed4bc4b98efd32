"""One joint of OpenSim as a row of ours, each with one coordinate, through bodies without mass."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import about, rotate
from warpmuscle.formats.osim.functions import Function
from warpmuscle.formats.osim.moves import Move
from warpmuscle.formats.osim.placement import Placed, direction, vector
from warpmuscle.scene import Body, Displacement, Joint
from warpmuscle.scene.number import Vector

NOTHING = Body(0.0, (0.0, 0.0, 0.0))


@dataclass
class JointRow:
    """Joints from one body on to the next, with the bodies between."""

    joints: dict[str, Joint] = field(default_factory=dict)
    bodies: dict[str, Body] = field(default_factory=dict)
    axes: Floats = field(default_factory=lambda: np.eye(3))  # of the next body, from OpenSim's axes to ours
    end: Floats = field(default_factory=lambda: np.zeros(3))  # m, joint point of the last joint in OpenSim's next body


@dataclass
class _Here:
    """Where the row has come to: a body of ours, and a frame in it, both in OpenSim's axes of that body."""

    body: Placed
    turn: Floats
    place: Floats

    def fold(self, move: Move) -> None:
        """Take a move that is constant into the frame."""
        if move.turns:
            self.turn = self.turn @ matrix(move.axis, move.value)
        else:
            self.place = self.place + self.turn @ np.array(move.axis) * move.value


def row_of(
    name: str, parent: Placed, start: tuple[Floats, Floats], child: str, end: tuple[Floats, Floats],
    groups: list[list[Move]], masters: set[str],
) -> JointRow:  # fmt: skip
    """The joints between two bodies.

    Args:
        name: of a joint that does not move.
        parent: the body before.
        start: axes (3, 3) and origin (3,) of the joint's frame in it, in OpenSim's axes.
        child: name of the body behind. end: of the joint's frame in that body.
        groups: what moves, see `moves.grouped`.
        masters: coordinates of other joints, which moves of this one follow.
    """
    row = JointRow()
    here = _Here(parent, *start)
    last: Joint | None = None
    for group in groups:
        if not group[0].argument:
            for move in group:
                here.fold(move)
            continue
        argument = group[0].argument
        again = argument in row.joints or group[0].beside != ""  # it moved the joint before another coordinate did
        last = _joint(group, here, masters | {argument} if again else masters)
        key = name_beside(group[0].coordinate if last.follows else argument, row.joints)
        last.child = f"{child}_{key}"
        row.joints[key] = last
        row.bodies[last.child] = NOTHING
        here = _Here(Placed(last.child, here.body.axes @ here.turn, np.zeros(3)), np.eye(3), np.zeros(3))
    if last is None:
        place = vector(here.body.point(here.place))
        row.joints[name] = Joint("fixed", parent.name, child, place, (0.0, 0.0, 0.0))
    else:
        del row.bodies[last.child]
        last.child = child
    turn, place_in_child = end
    row.axes = here.body.axes @ here.turn @ turn.T
    row.end = place_in_child if last is None else place_in_child - turn @ here.turn.T @ here.place
    return row


def name_beside(name: str, taken: Iterable[str]) -> str:
    """A name, with a number behind it if it is taken."""
    names = set(taken)
    tried = (f"{name}_{number}" for number in itertools.count(2))
    return name if name not in names else next(one for one in tried if one not in names)


def _joint(group: list[Move], here: _Here, masters: set[str]) -> Joint:
    """The joint of a group, from a body to one that has no name yet."""
    axes = here.body.axes @ here.turn
    argument = group[0].argument
    place = vector(here.body.point(here.place))
    follows = argument if argument in masters else ""
    line = group[0].function.line
    if len(group) == 1 and not follows and line is not None and abs(line[1]) == 1.0:
        (move,) = group
        sign, along = line[1], np.array(move.axis)
        if move.turns:  # the constant part of a turn about the same axis is as good before it
            here.turn = here.turn @ matrix(move.axis, line[0])
        else:
            place = vector(here.body.point(here.place + here.turn @ along * line[0]))
        return Joint("hinge" if move.turns else "slide", here.body.name, "", place, (0.0, 0.0, 0.0),
            axes=[direction(axes @ along * sign)])  # fmt: skip
    rotations = [displaced(move, axes @ np.array(move.axis)) for move in group if move.turns]
    translations = [displaced(move, axes @ np.array(move.axis)) for move in group if not move.turns]
    return Joint("coupled", here.body.name, "", place, (0.0, 0.0, 0.0), rotations=rotations,
        translations=translations, follows=follows, beside=group[0].beside, rate_only=group[0].rate_only)  # fmt: skip


def displaced(move: Move, axis: Floats) -> Displacement:
    """A move along or about an axis of ours."""
    if not move.beside:
        return displacement(move.function, axis)
    return Displacement(direction(axis), terms=list(move.terms), rod=list(move.rod or ()))


def displacement(function: Function, axis: Floats) -> Displacement:
    """A function along or about an axis of ours."""
    found = Displacement(direction(axis))
    set_function(found, function)
    return found


def set_function(found: Displacement, function: Function) -> None:
    """Give a displacement its function."""
    line = function.line
    if line is not None:
        found.value, found.slope = line
    elif function.x:
        found.x, found.y, found.ends = list(function.x), list(function.y), function.ends
    else:
        found.polynomial = list(function.coefficients)


def matrix(axis: Vector | Floats, angle: float) -> Floats:
    """The matrix (3, 3) of a turn about a unit axis."""
    return np.asarray(rotate(about(np.array(axis), angle), np.eye(3)).T)
