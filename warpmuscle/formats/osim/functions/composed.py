"""Functions put into each other, and splines through the values of any function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.formats.osim.functions.function import Function

KNOTS = 401  # of a spline that stands for a function of a function, or for one of another degree, at least
MIDWAY_OFF, CLOSER = 1.0e-10, 8  # of its values and of 1 rad or m, by which it may be off between; doublings at most
MOST_KNOTS = 1000  # then: as many as a ligament's function may have
BEYOND = 0.5  # of a range, as far as such a spline reaches on each side of it


def composed(outer: Function, inner: Function, low: float, high: float) -> tuple[Function, float]:
    """The function q -> outer(inner(q)), and how far it is off between low and high: 0 if one of them is a line."""
    straight = inner.line
    if outer.line is not None:
        offset, slope = outer.line
        moved = inner.scaled(slope)
        if moved.x:
            return replace(moved, y=tuple(y + offset for y in moved.y)), 0.0
        first, *rest = moved.coefficients or (0.0,)
        return Function((first + offset, *rest)), 0.0
    if straight is not None:
        offset, slope = straight
        if slope == 0.0:
            return Function((outer.at(offset),)), 0.0
        if outer.x:
            step = 1 if slope > 0.0 else -1
            return replace(outer, x=tuple((x - offset) / slope for x in outer.x[::step]), y=outer.y[::step]), 0.0
        polynomial = np.polynomial.Polynomial(outer.coefficients)(np.polynomial.Polynomial([offset, slope]))
        return Function(tuple(map(float, polynomial.coef))), 0.0
    return resampled(lambda q: outer.values(inner.values(q)), low, high, BEYOND)


def resampled(
    function: Callable[[Floats], Floats], low: float, high: float, beyond: float = 0.0
) -> tuple[Function, float]:
    """A spline through many values of a function, and how far it is off between its knots from low to high.

    Knots are twice as close wherever it is off by more than `MIDWAY_OFF`, as often as `CLOSER`, so that its second
    derivative, which accelerations need, is close, too.

    Args:
        beyond: part of the way from low to high, by which knots reach beyond both, since a free run leaves ranges.
    """
    inner = np.linspace(low, high, KNOTS)
    out = (inner[1] - inner[0]) * np.arange(1, 1 + round(beyond * (KNOTS - 1)))
    x = np.concatenate([low - out[::-1], inner, high + out])
    for closer in range(CLOSER + 1):
        spline = Function(x=tuple(map(float, x)), y=tuple(map(float, function(x))), ends="simm")
        between = 0.5 * (x[1:] + x[:-1])
        off = np.abs(spline.values(between) - function(between))
        off_for = off / np.maximum(1.0, np.abs(function(between)))
        far = off_for > MIDWAY_OFF
        if closer == CLOSER or not np.any(far) or len(x) >= MOST_KNOTS:
            break
        worst = np.argsort(-off_for)[: min(MOST_KNOTS - len(x), int(np.count_nonzero(far)))]
        x = np.sort(np.concatenate([x, between[worst]]))
    return spline, float(np.max(off[(between > low) & (between < high)]))
