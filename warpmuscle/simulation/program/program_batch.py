"""Many quadratic programmes of one size on a device, and their solver."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.arrays import instance_zeros, starts, to_device
from warpmuscle.kernels.program.box_program import box_program
from warpmuscle.kernels.program.lane_program import doubles_of, lane_program_of
from warpmuscle.kernels.program.lanes import LANES
from warpmuscle.kernels.program.structs import Columns, Programs, ProgramWork
from warpmuscle.simulation.program.lane_tables import put_lane_tables

MOST_SHARED = 6144  # numbers of 8 bytes, that a block of a GPU may keep in shared memory without asking for more
ALONE = 64  # threads a block of programmes that have one thread each


class ProgramBatch:
    """Room for P programmes of n coordinates and m controls.

    On a GPU the lanes of a warp share a programme, whose numbers lie in shared memory; on a CPU each has a thread.

    Attributes:
        numbers: what the programmes are; see `kernels.program.structs`. every: (P,) the number of each.
        control: (P, m). acceleration: (P, n). multiplier: (P, n) where the next search begins.
        iterations: (P,) -1 where the balance was not reached.
        lanes: that share a programme; 0: each has a thread.
    """

    def __init__(
        self,
        programs: int,
        coordinates: int,
        rows: Sequence[Sequence[int]],
        device: Any,
        bounds: int = 1,
        apart: bool = True,
        lanes: int | None = None,
    ) -> None:
        """Make room.

        Args:
            rows: of each control the coordinates on which it acts, which increase.
            bounds: rows of gains and bounds: 1 where all programmes share them, or as many as there are programmes.
            apart: whether a GPU keeps the same number of neighbouring programmes side by side where each has a thread.
            lanes: by default those of a warp on a GPU that has room for it, and none on a CPU; 1 on a CPU does the same
                as they do.
        """
        self.programs, self.coordinates, self.controls = programs, coordinates, len(rows)
        self.rows, self.device = [list(one) for one in rows], device
        n, m, half = coordinates, max(len(rows), 1), coordinates * (coordinates + 1) // 2
        entries = sum(map(len, rows))
        self._doubles = doubles_of(n, len(rows), entries)
        fits = self._doubles <= MOST_SHARED
        self.lanes = (LANES if fits and not device.is_cpu else 0) if lanes is None else lanes
        self._apart = apart and self.lanes == 0 and not device.is_cpu
        self.columns = Columns()
        self.columns.first = to_device(starts(map(len, rows)), int, device)
        self.columns.row = to_device(np.array([row for one in rows for row in one], dtype=np.int64), int, device)
        put_lane_tables(self.columns, rows if self.lanes else [], n, device)
        self.numbers = numbers = Programs()
        numbers.mass, numbers.weight = self._room(n * n), self._room(n * n)
        numbers.bias, numbers.wanted = self._room(n), self._room(n)
        numbers.entry = self._room(max(entries, 1))
        for name in ("gain", "low", "high"):
            setattr(numbers, name, self._room(m, rows=bounds))
        self.work = ProgramWork()
        self.work.factor = self._room(half, dtype=wp.float64)
        self.work.vector = self._room(4, n, dtype=wp.float64)
        alone = self.lanes == 0
        for name in ("reserve", "hessian"):
            setattr(self.work, name, self._room(half if alone else 0, dtype=wp.float64))
        self.work.square = self._room(n * n if alone else 0, dtype=wp.float64)
        self.work.by_control = self._room(2, m if alone else 0, dtype=wp.float64)
        self.work.memory = self._room(self._doubles if self.lanes == 1 else 0, dtype=wp.float64)
        self.every = wp.array(np.arange(programs, dtype=np.int32), dtype=int, device=device)
        self.control, self.acceleration = self._room(m), self._room(n)
        self.multiplier = self._room(n, dtype=wp.float64)
        self.iterations = wp.zeros(programs, dtype=int, device=device)

    def _room(self, *shape: int, dtype: Any = float, rows: int | None = None) -> wp.array:
        """Zeros of every programme, or of so many rows."""
        return instance_zeros((self.programs if rows is None else rows, *shape), dtype, self.device, self._apart)

    def solve(self, chosen: wp.array | None = None) -> None:
        """Solve the programmes of these numbers, by default all."""
        chosen = self.every if chosen is None else chosen
        inputs = [chosen, self.numbers, self.columns, self.work, self.multiplier]
        outputs = [self.control, self.acceleration, self.iterations]
        if self.lanes == 0:
            wp.launch(box_program, len(chosen), inputs, outputs, device=self.device, block_dim=ALONE)
            return
        kernel, shape = lane_program_of(self.lanes, self._doubles), (len(chosen), self.lanes)
        wp.launch(kernel, shape, inputs, outputs, device=self.device, block_dim=LANES)
