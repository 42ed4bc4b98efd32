"""Numbers in a scene, which a search may be allowed to change."""

from __future__ import annotations

import itertools
import math
from typing import Any, Literal, get_args

import msgspec
import numpy as np

Scale = Literal["linear", "log"]


class Free(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A free parameter, written where its number would stand.

    Examples: `kp = { value = 300, min = 100, max = 600, step = 5 }` declares a parameter named by its path in the
    scene; `kp = { same_as = "controller.pd.lHip.kp" }` makes a number follow it, and with `factor = -1` as its mirror
    image. `time = { same_as = "objective.target_speed", through = [[0.8, 0.65], [1.5, 0.5]] }` makes it follow on
    straight lines through these points, and beyond their ends at the values there: gains for every speed in one scene.
    """

    value: float | None = None
    min: float | None = None
    max: float | None = None
    step: float = 0.0  # precision of the search; 0 means continuous
    same_as: str = ""  # path of the parameter that this number follows
    factor: float = 1.0  # times that parameter
    through: tuple[tuple[float, float], ...] = ()  # or points of a curve over it: its value, this number's value
    scale: Scale = "linear"  # steps of a search: equal differences, or equal ratios, which suits gains and stiffnesses

    def __post_init__(self) -> None:
        """Raise ValueError, which a reader reports with file, line and key, unless the declaration is complete."""
        if self.same_as:
            if (self.value, self.min, self.max, self.step, self.scale) != (None, None, None, 0.0, "linear"):
                raise ValueError(
                    "a number with `same_as` takes value, min, max and step from that parameter, like scale"
                )
            if not math.isfinite(self.factor):
                raise ValueError("the factor must be finite")
            self._check_points()
            return
        if self.factor != 1.0:
            raise ValueError("only a number with `same_as` takes a factor")
        if self.through:
            raise ValueError("only a number with `same_as` goes through points")
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
        """Least and greatest value of this number while the one that it follows goes from low to high."""
        between = [at for at, _ in self.through if low < at < high]
        values = [float(self.following(source)) for source in (low, *between, high)]
        return min(values), max(values)


Number = float | Free
OF_OWNER = ""  # the unit of numbers that have that of the field which their structure stands in, such as of a curve
Vector = tuple[Number, Number, Number]
