"""Recorded markers on a device, and what is found of them there: which are seen, and how far a fit misses them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.arrays import instance_zeros, to_device
from warpmuscle.inverse.fit_plan import Problem, every_few
from warpmuscle.kernels.inverse import marker_frames

BUFFER = 8_000_000  # bytes
PIECE = 500  # frames of a recording that are summed up one after the other
ROOM = 1.5  # times the columns that count, which rows may have to be taken whole
SUDDEN = 3.0  # times what a marker misses by in the median frame: it jumps
NEAR = 1e-6  # part by which sums in another order may be off
BEYOND = 1e5  # m, that no marker of any unit is away


class MarkerSums(NamedTuple):
    """Sums over the frames of T recordings in which a marker is seen."""

    squares: Floats  # (T, K) m^2, of errors
    height: Floats  # (T, K) m
    seen: Integers  # (T, K) how many frames
    most: Floats  # (T, K) m^2, the greatest square
    near: Integers  # (T, K) frames that miss by less than the worst one does, even if by `SUDDEN` times as much


class RecordedMarkers:
    """The markers of a problem on a device.

    Attributes:
        seen: (F,) how many markers that count a frame shows. far: (F,) whether one of a frame is impossibly far away.
        positions: (F, columns) m, on the device. columns: (K,) of the markers. turn, back: into the axes of the fit,
            and out of them.
    """

    def __init__(self, problem: Problem, order: Integers, device: Any) -> None:
        """Args: order: (K,) the number of each marker of the fit among those recorded."""
        self.device, self.count, self.markers = device, problem.count, len(order)
        taken = _common_columns(problem)
        self.positions = _uploaded(problem, taken, device)
        columns = np.arange(self.markers) if taken is None else np.array(taken)
        self.columns, self.ordered_columns = (to_device(each, int, device) for each in (columns, columns[order]))
        self.order = to_device(order, int, device)
        self.turn, self.back = wp.mat33d(problem.turn.T), wp.mat33d(problem.turn)
        weights = np.asarray(problem.weights)
        self.weights = to_device(weights[order], float, device)
        found = [wp.empty(self.count, dtype=int, device=device) for _ in range(2)]
        inputs = [self.positions, self.columns, to_device(weights, float, device), BEYOND]
        wp.launch(marker_frames.look_at_frames, self.count, inputs, found, device=device)
        self.seen: Integers = found[0].numpy()
        self.far: NDArray[np.bool_] = found[1].numpy() > 0

    def take(self, number: wp.array, base: wp.array, data: Any) -> None:
        """Put the markers of frames with these numbers into the data of a fit, from places (n,) on."""
        shape, apart = (len(number), self.markers), not self.device.is_cpu
        data.measured = instance_zeros(shape, wp.vec3, self.device, apart)
        data.weight = instance_zeros(shape, float, self.device, apart)
        data.error = instance_zeros(shape, wp.vec3, self.device, apart)
        inputs = [self.positions, self.turn, self.weights, self.ordered_columns, number, base]
        wp.launch(marker_frames.take_frames, shape, inputs, [data.measured, data.weight], device=self.device)

    def aligned(self, number: wp.array, body: Floats) -> tuple[Floats, Floats]:
        """Rotations (n, 4) and shifts (n, 3) that bring points (K, 3) closest to markers of frames, axes of the fit.

        Args:
            body: in the order of the fit.
        """
        found = [wp.empty(len(number), dtype=kind, device=self.device) for kind in (wp.quatd, wp.vec3d)]
        points = wp.array(np.ascontiguousarray(body, np.float64), dtype=wp.vec3d, device=self.device)
        inputs = [self.positions, self.turn, self.weights, self.ordered_columns, number, points]
        wp.launch(marker_frames.align_frames, len(number), inputs, found, device=self.device)
        return found[0].numpy(), found[1].numpy()


class FittedFrames:
    """What has been found of all frames, on the device.

    Attributes:
        values: (F, C) rad or m. errors: (F, K) m, in the axes recorded. squares: (F,) weighted mean squares, m^2, and
            those of coordinates that have a target.
    """

    def __init__(self, markers: RecordedMarkers, coordinates: int, first_shift: int, shifts: int) -> None:
        self._markers, self._device = markers, markers.device
        self._first_shift, self._shifts = first_shift, shifts
        every = (markers.count, coordinates)
        self.values = wp.zeros(every, dtype=wp.float64, device=self._device)
        self._iterations = wp.zeros(markers.count, dtype=int, device=self._device)
        self._loose = wp.zeros(every, dtype=wp.uint8, device=self._device)
        self._squares = wp.zeros(markers.count, dtype=wp.float64, device=self._device)
        self._errors = wp.empty((markers.count, markers.markers), dtype=wp.vec3, device=self._device)

    def put(self, number: wp.array, start: wp.array, data: Any, task_weights: wp.array, better: bool) -> None:
        """Keep what was found of these frames, or of those that fit better than before.

        Args:
            task_weights: (C,) of squared distances of coordinates from their targets.
        """
        device, markers, n = self._device, self._markers, len(number)
        square = wp.empty(n, dtype=wp.float64, device=device)
        wp.launch(marker_frames.mean_squares, n, [data, task_weights], [square], device=device)
        kept = wp.empty(n, dtype=int, device=device)
        inputs = [number, better, square, start, self._first_shift, self._shifts, data]
        outputs = [self._squares, self.values, self._iterations, self._loose, kept]
        wp.launch(marker_frames.put_rows, n, inputs, outputs, device=device)
        inputs = [data.error, markers.positions, markers.back, markers.ordered_columns, markers.order, number, kept]
        wp.launch(marker_frames.put_errors, (n, markers.markers), inputs, [self._errors], device=device)

    @property
    def squares(self) -> Floats:
        """Weighted mean squares of the errors of all frames (F,), m^2, and of coordinates from their targets."""
        return np.asarray(self._squares.numpy())

    def jumps(self, first: int, turns: Integers) -> Floats:
        """By how much coordinates after those of the root turn from the frame before to each (F,), at most, rad.

        Args:
            first: number of these coordinates. turns: (C,) 1 of one that turns something.
        """
        found = wp.empty(self._markers.count, dtype=float, device=self._device)
        inputs = [self.values, first, to_device(turns, int, self._device)]
        wp.launch(marker_frames.find_jumps, self._markers.count, inputs, [found], device=self._device)
        return np.asarray(found.numpy())

    def found(self) -> tuple[Floats, Floats, Integers, NDArray[np.bool_]]:
        """Values (F, C), errors (F, K, 3), iterations (F,), and which coordinates are loose (F, C)."""
        arrays = (self.values, self._errors, self._iterations, self._loose)
        values, errors, iterations, loose = (array.numpy() for array in arrays)
        return values, errors, iterations, loose.view(bool)

    def sums(self, starts: Integers) -> MarkerSums:
        """Sums by recording, which start at these frames; of a long one they are put together from pieces."""
        ends = np.append(starts[1:], self._markers.count)
        pieces, counts = every_few(starts, ends, PIECE)
        first = np.cumsum(counts) - counts
        edges = to_device([*pieces, self._markers.count], int, self._device)
        shape = (len(pieces), self._markers.markers)
        kinds = (wp.float64, wp.float64, int, wp.float64)
        found = [wp.empty(shape, dtype=kind, device=self._device) for kind in kinds]
        inputs = [self._markers.positions, self._markers.columns, self._errors, edges]
        wp.launch(marker_frames.sum_markers, shape, inputs, found, device=self._device)
        squares, height, seen, most = (array.numpy() for array in found)
        greatest = np.maximum.reduceat(most, first)
        near = wp.empty(shape, dtype=int, device=self._device)
        inputs += [
            SUDDEN * (1.0 - NEAR),
            wp.array(np.repeat(greatest, counts, axis=0), dtype=wp.float64, device=self._device),
        ]
        wp.launch(marker_frames.count_near, shape, inputs, [near], device=self._device)
        squares, height, seen, close = (np.add.reduceat(each, first) for each in (squares, height, seen, near.numpy()))
        return MarkerSums(squares, height, seen, greatest, close)


def _common_columns(problem: Problem) -> list[int] | None:
    """The columns of all recordings, if whole rows are taken to the device since few others stand in them."""
    first = problem.recordings[0]
    shape = first.positions.shape[1:]
    alike = all(one.columns == first.columns and one.positions.shape[1:] == shape for one in problem.recordings)
    return first.columns if alike and shape[0] <= ROOM * len(first.columns) else None


def _uploaded(problem: Problem, taken: list[int] | None, device: Any) -> wp.array:
    """Positions of all frames (F, columns) on the device, in double precision, since a room is large beside errors.

    They come to a GPU by two buffers of locked memory, of which one is filled while the other is copied; fresh memory
    for all would take longer than to fill it.

    Args:
        taken: see `_common_columns`; without, only columns that count are there.
    """
    count = problem.count
    width = len(problem.weights) if taken is None else problem.recordings[0].positions.shape[1]
    found = wp.empty((count, width), dtype=wp.vec3d, device=device)
    room = count if device.is_cpu else min(max(BUFFER // (24 * width), 1), count)
    buffers = _Buffers(found, room, width)
    for one in problem.recordings:
        first, frames = 0, len(one.positions)
        while first < frames:
            place = buffers.place(frames - first)
            n = len(place)
            part = one.positions[first : first + n]
            if taken is not None:
                place[:] = part
            else:
                np.take(part, one.columns, axis=1, out=place, mode="clip")
            buffers.filled(n)
            first += n
    buffers.finish()
    return found


class _Buffers:
    """Memory on the host through which rows come to an array on a device; on a CPU it is the array itself."""

    def __init__(self, found: wp.array, room: int, width: int) -> None:
        """Args: room: rows of a buffer. width: numbers of vectors in a row."""
        self._found, self._room, self._width = found, room, width
        self._on_cpu = found.device.is_cpu
        self._arrays = (
            [found] if self._on_cpu else [wp.empty((room, width), dtype=wp.vec3d, device="cpu", pinned=True)
                                          for _ in range(2)]
        )  # fmt: skip
        self._views = [one.numpy() for one in self._arrays]
        self._events: list[Any] = [None] * len(self._arrays)
        self._turn = self._rows = self._sent = 0

    def place(self, rows: int) -> Floats:
        """Where so many rows come, or fewer if the buffer is full before."""
        if self._rows == 0 and self._events[self._turn] is not None:
            wp.synchronize_event(self._events[self._turn])  # the copy from it has to be done
        return np.asarray(self._views[self._turn][self._rows : min(self._rows + rows, self._room)])

    def filled(self, rows: int) -> None:
        """So many rows have come; a full buffer goes to the device."""
        self._rows += rows
        if self._rows == self._room:
            self._send()

    def finish(self) -> None:
        """Send what is left, and wait until all is there."""
        self._send()
        for event in self._events:
            if event is not None:
                wp.synchronize_event(event)

    def _send(self) -> None:
        if self._on_cpu or self._rows == 0:
            return
        first, count = self._sent * self._width, self._rows * self._width
        wp.copy(self._found, self._arrays[self._turn], dest_offset=first, count=count)
        self._events[self._turn] = wp.get_stream(self._found.device).record_event()
        self._sent, self._rows, self._turn = self._sent + self._rows, 0, 1 - self._turn
