"""Fits of coordinates to markers on a device: `kernels.inverse.marker_fit` for any number of frames.

Which frames are fitted first, and from where the others start, is told by `fit_plan`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.arrays import instance_zeros, structs_to_device, to_device
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.pose import multiply, rotate
from warpmuscle.inverse.chain import Chain, Place
from warpmuscle.inverse.fit_plan import Between, Plan, Problem
from warpmuscle.inverse.recorded_markers import FittedFrames, MarkerSums, RecordedMarkers
from warpmuscle.kernels import marker_fit_structs as structs
from warpmuscle.kernels.body_structs import CubicPiece
from warpmuscle.kernels.inverse import marker_frames
from warpmuscle.kernels.inverse.marker_fit import fit_markers
from warpmuscle.scene.opensim_root import root_values

ROWS_ON_CPU, ROWS_ON_GPU = 64, 65536  # frames that are at work at once
FARTHEST = 1.0e6  # what stands for no limit on the device


@dataclass(frozen=True)
class Fit:
    """What was found in F frames."""

    values: Floats  # (F, C) rad or m
    errors: Floats  # (F, K, 3) m, float32: measured less fitted, in the axes recorded; NaN where a marker is missing
    iterations: Integers  # (F,), negative if they were not enough
    loose: NDArray[np.bool_]  # (F, C), whether markers do not tell a coordinate
    sums: MarkerSums  # by recording


class MarkerFitter:
    """A model and its markers on a device.

    Args:
        chain: of the model. markers: which of its markers are measured, in their order.
    """

    def __init__(self, chain: Chain, markers: list[Place], device: Any) -> None:
        self.chain, self.device = chain, device
        self._order = np.array(sorted(range(len(markers)), key=lambda k: markers[k].element), dtype=np.int64)
        self._places = markers
        if not chain.coordinates:
            raise ArgumentError("the model has no coordinate that could move")
        self.turns = np.zeros(len(chain.coordinates), np.int32)  # 1 of a coordinate that turns something
        self.turns[[one.coordinate for one in chain.elements if one.turns and one.coordinate >= 0]] = 1
        self._elements, self._pieces = _elements(chain, device)
        placed = [markers[k] for k in self._order]
        columns = {"element": np.array([p.element for p in placed]), "point": np.array([p.point for p in placed])}
        self._markers = structs_to_device(structs.FitMarker, columns, device)

    def recorded(self, problem: Problem) -> RecordedMarkers:
        """The markers of a problem on the device."""
        return RecordedMarkers(problem, self._order, self.device)

    def fit(self, problem: Problem, recorded: RecordedMarkers | None = None) -> Fit:
        """The coordinates that fit best, all frames at once.

        Args:
            recorded: the markers of the problem, if they are on the device already.

        Raises:
            SignalError: no frame of a recording shows three markers.
        """
        recorded = recorded or self.recorded(problem)
        plan, fit = Plan(problem, recorded.seen), _Run(self, problem, recorded)
        fit.from_afar(plan.first, plan.coarse)
        fit.from_others(*plan.doubtful(fit.found.squares))
        fit.between(plan.rest, plan.between())
        fit.from_others(*plan.jumped(fit.found.squares, fit.jumps()))
        again = plan.outliers(fit.found.squares)
        fit.from_afar(again, list(again[:, None]), better=True)
        return Fit(*fit.found.found(), fit.found.sums(problem.starts))

    def cold_starts(self, markers: RecordedMarkers, number: wp.array, parts: list[Integers]) -> Floats:
        """The model's pose at the start, its root where the markers of frames with these numbers are: (n, C)."""
        chain, root = self.chain, self.chain.opensim.root
        values = np.tile(chain.neutral, (len(number), 1))
        if root is None:
            return values
        resting = chain.poses(np.array(chain.neutral)[None])
        turn, shift = markers.aligned(number, chain.places(resting, self._places)[0][self._order])
        last = len(root.rotations) + len(root.translations) - 1
        at = chain.places(resting, [Place(last, -_vector(root.position_in_child))])[0, 0]
        turned = multiply(turn, np.broadcast_to(resting[0][0, last], turn.shape))
        breaks = np.cumsum([len(part) for part in parts])[:-1]
        found = root_values(chain.opensim, rotate(turn, np.broadcast_to(at, shift.shape)) + shift, turned, breaks)
        values[:, : len(chain.opensim.root_coordinates)] = found
        return values

    def launch(self, data: Any, task_weights: Floats, count: int) -> None:
        chain, device = self.chain, self.device
        given = structs.FitModel()
        given.element, given.piece, given.marker = self._elements, self._pieces, self._markers
        columns = {
            "low": np.maximum(chain.low, -FARTHEST), "high": np.minimum(chain.high, FARTHEST),
            "weight": task_weights, "turns": self.turns,
        }  # fmt: skip
        given.coordinate = structs_to_device(structs.FitCoordinate, columns, device)
        rows = min(count, ROWS_ON_CPU if device.is_cpu else ROWS_ON_GPU)
        scratch = _scratch(rows, len(chain.elements), len(chain.coordinates), device)
        for first in range(0, count, rows):
            wp.launch(fit_markers, min(rows, count - first), [first, given, data, scratch], device=device)


class _Run:
    """The fit of one problem: which frames start where, and what has been found."""

    def __init__(self, fitter: MarkerFitter, problem: Problem, markers: RecordedMarkers) -> None:
        self._fitter, self._problem, self._markers, self._device = fitter, problem, markers, fitter.device
        chain, root = fitter.chain, fitter.chain.opensim.root
        first = len(root.rotations) if root is not None else 0
        shifts = chain.elements[: len(root.translations)] if root is not None else []
        self._first_shift = first
        self._axes = _doubles(np.array([one.axis for one in shifts]).reshape(-1, 3), wp.vec3d, self._device)
        self._targets = _doubles(problem.targets, wp.float64, self._device)
        self._task_weights = _doubles(problem.task_weights, wp.float64, self._device)
        self.found = FittedFrames(markers, len(chain.coordinates), first, len(shifts))

    def from_afar(self, frames: Integers, parts: list[Integers], better: bool = False) -> None:
        """Fit frames from the model's pose at the start, its root where the markers are.

        Args:
            parts: the same frames; from one to the next of a part, angles of the root are continuous.
        """
        if len(frames):
            number = to_device(frames, int, self._device)
            starts = self._fitter.cold_starts(self._markers, number, parts)
            self._solve(number, _doubles(starts, wp.float64, self._device), better)

    def from_others(self, frames: Integers, others: Integers) -> None:
        """Fit frames from the solutions of others on, and keep what is better."""
        self.between(frames, Between(others, others, np.zeros(len(others))), better=True)

    def between(self, frames: Integers, others: Between, better: bool = False) -> None:
        """Fit frames from between others on."""
        if not len(frames):
            return
        number = to_device(frames, int, self._device)
        start = wp.empty((len(frames), self.found.values.shape[1]), dtype=wp.float64, device=self._device)
        ends = [to_device(one, int, self._device) for one in (others.left, others.right)]
        inputs = [self.found.values, *ends, _doubles(others.part, wp.float64, self._device)]
        wp.launch(marker_frames.start_between, start.shape, inputs, [start], device=self._device)
        self._solve(number, start, better)

    def jumps(self) -> Floats:
        """By how much coordinates turn from the frame before to each (F,), rad, but those of the root."""
        return self.found.jumps(len(self._fitter.chain.opensim.root_coordinates), self._fitter.turns)

    def _solve(self, number: wp.array, start: wp.array, better: bool) -> None:
        """Fit frames with these numbers from coordinates (n, C) on, and keep what comes of it, or the better part."""
        device, shape, apart = self._device, start.shape, not self._device.is_cpu
        data, base = structs.FitFrames(), wp.empty(len(number), dtype=wp.vec3d, device=device)
        data.value = instance_zeros(shape, float, device, apart)
        data.target = instance_zeros(shape, float, device, apart)
        data.iterations = wp.zeros(len(number), dtype=int, device=device)
        data.loose = instance_zeros(shape, int, device, apart)
        inputs = [start, self._first_shift, self._axes, self._targets, number]
        outputs = [data.value, base, data.target]
        wp.launch(marker_frames.start_rows, len(number), inputs, outputs, device=device)
        self._markers.take(number, base, data)
        self._fitter.launch(data, self._problem.task_weights, len(number))
        self.found.put(number, start, data, self._task_weights, better)


def _doubles(values: Floats, kind: Any, device: Any) -> wp.array:
    return wp.array(np.ascontiguousarray(values, np.float64), dtype=kind, device=device)


def _elements(chain: Chain, device: Any) -> tuple[Any, Any]:
    """Elements and pieces of their functions on a device."""
    first, start, c = [0], [], []
    for one in chain.elements:
        start.append(one.function[0])
        c.append(one.function[1])
        first.append(first[-1] + len(one.function[0]))
    columns = {
        "parent": np.array([one.parent for one in chain.elements]),
        "coordinate": np.array([one.coordinate for one in chain.elements]),
        "turns": np.array([one.turns for one in chain.elements]),
        "first_piece": np.array(first[:-1]), "end_piece": np.array(first[1:]),
        "axis": np.array([one.axis for one in chain.elements]),
        "offset": np.array([one.offset for one in chain.elements]),
    }  # fmt: skip
    pieces = structs_to_device(CubicPiece, {"start": np.concatenate(start), "c": np.concatenate(c)}, device)
    return structs_to_device(structs.FitElement, columns, device), pieces


def _scratch(rows: int, elements: int, coordinates: int, device: Any) -> Any:
    """Working memory for so many frames at once."""
    work = structs.FitScratch()
    of_elements = {
        "orientation": wp.quat, "mass": float, "second_moment": wp.mat33, "spread": wp.mat33,
        **dict.fromkeys(("origin", "turning", "moving", "first_moment", "pull", "twist"), wp.vec3),
    }  # fmt: skip
    for name, dtype in of_elements.items():
        setattr(work, name, instance_zeros((rows, elements), dtype, device, not device.is_cpu))
    for name in ("slope", "diagonal", "last", "held"):
        dtype = int if name == "held" else float
        setattr(work, name, instance_zeros((rows, coordinates), dtype, device, not device.is_cpu))
    work.matrix = instance_zeros((rows, coordinates, coordinates), float, device, not device.is_cpu)
    return work


def _vector(given: Any) -> Floats:
    return np.array([float(x) for x in given])
