"""Launches of the fused kernel: on the GPU one for all instances, on the CPU slices of them on several threads."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.arrays import Ints
from warpmuscle.compiling import is_compiled
from warpmuscle.errors import RolloutError
from warpmuscle.kernels import structs
from warpmuscle.kernels.lanes import work_floats

SLICES_PER_THREAD = 4  # so that threads stay busy when some slices lose their instances sooner
GPU_LANES = 8
MOST_LANES = 16  # that are of use to a biped
WARP = 32  # lanes that a multiprocessor runs together
BUSY_WARPS = 8  # of them keep a multiprocessor about as busy as more do
SHARED_BYTES = 48 * 1024  # of memory that a block may declare
GPU_BLOCK = 32


class Launcher:
    """A fused kernel on a device, with the memory that its threads work in."""

    def __init__(self, kernel: Any, device: Any, capacity: int, lanes: int, block_dim: int, threads: int) -> None:
        """Prepare to launch; capacity is the kernel's in bodies."""
        self.kernel, self.device = kernel, device
        self._lanes, self._block_dim, self._threads = lanes, block_dim, threads
        buffers = threads if device.is_cpu else 1
        self._buffers = [wp.zeros(work_floats(capacity), dtype=float, device=device) for _ in range(buffers)]

    def load(self) -> None:
        """Have the kernel ready on the device, compiled now unless Warp has it in its cache."""
        self.kernel.module.load(self.device, self._block_dim)

    @property
    def compiles(self) -> bool:
        """Whether the kernel is yet to be compiled, for some seconds, when it is run."""
        return not is_compiled(self.kernel, self.device, self._block_dim)

    def launch(
        self, steps: int, running: Ints, model: structs.Model, state: structs.State, record: structs.Record
    ) -> None:
        """Make so many steps of the instances that run."""

        def slice_(part: wp.array, buffer: wp.array) -> None:
            wp.launch(
                self.kernel,
                dim=(len(part), self._lanes),
                inputs=[steps, part, model, state, record, wp.uint64(buffer.ptr)],
                device=self.device,
                block_dim=self._block_dim,
            )

        if not self.device.is_cpu:
            slice_(wp.array(running, dtype=int, device=self.device), self._buffers[0])
            return
        count = min(self._threads * SLICES_PER_THREAD, len(running))
        slices = [wp.array(part, dtype=int, device=self.device) for part in np.array_split(running, count)]
        if self._threads == 1 or count == 1:
            for part in slices:
                slice_(part, self._buffers[0])
            return
        self.load()  # threads must not meet in the compiler
        free = list(self._buffers)
        with ThreadPoolExecutor(self._threads) as pool:

            def work(part: wp.array) -> None:
                buffer = free.pop()
                slice_(part, buffer)
                free.append(buffer)

            list(pool.map(work, slices))


def usual_lanes(wanted: int | None, floats: int, instances: int, multiprocessors: int) -> int:
    """Lanes an instance on a GPU: as wanted, or the usual number, or more.

    More where few instances would leave multiprocessors idle, and where a large character needs it: the working sets of
    the instances of a block, `floats` numbers each, share the block's memory. Results do not depend on it.
    """
    fitting = [n for n in (1, 2, 4, 8, 16, 32) if GPU_BLOCK // n * floats * 4 <= SHARED_BYTES]
    if not fitting:
        raise RolloutError("the character has more bodies than a GPU block has memory for; simulate it on the CPU")
    if wanted is None:
        idle = [n for n in fitting if n <= MOST_LANES and n * instances <= BUSY_WARPS * WARP * multiprocessors]
        return max(GPU_LANES, fitting[0], *idle)
    if wanted not in fitting:
        raise RolloutError(f"lanes must be one of {', '.join(map(str, fitting))} for this character, not {wanted}")
    return wanted
