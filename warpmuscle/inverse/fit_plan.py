"""The order in which the frames of recordings are fitted, and from where each starts.

Of each recording every 16th frame is fitted first, from the pose that the model starts in, with the root turned and
moved to where the markers are. The others start between the two solutions on either side. Frames that fit much worse
than the others of their recording are tried again, from a neighbour's solution or from afar. Nothing depends on what
other recordings are fitted with one.
"""

from __future__ import annotations

from dataclasses import dataclass

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


class Plan:
    """Frames of a problem by when they are fitted."""

    def __init__(self, problem: Problem) -> None:
        self._count = len(problem.positions)
        self._spans = list(zip(problem.starts, [*problem.starts[1:], self._count], strict=True))
        seen = (seen_in(problem.positions) & (problem.weights > 0.0)).sum(axis=1)
        self.coarse = [_spaced(first + np.flatnonzero(_good(seen[first:end])), first, end)
                       for first, end in self._spans]  # fmt: skip
        self.first: Integers = np.concatenate(self.coarse)
        later = np.ones(self._count, dtype=bool)
        later[self.first] = False
        self.rest: Integers = np.flatnonzero(later)

    def between(self, values: Floats) -> Floats:
        """Values (F, C) between those of the frames that were fitted first (n, C)."""
        found = np.empty((self._count, values.shape[1]))
        done = 0
        for own, (first, end) in zip(self.coarse, self._spans, strict=True):
            rows = np.arange(first, end)
            left = np.clip(np.searchsorted(own, rows, side="right") - 1, 0, max(len(own) - 2, 0))
            right = np.minimum(left + 1, len(own) - 1)
            part = np.clip((rows - own[left]) / np.maximum(own[right] - own[left], 1), 0.0, 1.0)[:, None]
            found[first:end] = (1.0 - part) * values[done + left] + part * values[done + right]
            done += len(own)
        return found

    def doubtful(self, values: Floats, squares: Floats) -> tuple[Integers, Floats]:
        """Frames that were fitted first, but badly, and the values of neighbours that were not."""
        frames, starts, done = [], [], 0
        for own in self.coarse:
            bad = _outlying(squares[done : done + len(own)])
            good = np.flatnonzero(~bad)
            for k in np.flatnonzero(bad):
                nearest = good[np.argmin(np.abs(good - k))]
                frames.append(own[k])
                starts.append(values[done + nearest])
            done += len(own)
        return np.array(frames, np.int64), np.array(starts).reshape(-1, values.shape[1])

    def outliers(self, squares: Floats) -> Integers:
        """Frames that fit badly beside the others of their recording."""
        found = [first + np.flatnonzero(_outlying(squares[first:end])) for first, end in self._spans]
        return np.intersect1d(np.concatenate(found), self.rest)


def seen_in(positions: Floats) -> NDArray[np.bool_]:
    """Which markers (F, K) are seen at positions (F, K, 3)."""
    known = np.isfinite(positions)
    return np.asarray(known[..., 0] & known[..., 1] & known[..., 2])


def squared_lengths(vectors: Floats) -> Floats:
    """Squares of the lengths of vectors (..., 3); sums over so short an axis are slow."""
    x, y, z = (np.square(vectors[..., axis]) for axis in range(3))
    return np.asarray(x + y + z)


def _good(seen: Integers) -> NDArray[np.bool_]:
    """Frames that show enough markers to be fitted from afar."""
    most = int(seen.max(initial=0))
    if most < FEWEST:
        raise SignalError(f"no frame shows {FEWEST} markers that count; the most is {most}")
    return np.asarray(seen >= max(FEWEST, PART * most))


def _spaced(good: Integers, first: int, end: int) -> Integers:
    """The good frames nearest to every 16th one and to the last."""
    wanted = np.array([*range(first, end, COARSE), end - 1])
    after = np.clip(np.searchsorted(good, wanted), 0, len(good) - 1)
    before = np.maximum(after - 1, 0)
    nearer = np.abs(good[before] - wanted) < np.abs(good[after] - wanted)
    return np.unique(good[np.where(nearer, before, after)])


def _outlying(squares: Floats) -> NDArray[np.bool_]:
    return np.asarray(squares > WORSE * np.median(squares) + BEYOND)
