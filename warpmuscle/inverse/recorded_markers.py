"""Recorded markers on a device, and what is found of them there: which are seen, and how far a fit misses them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.arrays import to_device
from warpmuscle.inverse.fit_plan import Problem
from warpmuscle.kernels.inverse import marker_frames

BEYOND = 1e5  # m, that no marker of any unit is away


class MarkerSums(NamedTuple):
    """Sums over the frames of T recordings in which a marker is seen."""

    squares: Floats  # (T, K) m^2, of errors
    height: Floats  # (T, K) m
    seen: Integers  # (T, K) how many frames


class RecordedMarkers:
    """The markers of a problem on a device, and the errors that are found there.

    Attributes:
        seen: (F,) how many markers that count a frame shows. far: (F,) whether one of a frame is impossibly far away.
        squares: (F,) weighted mean squares of the errors of frames that have been fitted, m^2.
    """

    def __init__(self, problem: Problem, order: Integers, device: Any) -> None:
        """Args: order: (K,) the number of each marker of the fit among those recorded."""
        self._device, self.squares = device, np.zeros(len(problem.positions))
        self._positions = _doubles(problem.positions, device)
        self._order = to_device(order, int, device)
        self._turn, self._back = wp.mat33d(problem.turn.T), wp.mat33d(problem.turn)  # into the axes of the fit
        weights = np.asarray(problem.weights)
        self._weights = to_device(weights[order], float, device)
        self._errors = wp.zeros(problem.positions.shape[:2], dtype=wp.vec3d, device=device)
        found = [wp.empty(len(self.squares), dtype=int, device=device) for _ in range(2)]
        inputs = [self._positions, to_device(weights, float, device), BEYOND]
        wp.launch(marker_frames.look_at_frames, len(self.squares), inputs, found, device=device)
        self.seen: Integers = found[0].numpy()
        self.far: NDArray[np.bool_] = found[1].numpy() > 0

    def take(self, frames: Integers, base: Floats, data: Any) -> wp.array:
        """Put the markers of some frames into the data of a fit, from places (n, 3) on; the frames on the device."""
        number, shape = to_device(frames, int, self._device), (len(frames), len(self._order))
        data.measured = wp.empty(shape, dtype=wp.vec3, device=self._device)
        data.weight = wp.empty(shape, dtype=float, device=self._device)
        data.error = wp.zeros(shape, dtype=wp.vec3, device=self._device)
        inputs = [self._positions, self._turn, self._weights, self._order, number, _doubles(base, self._device)]
        wp.launch(marker_frames.take_frames, shape, inputs, [data.measured, data.weight], device=self._device)
        return number

    def put(self, frames: Integers, number: wp.array, data: Any, better: bool) -> NDArray[np.bool_]:
        """Keep the errors of these frames, or of those that fit better than before; which are kept, (n,)."""
        found = wp.empty(len(frames), dtype=wp.float64, device=self._device)
        wp.launch(marker_frames.mean_squares, len(frames), [data.error, data.weight], [found], device=self._device)
        squares = found.numpy()
        kept = squares < self.squares[frames] if better else np.ones(len(frames), bool)
        self.squares[frames[kept]] = squares[kept]
        rows = to_device(np.flatnonzero(kept), int, self._device)
        shape = (len(rows), len(self._order))
        inputs = [data.error, self._positions, self._back, self._order, number, rows]
        wp.launch(marker_frames.put_errors, shape, inputs, [self._errors], device=self._device)
        return kept

    def errors(self) -> Floats:
        """Errors (F, K, 3) of all frames, m, in the axes recorded; NaN where a marker is missing."""
        return np.asarray(self._errors.numpy())

    def sums(self, starts: tuple[int, ...]) -> MarkerSums:
        """Sums by recording, which start at these frames."""
        ends = to_device([*starts, len(self.squares)], int, self._device)
        shape = (len(starts), len(self._order))
        found = [wp.empty(shape, dtype=kind, device=self._device) for kind in (wp.float64, wp.float64, int)]
        inputs = [self._positions, self._errors, ends]
        wp.launch(marker_frames.sum_markers, shape, inputs, found, device=self._device)
        return MarkerSums(*(array.numpy() for array in found))


def _doubles(places: Floats, device: Any) -> wp.array:
    """Places (..., 3) in double precision: a room is large beside what a marker misses by."""
    return wp.array(np.ascontiguousarray(places, np.float64), dtype=wp.vec3d, device=device)
