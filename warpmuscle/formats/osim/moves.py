"""What moves in a joint: turns and shifts as functions of coordinates that are free, in groups of one coordinate."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.formats.osim.frames import refused
from warpmuscle.formats.osim.functions import BEYOND, IDENTITY, Function, composed, resampled
from warpmuscle.formats.osim.joints.ellipsoids import X, Y, Z, ellipsoid_row
from warpmuscle.formats.osim.joints.several import Polynomial, put_in, value_at
from warpmuscle.formats.osim.records import Axis, Coordinate, Coupler, Joint, Model, Rod, Vec3
from warpmuscle.scene import Displacement
from warpmuscle.scene.joints.two_coordinates import rates_of_two

SAMPLED = 1.0e-7  # rad or m, beyond which it is told how far a sampled function is off


@dataclass(frozen=True, slots=True)
class Move:
    """A turn about an axis or a shift along it, in a row of such."""

    turns: bool
    axis: Vec3
    argument: str  # the free coordinate that it depends on; empty: it is constant
    function: Function
    coordinate: str  # of the joint, that the argument moves
    beside: str = ""  # another free coordinate that it depends on, see `Joint.beside`
    rate_only: bool = False
    terms: tuple[tuple[float, int, int], ...] = ()  # of both
    rod: Vec3 | None = None  # length and angles of a rod that bends with both

    @property
    def key(self) -> tuple[str, str, bool]:
        """What moves of one joint of a scene have in common."""
        return self.argument, self.beside, self.rate_only

    @property
    def value(self) -> float:
        """Where it is if nothing moves."""
        return self.function.at(0.0)


class Coordinates:
    """Which coordinates are free, and what those that are not are functions of."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.by_name = model.coordinates
        self.couplers: dict[str, Coupler] = {}
        for coupler in model.couplers:
            for name in (coupler.dependent, coupler.independent, *coupler.several):
                if name not in self.by_name:
                    raise refused(model, coupler.line, f"coupler {coupler.name!r}: there is no coordinate {name!r}")
            if coupler.dependent in self.couplers:
                raise refused(model, coupler.line, f"coordinate {coupler.dependent!r} is coupled twice")
            if not self.by_name[coupler.dependent].locked:
                self.couplers[coupler.dependent] = coupler
        self.joint_of = {one.name: joint.name for joint in model.joints for one in joint.coordinates}
        self.inexact: dict[str, float] = {}  # coordinates whose functions are sampled: how far they are off
        for name in self.couplers:
            if self.of_several(name):
                self.polynomial(name)
            else:
                self.master(name)

    def free(self, name: str) -> bool:
        """Whether a coordinate moves by itself."""
        return name not in self.couplers and not self.by_name[name].locked

    def master(self, name: str) -> tuple[str, Function]:
        """The free coordinate that a coordinate depends on, and the function of that; none, if it is locked."""
        function, visited = IDENTITY, [name]
        while visited[-1] in self.couplers:
            coupler = self.couplers[visited[-1]]
            if coupler.terms:
                message = f"coupler {coupler.name!r}: {name!r} depends on several coordinates, where one may be"
                raise refused(self.model, coupler.line, message)
            function = self.put(function, coupler.function, coupler.independent, name)
            if coupler.independent in visited:
                raise refused(self.model, coupler.line, f"coupler {coupler.name!r}: couplers make a circle")
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

    def of_several(self, name: str) -> bool:
        """Whether a coordinate is coupled to several."""
        visited = {name}
        while name in self.couplers:
            coupler = self.couplers[name]
            if coupler.terms:
                return True
            name = coupler.independent
            if name in visited:
                return False  # a circle, of which `master` tells
            visited.add(name)
        return False

    def polynomial(self, name: str, visited: tuple[str, ...] = ()) -> Polynomial:
        """A coordinate as a polynomial of those that are free.

        Raises:
            SceneError: it depends on itself, or on a spline's coordinate.
        """
        if name in visited:
            raise refused(self.model, self.couplers[name].line, f"coordinate {name!r}: couplers make a circle")
        if self.by_name[name].locked:
            return {(): self.by_name[name].value}
        coupler = self.couplers.get(name)
        if coupler is None:
            return {((name, 1),): 1.0}
        below = (*visited, name)
        if coupler.terms:
            return put_in(coupler.terms, [self.polynomial(one, below) for one in coupler.several])
        if coupler.function.x and not coupler.function.constant:
            message = f"coupler {coupler.name!r}: what depends on several coordinates takes lines and polynomials alone"
            raise refused(self.model, coupler.line, message)
        line = coupler.function.line
        powers = line if line is not None else coupler.function.coefficients
        terms = tuple((a, (power,)) for power, a in enumerate(powers))
        return put_in(terms, [self.polynomial(coupler.independent, below)])

    def value(self, name: str) -> float:
        """Where a coordinate starts."""
        if self.of_several(name):
            return value_at(self.polynomial(name), {one: self.by_name[one].value for one in self.by_name})
        argument, function = self.master(name)
        return function.at(self.by_name[argument].value if argument else 0.0)

    def moves(self, joint: Joint) -> list[Move]:
        """The shifts and turns of a joint in their order, but for those that stay at 0."""
        found = [] if joint.rod is None else rod_moves(self, joint, joint.rod)
        for turns, axis in _row(joint):
            if any(one in self.by_name and self.of_several(one) for one in axis.coordinates) or axis.terms:
                found += self._of_several(joint, turns, axis)
                continue
            argument, function, name = "", axis.function, ""
            if axis.coordinates:
                name = axis.coordinates[0]
                if name not in self.by_name:
                    raise refused(self.model, axis.line, f"there is no coordinate {name!r}")
                argument, inner = self.master(name)
                function = self.put(function, inner, argument or name, name)
            if argument and function.constant:
                argument, function = "", Function((function.at(0.0),))
            if argument or function.at(0.0) != 0.0:
                found.append(Move(turns, _unit(axis.direction), argument, function, name))
        self._check_drivers(joint, found)
        return found

    def _of_several(self, joint: Joint, turns: bool, axis: Axis) -> list[Move]:
        """The moves about or along an axis that depends on several coordinates: of one of them each, or of two."""
        for name in axis.coordinates:
            if name not in self.by_name:
                raise refused(self.model, axis.line, f"there is no coordinate {name!r}")
        terms = axis.terms
        if not terms:
            line = axis.function.line
            if line is None and axis.function.x:
                message = f"an axis with a spline of {axis.coordinates[0]!r}, which depends on several coordinates"
                raise refused(self.model, axis.line, f"{message}, is not known; a line or polynomial is")
            powers = line if line is not None else axis.function.coefficients
            terms = tuple((a, (power,)) for power, a in enumerate(powers))
        single: dict[str, dict[int, float]] = {}
        pairs: dict[tuple[str, str], list[tuple[float, int, int]]] = {}
        for monomial, a in put_in(terms, [self.polynomial(name) for name in axis.coordinates]).items():
            if len(monomial) > 2:
                names = ", ".join(name for name, _ in monomial)
                message = f"joint {joint.name!r}: an axis has a product of {names}; products of two are known"
                raise refused(self.model, axis.line, message)
            if len(monomial) == 2:
                (first, m), (second, n) = monomial
                pairs.setdefault((first, second), []).append((a, m, n))
            else:
                name, power = monomial[0] if monomial else ("", 0)
                single.setdefault(name, {})[power] = a
        along, own, found = _unit(axis.direction), axis.coordinates[0], list[Move]()
        for name, powers_of in single.items():
            numbers = tuple(powers_of.get(power, 0.0) for power in range(max(powers_of) + 1))
            found.append(Move(turns, along, name, Function(numbers), own))
        for (first, second), products in pairs.items():
            back = tuple((a, n, m) for a, m, n in products)
            found.append(Move(turns, along, first, IDENTITY, own, second, False, tuple(products)))
            found.append(Move(turns, along, second, IDENTITY, own, first, True, back))
        return found

    def _check_drivers(self, joint: Joint, moves: list[Move]) -> None:
        """Each coordinate of a joint that moves with another one together also moves something alone."""
        own = {one.name for one in joint.coordinates}
        alone = {move.argument for move in moves if not move.beside}
        for move in moves:
            if move.beside and move.argument in own - alone:
                message = f"joint {joint.name!r}: no axis moves with {move.argument!r} alone, which others depend on"
                raise refused(self.model, joint.line, message)


def _row(joint: Joint) -> Iterator[tuple[bool, Axis]]:
    """The axes of a joint in their order, and whether each turns."""
    if joint.ellipsoid is not None:
        yield from ellipsoid_row(joint, joint.ellipsoid)
        return
    if joint.rod is not None:
        for axis, straight in zip(joint.rotations, joint.rod.angles, strict=True):
            yield True, replace(axis, function=Function((straight, 1.0)))
        return
    for turns, axes in ((False, joint.translations), (True, joint.rotations)):
        for axis in axes:
            yield turns, axis


def rod_moves(coordinates: Coordinates, joint: Joint, rod: Rod) -> list[Move]:
    """The shifts to where the end of a rod is, along x, y and z, by its two turns.

    Raises:
        SceneError: one of these follows another coordinate than the other one, and not as a line of slope 1.
    """
    names = [one.name for one in joint.coordinates[:2]]
    (first, of_first), (second, of_second) = (coordinates.master(name) for name in names)
    free = list(dict.fromkeys(one for one in (first, second) if one))
    if len(free) < 2:
        along = finite_range(coordinates.by_name[free[0]]) if free else (-1.0, 1.0)
        given = Displacement((1.0, 0.0, 0.0), rod=[rod.length, rod.angles[0], rod.angles[1]])

        def place(component: int) -> Function:
            def value(q: Floats) -> Floats:
                x, z = (function.values(q) for function in (of_first, of_second))
                return rates_of_two(given, component, False, x, z).value

            if not free:
                return Function((float(value(np.zeros(1))[0]),))
            function, error = resampled(value, *along, BEYOND)
            if error > SAMPLED:
                coordinates.inexact[free[0]] = max(error, coordinates.inexact.get(free[0], 0.0))
            return function

        name = free[0] if free else ""
        return [Move(False, axis, name, place(k), names[0]) for k, axis in enumerate((X, Y, Z))]
    lines = of_first.line, of_second.line
    if any(line is None or line[1] != 1.0 for line in lines):
        message = f"joint {joint.name!r}: its coordinates {names[0]!r} and {names[1]!r} are coupled to two others"
        raise refused(coordinates.model, joint.line, message)
    offsets = [line[0] if line is not None else 0.0 for line in lines]
    bent = (rod.length, rod.angles[0] + offsets[0], rod.angles[1] + offsets[1])
    return [
        Move(False, axis, one, IDENTITY, f"{joint.name}_bend", other, rate_only, (), bent)
        for one, other, rate_only in ((first, second, False), (second, first, True))
        for axis in (X, Y, Z)
    ]


def finite_range(coordinate: Coordinate) -> tuple[float, float]:
    """The range of a coordinate, over which functions of it are sampled: a turn or 10 m about 0 where it has none."""
    low, high = coordinate.range
    low, high = max(low, -10.0), min(high, 10.0)
    return (low, high) if low < high else (-10.0, 10.0)


def reversed_moves(moves: list[Move]) -> list[Move]:
    """The moves of a joint from its child to its parent."""
    return [replace(move, axis=(-move.axis[0], -move.axis[1], -move.axis[2])) for move in reversed(moves)]


def grouped(moves: list[Move]) -> list[list[Move]]:
    """Moves in groups of one argument, one after the other; constant ones alone, or within a group.

    Shifts may change places among themselves, so that one joins the turn that follows them. An argument has several
    groups where another one moves the joint between them.
    """
    first = next((index for index, move in enumerate(moves) if move.turns), len(moves))
    shifts, turns = moves[:first], moves[first:]
    leading = next((move.key for move in turns if move.argument), ("", "", False))
    order = list(dict.fromkeys(move.key for move in shifts))
    order.sort(key=lambda key: (key[0] != "", key == leading and key[0] != ""))
    shifts = [move for key in order for move in shifts if move.key == key]
    groups: list[list[Move]] = []
    for move in (*shifts, *turns):
        last = groups[-1] if groups else []
        if last and move.key == last[0].key and not (last[-1].turns and (move.beside or not move.turns)):
            last.append(move)
        elif move.argument and not move.beside and move.turns and len(groups) > 1 and _around(groups[-2:], move):
            groups[-2:] = [[*groups[-2], *groups[-1], move]]
        else:
            groups.append([move])
    return groups


def _around(groups: list[list[Move]], move: Move) -> bool:
    """Whether a move and one group have the same argument, and between them nothing but turns that are constant."""
    before, between = groups
    return before[0].key == move.key and all(one.turns and not one.argument for one in between)


def _unit(axis: Vec3) -> Vec3:
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    return float(x), float(y), float(z)
