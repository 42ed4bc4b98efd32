"""Many quadratic programmes of one size on a device, and their solver."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.arrays import instance_zeros, starts, to_device
from warpmuscle.kernels.program.box_program import box_program
from warpmuscle.kernels.program.structs import Columns, Programs, ProgramWork


class ProgramBatch:
    """Room for P programmes of n coordinates and m controls.

    Attributes:
        numbers: what the programmes are; see `kernels.program.structs`. due: (P,) whether each is to be solved.
        control: (P, m). acceleration: (P, n). multiplier: (P, n) where the next search begins.
        iterations: (P,) -1 where the balance was not reached.
    """

    def __init__(
        self,
        programs: int,
        coordinates: int,
        rows: Sequence[Sequence[int]],
        device: Any,
        bounds: int = 1,
        apart: bool = True,
    ) -> None:
        """Make room.

        Args:
            rows: of each control the coordinates on which it acts, which increase.
            bounds: rows of gains and bounds: 1 where all programmes share them, or as many as there are programmes.
            apart: whether a GPU keeps the same number of neighbouring programmes side by side.
        """
        self.device, self._apart = device, apart and not device.is_cpu
        self.programs, self.coordinates, self.controls = programs, coordinates, len(rows)
        self.rows = [list(one) for one in rows]
        n, m, half = coordinates, max(len(rows), 1), coordinates * (coordinates + 1) // 2
        self.columns = Columns()
        self.columns.first = to_device(starts(map(len, rows)), int, device)
        self.columns.row = to_device(np.array([row for one in rows for row in one], dtype=np.int64), int, device)
        self.numbers = numbers = Programs()
        numbers.mass, numbers.weight = self._room(n * n), self._room(n * n)
        numbers.bias, numbers.wanted = self._room(n), self._room(n)
        numbers.entry = self._room(max(sum(map(len, rows)), 1))
        for name in ("gain", "low", "high"):
            setattr(numbers, name, instance_zeros((bounds, m), float, device, self._apart))
        self.work = ProgramWork()
        for name in ("factor", "reserve", "hessian"):
            setattr(self.work, name, self._room(half, dtype=wp.float64))
        self.work.square = self._room(n * n, dtype=wp.float64)
        self.work.vector, self.work.by_control = self._room(4, n, dtype=wp.float64), self._room(2, m, dtype=wp.float64)
        self.due = wp.full(programs, 1, dtype=int, device=device)
        self.control, self.acceleration = self._room(m), self._room(n)
        self.multiplier = self._room(n, dtype=wp.float64)
        self.iterations = wp.zeros(programs, dtype=int, device=device)

    def _room(self, *shape: int, dtype: Any = float) -> wp.array:
        return instance_zeros((self.programs, *shape), dtype, self.device, self._apart)

    def solve(self) -> None:
        """Solve all programmes that are due."""
        inputs = [self.numbers, self.columns, self.due, self.work, self.multiplier]
        outputs = [self.control, self.acceleration, self.iterations]
        wp.launch(box_program, self.programs, inputs, outputs, device=self.device)
