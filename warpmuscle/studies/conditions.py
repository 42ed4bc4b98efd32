"""What many runs under several conditions say: medians and bands over seeds, changes, trends, and expectations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from warpmuscle.core.array_types import Booleans, Floats

Condition = float | str
Verdict = Literal["agrees", "contradicts", "open"]
BAND = (5.0, 95.0)  # % of the runs within
CONFIDENCE = 0.95  # of an interval of a median
CLEAR = 0.05  # probability that a trend is chance, below which it counts


@dataclass(frozen=True)
class Spread:
    """Where the middle of some values is, and how far they spread; not a number where there are none."""

    count: int
    median: float
    low: float
    high: float


@dataclass(frozen=True)
class Cell:
    """A measure under a condition."""

    condition: Condition
    runs: int
    walked: int  # of them, to the end
    spread: Spread  # over the runs that give it
    change: Spread  # from the reference, of pairs of runs with the same seed
    interval: tuple[float, float]  # that has the median of the changes, by `CONFIDENCE`


@dataclass(frozen=True)
class Trend:
    """Whether a measure rises or falls with a condition."""

    tau: float  # Kendall's rank correlation, from -1 to 1
    chance: float  # probability of one as great by chance


@dataclass(frozen=True)
class Expected:
    """What is expected of a measure, such as what has been published."""

    measure: str
    change: Literal["rises", "falls", "stays", ""] = ""  # from the reference to `at`
    at: Condition | None = None  # condition; by default the farthest from the reference
    value: float | None = None  # of the change, in the unit of the measure
    source: str = ""
    within: float = 0.0  # a change that is no change, where the measure is to stay


def spread_of(values: Floats) -> Spread:
    """Median and band of values (n,), of which those count that are finite."""
    known = values[np.isfinite(values)]
    if not len(known):
        return Spread(0, np.nan, np.nan, np.nan)
    low, median, high = np.percentile(known, [BAND[0], 50.0, BAND[1]])
    return Spread(len(known), float(median), float(low), float(high))


def cells_of(
    values: Floats, walked: Booleans, conditions: Sequence[Condition], seeds: Sequence[int], reference: Condition
) -> list[Cell]:
    """A measure of runs (R,), condition by condition, in the order in which they first occur.

    Args:
        values: of each run, not a number where it gives none.
        walked: (R,), whether it went on to the end.
        conditions, seeds: of each run.
    """
    known = dict(zip(zip(conditions, seeds, strict=True), values.tolist(), strict=True))
    cells = []
    for condition in dict.fromkeys(conditions):
        mine = np.array([other == condition for other in conditions])
        pairs = [
            (known[condition, seed], known[reference, seed])
            for seed in dict.fromkeys(seeds)
            if (condition, seed) in known and (reference, seed) in known
        ]
        changes = np.array([one - other for one, other in pairs]) if pairs else np.zeros(0)
        own, change = spread_of(values[mine]), spread_of(changes)
        cells.append(Cell(condition, int(mine.sum()), int(walked[mine].sum()), own, change, interval_of(changes)))
    return cells


def interval_of(values: Floats) -> tuple[float, float]:
    """An interval that has the median of the distribution of values (n,), whatever that is, with `CONFIDENCE`.

    Its ends are values themselves, counted from both ends (Thompson 1936). Of fewer than six there is none: not a
    number.
    """
    from scipy import stats

    known = np.sort(values[np.isfinite(values)])
    beyond = int(stats.binom.ppf(0.5 * (1.0 - CONFIDENCE), max(len(known), 1), 0.5))
    if beyond < 1:  # P(fewer than one of them on one side) is too large already
        return np.nan, np.nan
    return float(known[beyond - 1]), float(known[len(known) - beyond])


def trend_of(values: Floats, conditions: Sequence[Condition]) -> Trend | None:
    """The trend of a measure over conditions that are numbers (Kendall 1938, tau b); None if there are too few."""
    from scipy import stats

    x = np.array([condition if isinstance(condition, float | int) else np.nan for condition in conditions], float)
    known = np.isfinite(values) & np.isfinite(x)
    if len(set(x[known])) < 2 or known.sum() < 4 or len(set(values[known])) < 2:
        return None
    found = stats.kendalltau(x[known], values[known])
    return Trend(float(found.statistic), float(found.pvalue))


def farthest(conditions: Sequence[Condition], reference: Condition) -> Condition:
    """The condition that differs most from a reference: the last one, where they are not numbers."""
    others = [condition for condition in dict.fromkeys(conditions) if condition != reference]
    if not others:
        return reference
    if all(isinstance(condition, float | int) for condition in (*others, reference)):
        return max(others, key=lambda condition: abs(float(condition) - float(reference)))
    return others[-1]


def has_value(expected: Expected, cell: Cell) -> bool | None:
    """Whether the expected value of a change lies in the interval of what was found; None where there is no such."""
    low, high = cell.interval
    return None if expected.value is None or not np.isfinite(low) else low <= expected.value <= high


def verdict_of(expected: Expected, cell: Cell) -> Verdict:
    """Whether the changes of a measure under a condition are as expected, as far as so many runs can tell."""
    low, high = cell.interval
    if not np.isfinite(low):
        return "open"
    if expected.change == "stays" and expected.within > 0.0:
        inside = -expected.within <= low and high <= expected.within
        return (
            "agrees"
            if inside
            else "contradicts"
            if min(abs(low), abs(high)) > expected.within and low * high > 0.0
            else "open"
        )
    if expected.change == "stays":
        return "agrees" if low <= 0.0 <= high else "contradicts"
    if expected.change:
        sign = 1.0 if expected.change == "rises" else -1.0
        ahead, behind = sorted((sign * low, sign * high))
        return "agrees" if ahead > 0.0 else "contradicts" if behind < 0.0 else "open"
    if expected.value is None:
        return "open"
    return "agrees" if low <= expected.value <= high else "contradicts"
