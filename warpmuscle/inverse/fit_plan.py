"""The order in which the frames of recordings are fitted, and from where each starts.

Of each recording every 16th frame is fitted first, from the pose that the model starts in, with the root turned and
moved to where the markers are. The others start between the two solutions on either side. Frames before or after a
jump, as of an elbow that came to bend the wrong way, are tried again from its other side. Those that fit much worse
than the others of their recording are tried again from a neighbour's solution or from afar. Nothing depends on what
other recordings are fitted with one.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import SignalError

COARSE = 16  # frames from one that is fitted from afar to the next
FEWEST = 3  # markers of such a frame, and
PART = 0.5  # of the most that any frame shows
JUMP = 0.35  # rad, that no coordinate turns from one frame to the next: 20 rad/s at 60 Hz
WORSE, BEYOND = 4.0, 1.0e-4  # times the median mean square, and m^2 besides: a frame that is tried again


class Recorded(NamedTuple):
    """Markers of F frames of one recording, and which of them count."""

    positions: Floats  # (F, R, 3) m, as recorded; NaN where a marker is missing
    columns: list[int]  # (K,) numbers of those that count, in the order of the fit's weights

    def chosen(self, frames: slice | int | Integers = slice(None)) -> Floats:
        """Positions (..., K, 3) in some frames; a view where all markers count."""
        own = self.positions[frames]
        every = self.columns == list(range(self.positions.shape[1]))
        return own if every else own[..., self.columns, :]


@dataclass(frozen=True)
class Problem:
    """Markers of F frames, of one recording or several, and what the coordinates should be besides."""

    recordings: list[Recorded]
    weights: Floats  # (K,)
    task_weights: Floats  # (C,) of the distances of coordinates from their targets
    targets: Floats  # (F or 1, C)
    turn: Floats = field(default_factory=lambda: np.eye(3))  # (3, 3) from recorded axes, as rows, to the world's

    @cached_property
    def starts(self) -> Integers:
        """First frames of all recordings, (T,)."""
        return np.cumsum([0, *(len(one.positions) for one in self.recordings[:-1])])

    @cached_property
    def count(self) -> int:
        """How many frames there are."""
        return sum(len(one.positions) for one in self.recordings)


class Between(NamedTuple):
    """Where frames start: between two others that were fitted before."""

    left: Integers  # (n,) numbers of frames
    right: Integers
    part: Floats  # (n,) of the way from the left one


class Plan:
    """Frames of a problem by when they are fitted."""

    def __init__(self, problem: Problem, seen: Integers) -> None:
        """Args: seen: (F,) how many markers that count a frame shows."""
        self._count = problem.count
        self._starts: Integers = problem.starts
        self._ends: Integers = np.array([*problem.starts[1:], self._count])
        good = _good(seen, self._starts, self._ends)
        self.coarse = _spaced_in_all(good, self._starts, self._ends)
        self.first: Integers = np.concatenate(self.coarse)
        later = np.ones(self._count, dtype=bool)
        later[self.first] = False
        self.rest: Integers = np.flatnonzero(later)

    def between(self) -> Between:
        """Between which of the frames that were fitted first the rest lies."""
        counts = [len(own) for own in self.coarse]
        lengths, rows = self._ends - self._starts, self.rest
        last = np.repeat(np.cumsum(counts) - 1, lengths)[rows]  # of the frame's recording
        begin = np.repeat(np.cumsum([0, *counts[:-1]]), lengths)[rows]
        done = np.cumsum(np.isin(np.arange(self._count), self.first, assume_unique=True))[rows]
        left = np.clip(done - 1, begin, np.maximum(last - 1, begin))
        right = np.minimum(left + 1, last)
        step = np.maximum(self.first[right] - self.first[left], 1)
        part = np.clip((rows - self.first[left]) / step, 0.0, 1.0)
        return Between(self.first[left], self.first[right], part)

    def doubtful(self, squares: Floats) -> tuple[Integers, Integers]:
        """Frames that were fitted first, but badly, and the nearest ones of their recordings that were not.

        Args:
            squares: (F,) mean squares of errors.
        """
        frames: list[int] = []
        others: list[int] = []
        counts = [len(own) for own in self.coarse]
        for k in _may_outlie(squares[self.first], np.cumsum([0, *counts[:-1]])).tolist():
            own = self.coarse[k]
            bad = _outlying(squares[own])
            if not bad.any():
                continue
            good = np.flatnonzero(~bad)
            for k in np.flatnonzero(bad):
                frames.append(int(own[k]))
                others.append(int(own[good[np.argmin(np.abs(good - k))]]))
        return np.array(frames, np.int64), np.array(others, np.int64)

    def jumped(self, squares: Floats, turned: Floats) -> tuple[Integers, Integers]:
        """Frames on the worse side of a jump, up to the next jump, and the frame on its other side.

        Args:
            squares: (F,) mean squares of errors. turned: (F,) rad, by which coordinates turn from the frame before.
        """
        jump = turned > JUMP
        jump[self._starts] = True
        edges = np.append(np.flatnonzero(jump), self._count)  # of runs without a jump
        frames, others, first = [], [], np.isin(edges, self._starts)
        for k in np.flatnonzero(~first[:-1]).tolist():
            before, at, after = edges[k - 1], edges[k], edges[k + 1]
            worse = (at, after) if squares[at] > squares[at - 1] else (before, at)
            frames.append(np.arange(*worse))
            others.append(np.full(len(frames[-1]), at - 1 if worse[0] == at else at))
        nothing = [np.empty(0, np.int64)]
        found, places = np.unique(np.concatenate(frames or nothing), return_index=True)
        return found, np.concatenate(others or nothing)[places]

    def outliers(self, squares: Floats) -> Integers:
        """Frames that fit badly beside the others of their recording, but for those that were fitted first."""
        bad = np.zeros(self._count, dtype=bool)
        for k in _may_outlie(squares, self._starts).tolist():
            first, end = int(self._starts[k]), int(self._ends[k])
            bad[first:end] = _outlying(squares[first:end])
        bad[self.first] = False
        return np.flatnonzero(bad)


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


def every_few(starts: Integers, ends: Integers, step: int) -> tuple[Integers, Integers]:
    """Every Nth frame (n,) of each recording, N being `step`, from its first one on, and how many each has."""
    counts = np.maximum((ends - starts + step - 1) // step, 1)
    first = np.cumsum(counts) - counts
    return np.repeat(starts - step * first, counts) + step * np.arange(counts.sum()), counts


def _spaced_in_all(good: NDArray[np.bool_], starts: Integers, ends: Integers) -> list[Integers]:
    """`_spaced` of each recording: of all at once, where no frame has to be replaced."""
    wanted, counts = every_few(starts, ends, COARSE)
    after = np.cumsum(counts)
    wanted = np.insert(wanted, after, ends - 1)
    if not good[wanted].all():
        return [_spaced(good, first, end) for first, end in zip(starts.tolist(), ends.tolist(), strict=True)]
    kept = np.append(True, wanted[1:] != wanted[:-1])
    breaks = (after + np.arange(1, len(starts) + 1))[:-1]
    return np.split(wanted[kept], np.cumsum(kept)[breaks - 1] if len(breaks) else [])


def _may_outlie(squares: Floats, starts: Integers) -> Integers:
    """Parts that start at these places and may have values far beyond their median, which is not below the least."""
    most, least = np.maximum.reduceat(squares, starts), np.minimum.reduceat(squares, starts)
    return np.flatnonzero(~(most <= WORSE * least + BEYOND))


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


def _outlying(squares: Floats) -> NDArray[np.bool_]:
    """Frames of a recording that miss by far more than the median."""
    low, high = (len(squares) - 1) // 2, len(squares) // 2
    ordered = np.partition(squares, (low, high))
    return np.asarray(squares > WORSE * 0.5 * (ordered[low] + ordered[high]) + BEYOND)
