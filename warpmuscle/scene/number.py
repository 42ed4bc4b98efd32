"""Numbers in a scene, which a search may be allowed to change."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Literal, get_args

import msgspec
import numpy as np

Scale = Literal["linear", "log"]
LARGEST_DEGREE = 2  # of the polynomial by which a number follows a command


class Free(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A free parameter, written where its number would stand.

    Examples: `kp = { value = 300, min = 100, max = 600, step = 5 }` declares a parameter named by its path in the
    scene; `kp = { same_as = "controller.pd.lHip.kp" }` makes a number follow it, and with `factor = -1` as its mirror
    image. `time = { same_as = "objective.target_speed", through = [[0.8, 0.65], [1.5, 0.5]] }` makes it follow on
    straight lines through these points, and beyond their ends at the values there: gains for every speed in one scene.

    `time = { value = 0.5, per = { speed = -0.1, slope = [0.002, 0.0003] } }` makes a number follow commands of the
    scene: 0.5 where all of them are at their references, and for a command that is x beyond its own, -0.1 x more, or
    0.002 x + 0.0003 x^2. Each of these numbers may be free itself, and is called `time.per.speed`, `time.per.slope.1`.
    """

    value: float | None = None
    min: float | None = None
    max: float | None = None
    step: float = 0.0  # precision of the search; 0 means continuous
    same_as: str = ""  # path of the parameter that this number follows
    factor: float = 1.0  # times that parameter
    through: tuple[tuple[float, float], ...] = ()  # or points of a curve over it: its value, this number's value
    scale: Scale = "linear"  # steps of a search: equal differences, or equal ratios, which suits gains and stiffnesses
    per: dict[str, Number | list[Number]] = {}  # what is added by command, for each unit beyond its reference

    def __post_init__(self) -> None:
        """Raise ValueError, which a reader reports with file, line and key, unless the declaration is complete."""
        if self.same_as:
            if (self.value, self.min, self.max, self.step, self.scale) != (None, None, None, 0.0, "linear"):
                raise ValueError(
                    "a number with `same_as` takes value, min, max and step from that parameter, like scale"
                )
            if self.per:
                raise ValueError("a number with `same_as` follows no command but through that number")
            if not math.isfinite(self.factor):
                raise ValueError("the factor must be finite")
            self._check_points()
            return
        if self.factor != 1.0:
            raise ValueError("only a number with `same_as` takes a factor")
        if self.through:
            raise ValueError("only a number with `same_as` goes through points")
        self._check_rates()
        if self.per and self.value is not None and self.min is None and self.max is None:
            self._check_fixed()
            return
        if self.value is None or self.min is None or self.max is None:
            raise ValueError("a free parameter needs value, min and max (or only same_as)")
        if not all(map(math.isfinite, (self.value, self.min, self.max, self.step))):
            raise ValueError("value, min, max and step of a free parameter must be finite")
        if self.min > self.max:
            raise ValueError(f"min {self.min:g} is greater than max {self.max:g}")
        if not self.min <= self.value <= self.max:
            raise ValueError(f"value {self.value:g} is outside its interval [{self.min:g}, {self.max:g}]")
        if self.step < 0.0:
            raise ValueError(f"step {self.step:g} is negative")
        if self.scale not in get_args(Scale):  # for those made in Python
            raise ValueError(f"scale must be one of {', '.join(get_args(Scale))}, not {self.scale!r}")
        if self.scale == "log" and self.min <= 0.0:
            raise ValueError(f"a logarithmic scale needs a positive min, not {self.min:g}")

    def _check_fixed(self) -> None:
        """A number that follows commands, but is not free itself."""
        if self.step != 0.0 or self.scale != "linear":
            raise ValueError("only a free parameter has a step and a scale: give min and max, too")
        if self.value is None or not math.isfinite(self.value):
            raise ValueError("the value must be finite")

    def _check_rates(self) -> None:
        for name, rate in self.per.items():
            if isinstance(rate, list) and not 1 <= len(rate) <= LARGEST_DEGREE:
                raise ValueError(f"what is added per {name} is a number, or a list of {LARGEST_DEGREE} at most")
            for _, number in self.rates(name):
                if isinstance(number, Free) and (number.same_as or number.per):
                    raise ValueError(f"what is added per {name} follows nothing: give value, min and max")
                if not isinstance(number, Free) and not math.isfinite(number):
                    raise ValueError(f"what is added per {name} must be finite")

    @property
    def is_parameter(self) -> bool:
        """Whether a search may change it; else it only follows another number, or commands."""
        return self.min is not None

    def rates(self, command: str) -> Iterator[tuple[str, Number]]:
        """Coefficients of what is added per command, that of its first power first, each with its name below `per`."""
        rate = self.per.get(command, 0.0)
        if isinstance(rate, list):
            yield from ((f"{command}.{power}", number) for power, number in enumerate(rate))
        else:
            yield command, rate

    def with_rates(self, change: Callable[[str, Number], Number]) -> dict[str, Number | list[Number]]:
        """`per` with `change(name below this number, coefficient)` in place of every coefficient."""
        changed: dict[str, Number | list[Number]] = {}
        for command, rate in self.per.items():
            numbers = [change(f"per.{name}", number) for name, number in self.rates(command)]
            changed[command] = numbers if isinstance(rate, list) else numbers[0]
        return changed

    def commanded(self, away: Mapping[str, Any], number: Callable[[str, Number | None], Any]) -> Any:
        """This number where commands are so far beyond their references, a float or an array.

        Args:
            away: by command. number: gives the value of what is called so below this number; "" is its own.
        """
        result = number("", self.value)
        for command in self.per:
            power: Any = 1.0
            for name, rate in self.rates(command):
                power = power * away[command]
                result = result + number(f"per.{name}", rate) * power
        return result

    def interval(self, away: Mapping[str, tuple[float, float]]) -> tuple[float, float]:
        """Lowest and highest value for all values of a search while commands are so far beyond their references.

        Raises:
            ValueError: it is no number of its own.
        """
        if self.value is None:
            raise ValueError("a free parameter needs value, min and max")
        low, high = (self.value, self.value) if self.min is None or self.max is None else (self.min, self.max)
        for command in self.per:
            ends = [
                (number.min, number.max) if isinstance(number, Free) else (number, number)
                for _, number in self.rates(command)
            ]
            added = [_polynomial_ends(coefficients, *away[command]) for coefficients in itertools.product(*ends)]
            low, high = low + min(least for least, _ in added), high + max(greatest for _, greatest in added)
        return low, high

    def _check_points(self) -> None:
        if not self.through:
            return
        if self.factor != 1.0:
            raise ValueError("a number that goes through points takes no factor")
        if len(self.through) < 2 or not np.isfinite(self.through).all():
            raise ValueError("a number goes through two finite points at least")
        for (before, _), (after, _) in itertools.pairwise(self.through):
            if before >= after:
                raise ValueError(f"the first numbers of points must increase, but {after:g} follows {before:g}")

    def following(self, source: Any) -> Any:
        """What this number is if the one that it follows is `source`: a float, or an array of floats."""
        if not self.through:
            return source if self.factor == 1.0 else source * self.factor
        at, values = zip(*self.through, strict=True)
        followed = np.interp(source, at, values)
        return followed if np.ndim(source) else float(followed)

    def range_over(self, low: float, high: float) -> tuple[float, float]:
        """Lowest and highest value of this number while the one that it follows goes from low to high."""
        between = [at for at, _ in self.through if low < at < high]
        values = [float(self.following(source)) for source in (low, *between, high)]
        return min(values), max(values)


def _polynomial_ends(coefficients: tuple[Any, ...], low: float, high: float) -> tuple[float, float]:
    """Lowest and highest value of a x + b x^2 from low to high."""
    a, b = (*coefficients, 0.0)[:2]
    at = [low, high]
    if b != 0.0 and low < -0.5 * a / b < high:
        at.append(-0.5 * a / b)
    values = [a * x + b * x * x for x in at]
    return min(values), max(values)


Number = float | Free
OF_OWNER = ""  # the unit of numbers that have that of the field which their structure stands in, such as of a curve
Vector = tuple[Number, Number, Number]
