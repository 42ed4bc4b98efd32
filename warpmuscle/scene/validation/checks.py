"""What the checks of a scene are made of: lowest and highest values of numbers, known names, errors with keys."""

from __future__ import annotations

import difflib
import itertools
import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import LEAST_NUMBER, check_size
from warpmuscle.scene import Scene
from warpmuscle.scene.number import Free, Number
from warpmuscle.scene.parameters import PLAIN, distances_of_commands, leaves, named_members, ranges_of_commands
from warpmuscle.scene.part import Part, Range
from warpmuscle.scene.units import declared

Interval = tuple[float, float]  # the lowest and the highest value that a number can take


def alone(number: Number) -> Interval:
    """The interval of a number that is not free."""
    assert not isinstance(number, Free)
    return number, number


def check_ranges(key: str, part: Any, interval: Callable[[Number], Interval] = alone) -> None:
    """All numbers below a key are in the ranges that their fields declare, whatever a search does; else SceneError.

    Args:
        interval: what each of them can be; by default none is free.
    """
    if isinstance(part, Part):
        ranges = declared(type(part), Range)
        for field in part.__struct_fields__:
            value = getattr(part, field)
            if field in ranges:
                _in_range(join(key, field), value, ranges[field], interval)
            elif value is not None and type(value) not in PLAIN:
                check_ranges(join(key, field), value, interval)
    elif not isinstance(part, Free):
        for name, member in named_members(part) or ():
            if type(member) in PLAIN:
                break  # a list or a table of plain values
            check_ranges(f"{key}.{name}", member, interval)


def _in_range(key: str, value: Any, declared: Range, interval: Callable[[Number], Interval]) -> None:
    """A number, or each one of a list or table, is in a range; one that is not given is."""
    members = named_members(value)
    for name, member in () if members is None else members:
        _in_range(f"{key}.{name}", member, declared, interval)
    if members is None and value is not None:
        _RANGES[declared](key, interval(value))


def _positive(key: str, interval: Interval, bound: float = LEAST_NUMBER) -> None:
    if interval[0] <= 0.0:
        raise SceneError(f"must be greater than 0, is {interval[0]:g}", key=key)
    if interval[0] < bound:
        raise SceneError(f"must be at least {bound:g}, is {interval[0]:g}", key=key)


def _not_negative(key: str, interval: Interval) -> None:
    if interval[0] < 0.0:
        raise SceneError(f"must not be negative, is {interval[0]:g}", key=key)


def _fraction(key: str, interval: Interval) -> None:
    least, greatest = interval
    if least < 0.0 or greatest > 1.0:
        raise SceneError(f"must be within 0 and 1, is {least if least < 0.0 else greatest:g}", key=key)


_RANGES = {Range.ABOVE_0: _positive, Range.FROM_0: _not_negative, Range.FRACTION: _fraction}


class Checks:
    """Checks of the numbers of one scene; each raises SceneError or returns.

    Attributes:
        every: all values of the scene by their paths, walked once, since that takes long for a large one.
    """

    def __init__(self, to_check: Scene) -> None:
        self.checked, self.every = to_check, list(leaves(to_check))
        check_size("values", len(self.every), SceneError)
        self.free = {key: number for key, number in self.every if isinstance(number, Free) and not number.same_as}
        self._ranges, self._distances = ranges_of_commands(to_check), distances_of_commands(to_check)

    def interval(self, number: Number) -> Interval:
        """Lowest and highest value that a number can take."""
        if not isinstance(number, Free):
            return number, number
        source = self.free[number.same_as] if number.same_as else number
        try:
            low, high = source.interval(self._ranges)
        except ValueError as error:
            raise SceneError(str(error)) from None
        return number.range_over(low, high)

    def start(self, number: Number) -> float:
        """A number's own or start value."""
        if not isinstance(number, Free):
            return number
        source = self.free[number.same_as] if number.same_as else number
        if source.value is None:
            return math.nan
        value = source.commanded(self._distances, lambda _, own: own.value if isinstance(own, Free) else own)
        return float(number.following(value))

    def ranges(self, key: str, part: Any) -> None:
        """All numbers below a key are in the ranges that their fields declare, whatever a search does."""
        check_ranges(key, part, self.interval)

    def positive(self, key: str, number: Number, bound: float = LEAST_NUMBER) -> None:
        """A number is greater than zero, for every value a search may give it, and can be divided by.

        Args:
            bound: the least that it may be.
        """
        _positive(key, self.interval(number), bound)

    def not_negative(self, key: str, number: Number) -> None:
        """A number is not negative, for every value a search may give it."""
        _not_negative(key, self.interval(number))

    def fraction(self, key: str, number: Number) -> None:
        """A number stays within 0..1."""
        _fraction(key, self.interval(number))

    def not_zero(self, key: str, vector: Sequence[Number], what: str) -> None:
        """A direction or quaternion has a length."""
        if math.hypot(*map(self.start, vector)) < 1e-9:
            raise SceneError(f"{what} has no length", key=key)

    def independent(self, key: str, first: Sequence[Number], second: Sequence[Number]) -> None:
        """Two axes are not parallel."""
        (a, b, c), (x, y, z) = (list(map(self.start, axis)) for axis in (first, second))
        across = math.hypot(b * z - c * y, c * x - a * z, a * y - b * x)
        if across < 1e-6 * math.hypot(a, b, c) * math.hypot(x, y, z):
            raise SceneError("the two axes are parallel", key=key)

    def ordered(self, key: str, low: Number, high: Number) -> None:
        """A lower limit lies below its upper one, for every value that they may take."""
        if self.interval(low)[1] > self.interval(high)[0]:
            raise SceneError(f"low {self.interval(low)[1]:g} is greater than high {self.interval(high)[0]:g}", key=key)

    def increasing(self, key: str, numbers: Sequence[Number], what: str) -> None:
        """Numbers increase strictly, for every value that they may take; `what` names them in the plural."""
        for index, (earlier, later) in enumerate(itertools.pairwise(numbers), start=1):
            before, after = self.interval(earlier)[1], self.interval(later)[0]
            if before >= after:
                raise SceneError(f"{what} must increase, but {after:g} follows {before:g}", key=f"{key}.{index}")


def known(name: str, table: Iterable[str], kind: str, key: str, whose: str = "") -> None:
    """SceneError with the nearest known name unless `name` is one of the table's."""
    names = list(table)
    if name not in names:
        raise SceneError(f"no {kind} is called {name!r} {whose}".rstrip() + near(name, names), key=key)


def near(name: str, names: Iterable[str]) -> str:
    """The end of a message about an unknown name: the nearest known one, if there is one."""
    known = list(names)
    found = difflib.get_close_matches(name, known, n=1)
    found = found or [one for one in known if one.lower() == name.lower()][:1]
    return f"; did you mean {found[0]!r}?" if found else ""


def join(key: str, field: str) -> str:
    """The key of a field below a key, which may be empty."""
    return f"{key}.{field}" if key else field
