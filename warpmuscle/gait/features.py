"""What is read off curves over the gait cycle: how far they are from the norm, their extremes, and the two humps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.gait.cycles import PERCENT, longest_span
from warpmuscle.scene.norms import NORMS

_RIPPLE = 4  # % of the cycle: what is shorter is no hump
_SMOOTHING = np.hanning(2 * _RIPPLE + 3)[1:-1] / (_RIPPLE + 1.0)  # weights of the neighbours, their sum is 1
_IMPACT = 5.0  # % of the cycle, before which a peak of the force is that of the impact
_MIDDLE = (20.0, 40.0)  # % of the cycle, where the valley is
_LOADED = 0.05  # body weights: a foot with more is on the ground
_LEAST_VALLEY = 0.02  # body weights, depth below the lower hump


class KeyPoint(NamedTuple):
    """An extreme of a curve over the gait cycle."""

    value: float  # in the unit of the curve
    percent: float  # of the cycle


class Humps(NamedTuple):
    """The vertical ground force of a step; without a valley there is one hump only, the first."""

    first: KeyPoint | None
    valley: KeyPoint | None
    second: KeyPoint | None
    depth: float  # body weights, of the valley below the lower hump; 0 without one


def norm_deviation(name: str, curve: Floats) -> float:
    """Mean distance of a curve (101,) over the cycle from the mean of a norm of `NORMS`, in half-widths of its band."""
    norm = NORMS[name]
    return float(np.mean(np.abs(curve - norm.mean(PERCENT))[:-1]) / norm.half_width)


def greatest(curve: Floats, low: float = 0.0, high: float = 100.0) -> KeyPoint:
    """Greatest value of a curve (101,) between two percents of the cycle."""
    part = np.flatnonzero((low <= PERCENT) & (high >= PERCENT))
    index = part[int(np.argmax(curve[part]))]
    return KeyPoint(float(curve[index]), float(PERCENT[index]))


def least(curve: Floats, low: float = 0.0, high: float = 100.0) -> KeyPoint:
    """Least value of a curve (101,) between two percents of the cycle."""
    point = greatest(-curve, low, high)
    return KeyPoint(-point.value, point.percent)


def peak(curve: Floats, low: float, high: float) -> KeyPoint | None:
    """The highest point of a curve (101,) between two percents that is higher than both its neighbours, if any is."""
    return max(_tops(curve, low, high), default=None)


def _tops(curve: Floats, low: float, high: float) -> list[KeyPoint]:
    """All points of a curve (101,) between two percents that are higher than both their neighbours."""
    inner = np.arange(1, len(curve) - 1)
    tops = inner[(curve[inner] > curve[inner - 1]) & (curve[inner] >= curve[inner + 1])]
    return [KeyPoint(float(curve[k]), float(PERCENT[k])) for k in tops if low <= PERCENT[k] <= high]


def force_humps(force: Floats) -> Humps:
    """The humps of a vertical ground force (101,), body weights, from a foot's touch-down to its next.

    The valley is the dip in the middle of the stance, 20 to 40 % of the cycle, that lies deepest below the lower one of
    the peaks on its two sides. Peaks of the impact, in the first 5 % of the cycle, do not count, nor do ripples: the
    curve is smoothed over +-4 % of the cycle.
    """
    down = stance_part(force)
    smooth = np.convolve(np.pad(force, _RIPPLE, mode="edge"), _SMOOTHING, mode="valid")
    best = Humps(peak(smooth, _IMPACT, down), None, None, 0.0)
    for valley in _tops(-smooth, _MIDDLE[0], min(_MIDDLE[1], down)):
        first, second = peak(smooth, _IMPACT, valley.percent), peak(smooth, valley.percent, down)
        if first is None or second is None:
            continue
        depth = min(first.value, second.value) + valley.value
        if depth > max(best.depth, _LEAST_VALLEY):
            best = Humps(first, KeyPoint(-valley.value, valley.percent), second, depth)
    return best


def stance_part(force: Floats) -> float:
    """Percent of the cycle after which a foot is off the ground until the next touch-down, from its force (101,)."""
    swing = longest_span(force[:-1] <= _LOADED)
    return 100.0 if swing is None else float(PERCENT[swing.start])
