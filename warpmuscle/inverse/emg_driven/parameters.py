"""Parameters of EMG-driven muscles, and numbers from 0 to 1 that stand for them in a search."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ArgumentError

BY_MUSCLE = ("gain", "shape", "f_max", "l_opt", "l_slack")
NEUTRAL = {"delay": 0.04, "gain": 1.0, "shape": -0.1, "f_max": 1.0, "l_opt": 1.0, "l_slack": 1.0}


@dataclass(frozen=True)
class Bounds:
    """Least and greatest values of parameters; equal ones are not searched.

    Attributes:
        delay: s, from EMG to excitation. gain: of EMG. shape: A of Buchanan et al. (2004), -3 to 0.
        f_max, l_opt, l_slack: factors of the model's.
    """

    delay: tuple[float, float] = (0.01, 0.1)
    gain: tuple[float, float] = (0.5, 2.0)
    shape: tuple[float, float] = (-3.0, -0.01)
    f_max: tuple[float, float] = (0.5, 2.0)
    l_opt: tuple[float, float] = (0.9, 1.1)
    l_slack: tuple[float, float] = (0.9, 1.1)

    def check(self) -> None:
        """Raise ArgumentError for bounds that are none."""
        limits = {"delay": (0.0, 0.3), "shape": (-5.0, -1e-3)}
        for one in fields(self):
            low, high = getattr(self, one.name)
            least, most = limits.get(one.name, (0.05, 20.0))
            if not (least <= low <= high <= most):
                raise ArgumentError(
                    f"bounds of {one.name} are two numbers from {least:g} to {most:g}, not {low}, {high}"
                )


class ParameterCube:
    """Parameters of muscles with EMG as points of the unit cube; others of a muscle are neutral."""

    def __init__(self, bounds: Bounds, measured: Integers) -> None:
        """Args: measured: (M,) numbers, 1 for muscles with EMG."""
        self.bounds, self._measured = bounds, np.flatnonzero(measured)
        self._muscles = len(measured)
        self._free = [name for name in BY_MUSCLE if getattr(bounds, name)[0] < getattr(bounds, name)[1]]
        self._late = bounds.delay[0] < bounds.delay[1]
        self.size = int(self._late) + len(self._free) * len(self._measured)

    @property
    def start(self) -> Floats:
        """The point (D,) of neutral parameters."""
        parts = [_fraction("delay", self.bounds.delay, NEUTRAL["delay"])] if self._late else []
        for name in self._free:
            parts += [_fraction(name, getattr(self.bounds, name), NEUTRAL[name])] * len(self._measured)
        return np.asarray(np.clip(np.array(parts), 0.02, 0.98))

    def values(self, points: Floats) -> dict[str, Floats]:
        """Parameters of points (C, D): delay (C,), others (C, M) by name."""
        count, at = len(points), int(self._late)
        found = {"delay": np.full(count, self.bounds.delay[0])}
        if self._late:
            found["delay"] = _value("delay", self.bounds.delay, points[:, 0])
        for name in BY_MUSCLE:
            interval = getattr(self.bounds, name)
            fixed = NEUTRAL[name] if interval[0] <= NEUTRAL[name] <= interval[1] else interval[0]
            found[name] = np.full((count, self._muscles), NEUTRAL[name])
            found[name][:, self._measured] = fixed
            if name in self._free:
                part = points[:, at : at + len(self._measured)]
                found[name][:, self._measured] = _value(name, interval, part)
                at += len(self._measured)
        return found


def _value(name: str, interval: tuple[float, float], part: Floats) -> Floats:
    """Values that parts of an interval stand for; of factors, by their logarithms."""
    low, high = interval
    if name in ("delay", "shape"):
        return low + (high - low) * part
    return np.asarray(low * (high / low) ** part)


def _fraction(name: str, interval: tuple[float, float], value: float) -> float:
    low, high = interval
    inside = min(max(value, low), high)
    if name in ("delay", "shape"):
        return (inside - low) / (high - low)
    return float(np.log(inside / low) / np.log(high / low))
