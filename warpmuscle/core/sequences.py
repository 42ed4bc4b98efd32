"""Sequences of numbers: as they are at other moments, made to rise, and their nearest times."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats, Integers

UNEVEN = 0.01  # of the mean distance, by which times that count as even may differ


def at_moments(time: Floats, values: NDArray[Any], moments: Floats) -> Floats:
    """Values (F, ...) at times (F,), in order, as they are at moments (...): linearly between, constant beyond.

    Returns:
        An array of the shape of the moments, and then of one value.
    """
    clock = np.asarray(time, dtype=float)
    after = np.clip(np.searchsorted(clock, moments), 1, len(clock) - 1)
    part = np.clip((moments - clock[after - 1]) / (clock[after] - clock[after - 1]), 0.0, 1.0)
    part = part.reshape(part.shape + (1,) * (values.ndim - 1))
    return np.asarray((1.0 - part) * values[after - 1] + part * values[after])


def are_even(times: Floats) -> bool:
    """Whether times (n,), two or more and in order, are as far apart as each other."""
    steps = np.diff(times)
    return bool(np.ptp(steps) <= UNEVEN * steps.mean())


def reaches_over(clock: Floats, first: float, last: float) -> bool:
    """Whether samples at these times (n,) in order reach over an interval, up to one and a half of their intervals."""
    late = 1.5 * float(np.median(np.diff(clock))) if len(clock) > 1 else 0.0
    return bool(clock[0] - late <= first and last <= clock[-1] + late)


def mirrored(rows: Floats, count: int) -> Floats:
    """Rows (F, ...) with so many more at each end, mirrored about the first and the last one; fewer than F."""
    before, behind = rows[count:0:-1], rows[-2 : -count - 2 : -1]
    return np.concatenate([2.0 * rows[:1] - before, rows, 2.0 * rows[-1:] - behind])


def weighted_median(values: Floats, weights: Floats) -> float:
    """The least of some values that, with all that are less, have half of the weight; at least one weight is not 0."""
    order = np.argsort(values, axis=None, kind="stable")
    below = np.cumsum(weights.ravel()[order])
    return float(values.ravel()[order][np.searchsorted(below, 0.5 * below[-1])])


def nearest_rows(time: Floats, moments: Floats) -> Integers:
    """Numbers (n,) of the times (F,) that are nearest to moments (n,), of equally near ones the earlier."""
    order = np.argsort(time, kind="stable")
    clock = time[order]
    after = np.clip(np.searchsorted(clock, moments), 1, max(len(clock) - 1, 1))
    before, last = clock[after - 1], clock[np.minimum(after, len(clock) - 1)]
    found = np.where(np.abs(last - moments) < np.abs(moments - before), last, before)
    return np.asarray(order[np.searchsorted(clock, found)])


def rising(values: Iterable[float]) -> Floats:
    """The sequence that never falls and has the least squared distance from values (n,), (n,).

    Neighbours that fall are pooled (Ayer 1955).
    """
    blocks: list[list[float]] = []  # of pooled neighbours: their mean and number
    for value in values:
        blocks.append([float(value), 1.0])
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            (a, m), (b, n) = blocks[-2:]
            blocks[-2:] = [[(a * m + b * n) / (m + n), m + n]]
    return np.repeat([block[0] for block in blocks], [int(block[1]) for block in blocks])
