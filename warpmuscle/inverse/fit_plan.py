"""The order in which the frames of recordings are fitted, and from where each starts.

Of each recording every 16th frame is fitted first, from the pose that the model starts in, with the root turned and
moved to where the markers are. The others start between the two solutions on either side. Frames that fit much worse
than the others of their recording are tried again, from a neighbour's solution or from afar. Nothing depends on what
other recordings are fitted with one.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import SignalError

COARSE = 16  # frames from one that is fitted from afar to the next
FEWEST = 3  # markers of such a frame, and
PART = 0.5  # of the most that any frame shows
WORSE, BEYOND = 4.0, 1.0e-4  # times the median mean square, and m^2 besides: a frame that is tried again


@dataclass(frozen=True)
class Problem:
    """Markers of F frames, of one recording or several, and what the coordinates should be besides."""

    positions: Floats  # (F, K, 3) m, world axes of scenes; NaN where a marker is missing
    weights: Floats  # (K,)
    starts: tuple[int, ...]  # first frame of each recording
    task_weights: Floats  # (C,) of the distances of coordinates from their targets
    targets: Floats  # (F or 1, C)
    turn: Floats = field(default_factory=lambda: np.eye(3))  # (3, 3) of positions, as rows, if their axes are others

    def places(self, frames: Integers) -> Floats:
        """Positions (n, K, 3) in some frames, world axes of scenes."""
        return np.asarray(self.positions[frames].reshape(-1, 3) @ self.turn).reshape(len(frames), -1, 3)


class Plan:
    """Frames of a problem by when they are fitted."""

    def __init__(self, problem: Problem, seen: Integers) -> None:
        """Args: seen: (F,) how many markers that count a frame shows."""
        self._count = len(problem.positions)
        self._starts: Integers = np.array(problem.starts)
        self._ends: Integers = np.array([*problem.starts[1:], self._count])
        good = _good(seen, self._starts, self._ends)
        self.coarse = [_spaced(good, first, end) for first, end in zip(self._starts, self._ends, strict=True)]
        self.first: Integers = np.concatenate(self.coarse)
        later = np.ones(self._count, dtype=bool)
        later[self.first] = False
        self.rest: Integers = np.flatnonzero(later)

    def between(self, values: Floats) -> Floats:
        """Values (F, C) between those of the frames that were fitted first (n, C)."""
        counts = [len(own) for own in self.coarse]
        last = np.repeat(np.cumsum(counts) - 1, self._ends - self._starts)  # by frame, of its recording
        begin = np.repeat(np.cumsum([0, *counts[:-1]]), self._ends - self._starts)
        rows = np.arange(self._count)
        left = np.clip(np.searchsorted(self.first, rows, side="right") - 1, begin, np.maximum(last - 1, begin))
        right = np.minimum(left + 1, last)
        step = np.maximum(self.first[right] - self.first[left], 1)
        part = np.clip((rows - self.first[left]) / step, 0.0, 1.0)[:, None]
        return np.asarray((1.0 - part) * values[left] + part * values[right])

    def doubtful(self, values: Floats, squares: Floats) -> tuple[Integers, Floats]:
        """Frames that were fitted first, but badly, and the values of neighbours that were not."""
        ends = np.cumsum([len(own) for own in self.coarse])
        outlying = _outlying(squares, np.concatenate([[0], ends[:-1]]), ends)
        frames, starts = [], []
        for number in np.unique(np.searchsorted(ends, np.flatnonzero(outlying), side="right")).tolist():
            own = self.coarse[number]
            done = ends[number] - len(own)
            bad = outlying[done : ends[number]]
            good = np.flatnonzero(~bad)
            for k in np.flatnonzero(bad):
                nearest = good[np.argmin(np.abs(good - k))]
                frames.append(own[k])
                starts.append(values[done + nearest])
        return np.array(frames, np.int64), np.array(starts).reshape(-1, values.shape[1])

    def outliers(self, squares: Floats) -> Integers:
        """Frames that fit badly beside the others of their recording."""
        return np.intersect1d(np.flatnonzero(_outlying(squares, self._starts, self._ends)), self.rest)


def seen_in(positions: Floats) -> NDArray[np.bool_]:
    """Which markers (F, K) are seen at positions (F, K, 3)."""
    known = np.isfinite(positions)
    return np.asarray(known[..., 0] & known[..., 1] & known[..., 2])


def squared_lengths(vectors: Floats) -> Floats:
    """Squares of the lengths of vectors (..., 3); sums over so short an axis are slow."""
    x, y, z = (np.square(vectors[..., axis]) for axis in range(3))
    return np.asarray(x + y + z)


def _good(seen: Integers, starts: Integers, ends: Integers) -> NDArray[np.bool_]:
    """Frames that show enough markers to be fitted from afar."""
    most = np.maximum.reduceat(seen, starts)
    if most.min() < FEWEST:
        least = int(most[most < FEWEST][0])
        raise SignalError(f"no frame shows {FEWEST} markers that count; the most is {least}")
    return np.asarray(seen >= np.repeat(np.maximum(FEWEST, PART * most), ends - starts))


def _spaced(good: NDArray[np.bool_], first: int, end: int) -> Integers:
    """The good frames of a recording nearest to every 16th one and to the last."""
    wanted = np.array([*range(first, end, COARSE), end - 1])
    if not good[wanted].all():
        frames = first + np.flatnonzero(good[first:end])
        after = np.clip(np.searchsorted(frames, wanted), 0, len(frames) - 1)
        before = np.maximum(after - 1, 0)
        nearer = np.abs(frames[before] - wanted) < np.abs(frames[after] - wanted)
        wanted = frames[np.where(nearer, before, after)]
    return np.unique(wanted)


def _outlying(squares: Floats, starts: Integers, ends: Integers) -> NDArray[np.bool_]:
    """Frames that miss by far more than the median of their recording."""
    counts = ends - starts
    ordered = squares[np.lexsort((squares, np.repeat(np.arange(len(starts)), counts)))]
    median = 0.5 * (ordered[starts + (counts - 1) // 2] + ordered[starts + counts // 2])
    return np.asarray(squares > np.repeat(WORSE * median + BEYOND, counts))
