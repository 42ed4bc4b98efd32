"""Fits of coordinates to markers on a device: `kernels.inverse.marker_fit` for any number of frames.

Which frames are fitted first, and from where the others start, is told by `fit_plan`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.arrays import instance_zeros, structs_to_device, to_device
from warpmuscle.core.errors import ArgumentError
from warpmuscle.inverse.chain import Chain, Place
from warpmuscle.inverse.fit_plan import Plan, Problem, seen_in
from warpmuscle.inverse.recorded_markers import RecordedMarkers
from warpmuscle.kernels import marker_fit_structs as structs
from warpmuscle.kernels.body_structs import CubicPiece
from warpmuscle.kernels.inverse.marker_fit import fit_markers
from warpmuscle.scene.opensim_root import root_values

ROWS_ON_CPU, ROWS_ON_GPU = 64, 65536  # frames that are at work at once
FARTHEST = 1.0e6  # what stands for no limit on the device


@dataclass(frozen=True)
class Fit:
    """What was found in F frames."""

    values: Floats  # (F, C) rad or m
    errors: Floats  # (F, K, 3) m, measured less fitted, in the axes recorded; NaN where a marker is missing
    iterations: Integers  # (F,), negative if they were not enough
    loose: NDArray[np.bool_]  # (F, C), whether markers do not tell a coordinate


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
        count, coordinates = len(problem.positions), len(self.chain.coordinates)
        found = Fit(
            np.zeros((count, coordinates)), np.zeros((0, 0, 3)), np.zeros(count, np.int32),
            np.zeros((count, coordinates), bool),
        )  # fmt: skip
        recorded = recorded or self.recorded(problem)
        plan = Plan(problem, recorded.seen)
        self._solve(problem, recorded, plan.first, self._cold_starts(problem, plan.coarse), found)
        again, starts = plan.doubtful(found.values[plan.first], recorded.squares[plan.first])
        self._solve(problem, recorded, again, starts, found, better=True)
        between = plan.between(found.values[plan.first])
        self._solve(problem, recorded, plan.rest, between[plan.rest], found)
        again = plan.outliers(recorded.squares)
        if len(again):
            starts = self._cold_starts(problem, list(again[:, None]))
            self._solve(problem, recorded, again, starts, found, better=True)
        return replace(found, errors=recorded.errors())

    def _cold_starts(self, problem: Problem, parts: list[Integers]) -> Floats:
        """The model's pose at the start, its root where the markers are: (n, C).

        Args:
            parts: frames; from one to the next of a part, angles of the root are continuous.
        """
        chain, root, frames = self.chain, self.chain.opensim.root, np.concatenate(parts)
        values = np.tile(chain.neutral, (len(frames), 1))
        if root is None:
            return values
        resting = chain.poses(np.array(chain.neutral)[None])
        body = chain.places(resting, self._places)[0]
        turn, shift = aligned(body, problem.places(frames), problem.weights)
        last = len(root.rotations) + len(root.translations) - 1
        at = chain.places(resting, [Place(last, -_vector(root.position_in_child))])[0, 0]
        moved = np.einsum("fij,j->fi", turn, at) + shift
        from scipy.spatial.transform import Rotation  # takes a quarter of a second

        turned = (Rotation.from_matrix(turn) * Rotation.from_quat(resting[0][0, last])).as_quat()
        breaks = np.cumsum([len(part) for part in parts])[:-1]
        found = root_values(chain.opensim, moved, turned, breaks)
        values[:, : len(chain.opensim.root_coordinates)] = found
        return values

    def _solve(
        self,
        problem: Problem,
        recorded: RecordedMarkers,
        frames: Integers,
        starts: Floats,
        found: Fit,
        better: bool = False,
    ) -> None:
        """Fit some frames from some values on, and put what comes of it into what was found; or only what is better."""
        if not len(frames):
            return
        base = np.zeros_like(starts)  # of the root's shifts: what is left is small, so that float32 tells it well
        root = self.chain.opensim.root
        shifts = range(0)
        if root is not None:
            shifts = range(len(root.rotations), len(self.chain.opensim.root_coordinates))
            base[:, shifts] = starts[:, shifts]
        targets = problem.targets if len(problem.targets) == 1 else problem.targets[frames]
        if np.any(problem.task_weights[shifts] > 0.0):
            targets = targets - base
        device = self.device
        data = structs.FitFrames()
        number = recorded.take(frames, self._base_places(base), data)
        data.target = to_device(targets, float, device)
        data.value = to_device(starts - base, float, device)
        data.iterations = wp.zeros(len(frames), dtype=int, device=device)
        data.loose = wp.zeros(starts.shape, dtype=int, device=device)
        self._launch(data, problem.task_weights, len(frames))
        chosen = recorded.put(frames, number, data, better)
        kept = frames[chosen]
        found.values[kept] = (data.value.numpy().astype(np.float64) + base)[chosen]
        found.iterations[kept] = data.iterations.numpy()[chosen]
        found.loose[kept] = data.loose.numpy()[chosen] > 0

    def _base_places(self, base: Floats) -> Floats:
        """How far the root is moved by its shifts alone, (n, 3) m."""
        root = self.chain.opensim.root
        moved = np.zeros((len(base), 3))
        for k in range(len(root.translations) if root is not None else 0):
            one = self.chain.elements[k]
            moved += base[:, one.coordinate, None] * one.axis
        return moved

    def _launch(self, data: Any, task_weights: Floats, count: int) -> None:
        chain, device = self.chain, self.device
        given = structs.FitModel()
        given.element, given.piece, given.marker = self._elements, self._pieces, self._markers
        turning = np.zeros(len(chain.coordinates), np.int32)
        turning[[one.coordinate for one in chain.elements if one.turns and one.coordinate >= 0]] = 1
        columns = {
            "low": np.maximum(chain.low, -FARTHEST), "high": np.minimum(chain.high, FARTHEST),
            "weight": task_weights, "turns": turning,
        }  # fmt: skip
        given.coordinate = structs_to_device(structs.FitCoordinate, columns, device)
        rows = min(count, ROWS_ON_CPU if device.is_cpu else ROWS_ON_GPU)
        scratch = _scratch(rows, len(chain.elements), len(chain.coordinates), device)
        for first in range(0, count, rows):
            wp.launch(fit_markers, min(rows, count - first), [first, given, data, scratch], device=device)


def aligned(body: Floats, measured: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """Rotations (n, 3, 3) and shifts (n, 3) that bring points (K, 3) closest to measured ones (n, K, 3).

    Measured points are NaN where one is missing. By singular values (Kabsch 1976; Umeyama 1991, eq. 40).
    """
    seen = seen_in(measured)
    w = np.where(seen, weights, 0.0)
    w = w / np.maximum(w.sum(axis=1, keepdims=True), 1e-300)
    there = np.where(seen[..., None], measured, 0.0)
    middle, own = np.einsum("nk,nki->ni", w, there), np.einsum("nk,ki->ni", w, body)
    spread = np.einsum("nk,nki,nkj->nij", w, there - middle[:, None], body[None] - own[:, None])
    u, _, vt = np.linalg.svd(spread)
    u[:, :, 2] *= np.sign(np.linalg.det(u @ vt))[:, None]
    turn = u @ vt
    return turn, middle - np.einsum("nij,nj->ni", turn, own)


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
