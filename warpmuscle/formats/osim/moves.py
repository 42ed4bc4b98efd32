"""What moves in a joint: turns and shifts as functions of coordinates that are free, in groups of one coordinate."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from warpmuscle.formats.osim.ellipsoids import ellipsoid_row
from warpmuscle.formats.osim.frames import refused
from warpmuscle.formats.osim.functions import IDENTITY, Function, composed
from warpmuscle.formats.osim.records import Axis, Coordinate, Coupler, Joint, Model, Vec3

SAMPLED = 1.0e-7  # rad or m, beyond which it is told how far a sampled function is off


@dataclass(frozen=True, slots=True)
class Move:
    """A turn about an axis or a shift along it, in a row of such."""

    turns: bool
    axis: Vec3
    argument: str  # the free coordinate that it depends on; empty: it is constant
    function: Function
    coordinate: str  # of the joint, that the argument moves

    @property
    def value(self) -> float:
        """Where it is if nothing moves."""
        return self.function.at(0.0)


class Coordinates:
    """Which coordinates are free, and what those that are not are functions of."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self.by_name = model.coordinates
        self.couplers: dict[str, Coupler] = {}
        for coupler in model.couplers:
            for name in (coupler.dependent, coupler.independent):
                if name not in self.by_name:
                    raise refused(model, coupler.line, f"coupler {coupler.name!r}: there is no coordinate {name!r}")
            if coupler.dependent in self.couplers:
                raise refused(model, coupler.line, f"coordinate {coupler.dependent!r} is coupled twice")
            if not self.by_name[coupler.dependent].locked:
                self.couplers[coupler.dependent] = coupler
        self.joint_of = {one.name: joint.name for joint in model.joints for one in joint.coordinates}
        self.inexact: dict[str, float] = {}  # coordinates whose functions are sampled: how far they are off
        for name in self.couplers:
            self.master(name)

    def free(self, name: str) -> bool:
        """Whether a coordinate moves by itself."""
        return name not in self.couplers and not self.by_name[name].locked

    def master(self, name: str) -> tuple[str, Function]:
        """The free coordinate that a coordinate depends on, and the function of that; none, if it is locked."""
        function, visited = IDENTITY, [name]
        while visited[-1] in self.couplers:
            coupler = self.couplers[visited[-1]]
            function = self.put(function, coupler.function, coupler.independent, name)
            if coupler.independent in visited:
                raise refused(self._model, coupler.line, f"coupler {coupler.name!r}: couplers make a circle")
            visited.append(coupler.independent)
        last = self.by_name[visited[-1]]
        return ("", Function((function.at(last.value),))) if last.locked else (last.name, function)

    def put(self, outer: Function, inner: Function, argument: str, name: str) -> Function:
        """The function outer(inner(argument))."""
        low, high = finite_range(self.by_name[argument])
        function, error = composed(outer, inner, low, high)
        if error > SAMPLED:
            self.inexact[name] = max(error, self.inexact.get(name, 0.0))
        return function

    def value(self, name: str) -> float:
        """Where a coordinate starts."""
        argument, function = self.master(name)
        return function.at(self.by_name[argument].value if argument else 0.0)

    def moves(self, joint: Joint) -> list[Move]:
        """The shifts and turns of a joint in their order, but for those that stay at 0."""
        found = []
        for turns, axis in _row(joint):
            argument, function, name = "", axis.function, ""
            if axis.coordinates:
                name = axis.coordinates[0]
                if name not in self.by_name:
                    raise refused(self._model, axis.line, f"there is no coordinate {name!r}")
                argument, inner = self.master(name)
                function = self.put(function, inner, argument or name, name)
            if argument and function.constant:
                argument, function = "", Function((function.at(0.0),))
            if argument or function.at(0.0) != 0.0:
                found.append(Move(turns, _unit(axis.direction), argument, function, name))
        return found


def _row(joint: Joint) -> Iterator[tuple[bool, Axis]]:
    """The axes of a joint in their order, and whether each turns."""
    if joint.ellipsoid is not None:
        yield from ellipsoid_row(joint, joint.ellipsoid)
        return
    for turns, axes in ((False, joint.translations), (True, joint.rotations)):
        for axis in axes:
            yield turns, axis


def finite_range(coordinate: Coordinate) -> tuple[float, float]:
    """The range of a coordinate, over which functions of it are sampled: a turn or 10 m about 0 where it has none."""
    low, high = coordinate.range
    low, high = max(low, -10.0), min(high, 10.0)
    return (low, high) if low < high else (-10.0, 10.0)


def reversed_moves(moves: list[Move]) -> list[Move]:
    """The moves of a joint from its child to its parent."""
    return [
        Move(move.turns, (-move.axis[0], -move.axis[1], -move.axis[2]), move.argument, move.function, move.coordinate)
        for move in reversed(moves)
    ]


def grouped(moves: list[Move]) -> list[list[Move]]:
    """Moves in groups of one argument, one after the other; constant ones alone, or within a group.

    Shifts may change places among themselves, so that one joins the turn that follows them. An argument has several
    groups where another one moves the joint between them.
    """
    first = next((index for index, move in enumerate(moves) if move.turns), len(moves))
    shifts, turns = moves[:first], moves[first:]
    leading = next((move.argument for move in turns if move.argument), "")
    order = list(dict.fromkeys(move.argument for move in shifts))
    order.sort(key=lambda argument: (argument != "", argument == leading != ""))
    shifts = [move for argument in order for move in shifts if move.argument == argument]
    groups: list[list[Move]] = []
    for move in (*shifts, *turns):
        last = groups[-1] if groups else []
        if last and move.argument == last[0].argument and not (last[-1].turns and not move.turns):
            last.append(move)
        elif move.argument and move.turns and len(groups) > 1 and _around(groups[-2:], move):
            groups[-2:] = [[*groups[-2], *groups[-1], move]]
        else:
            groups.append([move])
    return groups


def _around(groups: list[list[Move]], move: Move) -> bool:
    """Whether a move and one group have the same argument, and between them nothing but turns that are constant."""
    before, between = groups
    return before[0].argument == move.argument and all(one.turns and not one.argument for one in between)


def _unit(axis: Vec3) -> Vec3:
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    return float(x), float(y), float(z)
