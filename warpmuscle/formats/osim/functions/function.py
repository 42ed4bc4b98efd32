"""A function of one coordinate: a line, a polynomial or a spline, and its values."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene import Displacement
from warpmuscle.scene.joints.displacement import rates


@dataclass(frozen=True, slots=True)
class Function:
    """A polynomial, its constant first, or a spline through knots."""

    coefficients: tuple[float, ...] = ()
    x: tuple[float, ...] = ()
    y: tuple[float, ...] = ()
    ends: Literal["simm", "natural", "linear"] = "simm"
    sampled: bool = False  # its knots were chosen here, of a function that is no such spline

    @property
    def constant(self) -> bool:
        """Whether it is the same everywhere."""
        return not any(self.coefficients[1:]) if not self.x else len(set(self.y)) == 1

    @property
    def line(self) -> tuple[float, float] | None:
        """Value at 0 and slope of a straight line; None if it is none."""
        if self.x:
            return (self.y[0], 0.0) if self.constant else None
        a = (*self.coefficients, 0.0, 0.0)
        return None if any(self.coefficients[2:]) else (a[0], a[1])

    def at(self, q: float) -> float:
        """Its value."""
        return float(self.values(np.array([q]))[0])

    def values(self, q: Floats) -> Floats:
        """Its values at coordinates (n,)."""
        if not self.x:
            return np.asarray(np.polynomial.polynomial.polyval(q, self.coefficients or (0.0,)))
        if self.ends == "linear":
            return _broken_line(self, q)
        spline = Displacement((1.0, 0.0, 0.0), x=list(self.x), y=list(self.y), ends=self.ends)
        return rates(spline, q)[0]

    def slopes(self, q: Floats) -> Floats:
        """The slopes of a smooth spline at coordinates (n,)."""
        return rates(Displacement((1.0, 0.0, 0.0), x=list(self.x), y=list(self.y), ends=self.ends), q)[1]

    def sparse(self, most: int) -> Function:
        """It with no more knots than so many, if they were chosen here: with every second one, or fewer."""
        if not self.sampled or len(self.x) <= most:
            return self
        last = len(self.x) - 1
        kept = [*range(0, last, math.ceil(last / (most - 1))), last]
        return replace(self, x=tuple(self.x[k] for k in kept), y=tuple(self.y[k] for k in kept))

    def scaled(self, factor: float) -> Function:
        """It times a factor."""
        return replace(
            self, coefficients=tuple(factor * c for c in self.coefficients), y=tuple(factor * y for y in self.y)
        )


def _broken_line(function: Function, q: Floats) -> Floats:
    """Straight between knots, and on beyond them."""
    x, y = np.array(function.x), np.array(function.y)
    piece = np.clip(np.searchsorted(x, q) - 1, 0, len(x) - 2)
    slope = np.diff(y) / np.diff(x)
    return np.asarray(y[piece] + slope[piece] * (q - x[piece]))


ZERO = Function((0.0,))
IDENTITY = Function((0.0, 1.0))
