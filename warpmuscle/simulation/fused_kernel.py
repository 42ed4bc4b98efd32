"""A fused kernel and its launches: of slices of the instances, on several threads of a CPU or streams of a GPU.

A GPU that holds fewer instances than there are runs them in waves, and the last wave of a launch may leave most of it
idle. So instances that do not fit at once are shared out over streams, whose launches are cut into pieces: while one
stream waits for its last blocks, the others' fill the GPU.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import cached_property
from itertools import pairwise
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Integers
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.warp_start import no_cache
from warpmuscle.kernels import structs
from warpmuscle.kernels.memory.main_memory import SIDE, Apart
from warpmuscle.kernels.memory.scratch import NEAR, slots_of, work_floats
from warpmuscle.kernels.path_kernels import PATH_BLOCK, paths_kernel
from warpmuscle.kernels.stable import MOVED
from warpmuscle.kernels.step import (
    MAX_REGISTERS,
    REGISTERS,
    SHARED_BY_SYSTEM,
    SHARED_MEMORY,
    WARP,
    blocks_of,
    registers_of,
    step_kernel,
)
from warpmuscle.kernels.step_parts import StepKind
from warpmuscle.simulation.kernel_cache import compiling_reported, is_compiled

SLICES_PER_THREAD = 4  # so that threads stay busy when some slices lose their instances sooner
GPU_BLOCK = 32
REGISTERS_AT_ONCE = 8 * 32  # that a warp gets or does not
STREAMS = 4
WAVES = 24  # that the pieces of one launch make together at least, where instances do not fit at once

PLACE = re.compile(r'Error while parsing function "([^"]+)" at (.+?):(\d+):')  # as Warp says it

ABSENT = re.compile(r"`(\w+)` is not an attribute of '(\w+)' \([\w.]*?(\w+)\)")

_making = Lock()  # Warp's own tables are not made for several threads
_loading: dict[tuple[Any, str], Lock] = {}  # of kernels on devices: different ones may be compiled at the same time
_loaded: set[tuple[Any, str]] = set()  # those that are there


class KernelConfig(NamedTuple):
    """What a fused kernel is made of; see `kernels.step.step_kernel`."""

    capacity: int
    lanes: int
    block_dim: int
    kind: StepKind
    slots: int | None = None  # of feet; None for those of the size class

    def compiling(self, **parts: Any) -> KernelConfig:
        """The same with other parts of the step, see `StepKind`."""
        return self._replace(kind=self.kind._replace(**parts))

    @property
    def work_floats(self) -> int:
        """Numbers of the working set of an instance."""
        muscles, skeleton = self.kind.muscles, self.kind.skeleton
        monomials = 0 if muscles is None else muscles.paths.monomials
        parts = skeleton.open, skeleton.constraints, skeleton.near_entries, skeleton.main
        return int(work_floats(self.capacity, skeleton.with_coordinates, monomials, self.slots, *parts))

    def buffer_floats(self, instances: int) -> int:
        """Numbers of what so many instances keep in a GPU's main memory, or else of the working set of one."""
        if self.kind.skeleton.main == NEAR:
            return self.work_floats
        return int(self.apart.floats * (-(-instances // SIDE) * SIDE))

    @property
    def apart(self) -> Apart:
        """What of a working set is in a GPU's main memory."""
        slots = slots_of(self.capacity) if self.slots is None else self.slots
        return self.kind.skeleton.apart(self.capacity, slots)

    @property
    def paths_apart(self) -> bool:
        """Whether a kernel of their own finds paths of muscles before each step."""
        return bool(self.kind.paths_apart)

    @property
    def several_warps(self) -> bool:
        """Whether lanes of an instance are in several warps, and neighbours in a warp of several instances."""
        return bool(self.block_dim > WARP)

    @property
    def instances_a_block(self) -> int:
        """Instances that share a block."""
        return max(self.block_dim // self.lanes, 1)

    def rows(self, instances: int) -> int:
        """Rows of lanes that so many instances are launched with: of whole blocks, where they span several warps."""
        count = self.instances_a_block
        return -(-instances // count) * count if self.several_warps else instances

    @property
    def block_bytes(self) -> int:
        """Bytes of shared memory that the working sets of a block take."""
        return 4 * self.instances_a_block * self.work_floats

    @property
    def large_blocks(self) -> int:
        """Blocks of several warps that fit a multiprocessor."""
        return int(blocks_of(self.block_dim, self.instances_a_block * self.work_floats, self.kind.muscles))

    def resident(self, multiprocessors: int) -> int:
        """Instances that so many multiprocessors have room for at once."""
        if self.several_warps:
            return multiprocessors * self.large_blocks * self.instances_a_block
        blocks = resident_blocks(self.instances_a_block * self.work_floats, registers_of(self.kind.muscles))
        return int(multiprocessors * blocks * self.instances_a_block)


@contextmanager
def one_line_errors() -> Iterator[None]:
    """Turn what Warp says of code that it cannot compile, or cannot put down, into a RolloutError."""
    try:
        yield
    except OSError as error:
        raise RolloutError(no_cache(error)) from None
    except Exception as error:
        text = " ".join((str(error.args[0]) if error.args else str(error)).split())
        said = text.rpartition(";")[2]  # of the innermost function, whose place stands before it
        places = PLACE.findall(text)
        where = "a kernel does not compile"
        if places:
            name, file, line = places[-1]
            where = f"{file}:{line}: function {name!r} does not compile"
        raise RolloutError(f"{where}: {said}{_moved(said)}") from error


def _moved(said: str) -> str:
    """Where a field is now that a function of a user's reads where it was, if that is what Warp says."""
    found = ABSENT.search(said)
    new = MOVED.get(f"{found[3]}.{found[1]}") if found else None
    return f"; it is `{found[2]}.{new}` now, of a simbicon controller" if found and new else ""


class FusedKernel:
    """The fused kernel of a configuration on a device, with the memory that its threads work in."""

    def __init__(self, config: KernelConfig, device: Any, threads: int, instances: int = 1) -> None:
        """Prepare to launch so many instances; raises RolloutError for functions of users that are no Warp code."""
        with one_line_errors(), _making:
            self.kernel = step_kernel(*config)
            self._before = self._kernels_before(config)
        self.config, self.device, self._threads = config, device, threads
        buffers = threads if device.is_cpu else 1
        self._loaded = False
        self._sliced: tuple[Integers | None, list[wp.array]] = (None, [])
        # An array has fewer than 2^31 numbers a dimension.
        rows = -(-instances // SIDE) * SIDE if config.kind.skeleton.main > NEAR else 1
        shape = config.buffer_floats(instances) // rows, rows
        self._buffers = [wp.zeros(shape, dtype=float, device=device) for _ in range(buffers)]

    @staticmethod
    def _kernels_before(config: KernelConfig) -> list[tuple[Any, int]]:
        """Kernels that are launched before each step, with their threads a block: those that find paths, if any do."""
        if not config.paths_apart:
            return []
        paths, threads = paths_kernel(config.kind.muscles, config.several_warps), config.several_warps and PATH_BLOCK
        return [(step_kernel(*config, places=True), config.block_dim), (paths, threads or 1)]

    def load(self) -> None:
        """Have the kernel ready on the device, compiled now unless Warp has it in its cache.

        Raises:
            RolloutError: it does not compile, as may be with functions of users.
        """
        if not self._loaded:
            key = (self.config, str(self.device))
            with one_line_errors(), _loading.setdefault(key, Lock()), self._compiling():
                for kernel, block_dim in (*self._before, (self.kernel, self.config.block_dim)):
                    kernel.module.load(self.device, block_dim)
            self._loaded = True
            _loaded.add(key)

    def _compiling(self) -> AbstractContextManager[None]:
        """What tells of compiling, if there is anything to compile."""
        if not self.compiles:
            return nullcontext()
        muscles = "muscles and joints" if self.config.kind.muscles is not None else "joints"
        return compiling_reported(f"{muscles} of this kind of scene for {self.device}")

    @property
    def compiles(self) -> bool:
        """Whether the kernel is yet to be compiled, for some seconds, when it is run."""
        own = (*self._before, (self.kernel, self.config.block_dim))
        return not all(is_compiled(kernel, self.device, block_dim) for kernel, block_dim in own)

    def launch(
        self,
        steps: int,
        running: Integers,
        model: structs.Model,
        state: structs.State,
        record: structs.Record,
        extension: Any,
    ) -> None:
        """Make so many steps of the instances that run."""
        self.load()  # before threads, which must not meet in the compiler
        slices = self._slices_of(running)

        def at_once(count: int, part: wp.array, buffer: wp.array, stream: wp.Stream | None = None) -> None:
            wp.launch(
                self.kernel,
                dim=(self.config.rows(len(part)), self.config.lanes),
                inputs=[count, part, model, state, record, wp.uint64(buffer.ptr), extension],
                device=self.device,
                stream=stream,
                block_dim=self.config.block_dim,
            )

        def each(count: int, part: wp.array, buffer: wp.array) -> None:
            own = self.commands(1, part, buffer, model, state, record, extension)
            for _ in range(count):
                for command in own:
                    command.launch()

        slice_ = each if self._before else at_once
        if self.device.is_cpu and len(slices) > 1:
            self._on_threads(lambda part, buffer: slice_(steps, part, buffer), slices)
        elif self.device.is_cpu:
            slice_(steps, slices[0], self._buffers[0])
        elif self._before:
            make = [self.commands(1, part, self._buffers[0], model, state, record, extension) for part in slices]
            self._in_turn(steps, make)
        elif len(slices) == 1:
            at_once(steps, slices[0], self._buffers[0])
        else:
            pieces = piece_lengths(steps, self._waves(len(running)))
            self._on_streams(lambda piece, part, stream: at_once(piece, part, self._buffers[0], stream), pieces, slices)

    def _in_turn(self, steps: int, slices: list[list[wp.Launch]]) -> None:
        """Launch so many steps of every slice, several kernels each; later work waits for all."""
        now, streams = self.device.stream, self._streams[: len(slices)]
        for stream in streams:
            stream.wait_stream(now)
        for _ in range(steps):
            for own, stream in zip(slices, streams, strict=True):
                for command in own:
                    command.launch(stream)
        for stream in streams:
            now.wait_stream(stream)

    def commands(
        self, steps: int, part: wp.array, buffer: wp.array, model: structs.Model, state: structs.State,
        record: structs.Record, extension: Any,
    ) -> list[wp.Launch]:  # fmt: skip
        """What makes so many steps of some instances; where a kernel of their own finds paths, one."""
        rows = (self.config.rows(len(part)), self.config.lanes)
        step = [steps, part, model, state, record, wp.uint64(buffer.ptr), extension]
        given = [(self.kernel, rows, step, self.config.block_dim)]
        if self._before:
            (places, _), (paths, threads) = self._before
            threads_of_paths = (model.muscles.count, -(-len(part) // WARP) * WARP)
            given = [
                (places, rows, step, self.config.block_dim),
                (paths, threads_of_paths, [part, model, state], threads),
                *given,
            ]
        return [
            wp.launch(kernel, dim, inputs, device=self.device, block_dim=block_dim, record_cmd=True)
            for kernel, dim, inputs, block_dim in given
        ]

    def _on_threads(self, run: Callable[[wp.array, wp.array], None], slices: list[wp.array]) -> None:
        """Run every slice, each with another buffer."""
        free = list(self._buffers)

        def work(part: wp.array) -> None:
            buffer = free.pop()
            run(part, buffer)
            free.append(buffer)

        launched = [self._pool.submit(work, part) for part in slices]
        wait(launched)  # also of those behind one that fails, so that the state is at rest then
        for one in launched:
            one.result()

    def _on_streams(
        self, run: Callable[[int, wp.array, wp.Stream], None], pieces: list[int], slices: list[wp.array]
    ) -> None:
        """Run pieces of so many steps of every slice, each slice on another stream; later work waits for all."""
        now = self.device.stream
        for stream in self._streams:
            stream.wait_stream(now)
        for piece in pieces:
            for part, stream in zip(slices, self._streams, strict=True):
                run(piece, part, stream)
        for stream in self._streams:
            now.wait_stream(stream)

    @cached_property
    def _streams(self) -> list[wp.Stream]:
        return [wp.Stream(self.device) for _ in range(STREAMS)]

    def _waves(self, instances: int) -> float:
        """How often over the GPU's multiprocessors would be full with so many instances."""
        return instances / self.config.resident(self.device.sm_count)

    @cached_property
    def _pool(self) -> ThreadPoolExecutor:
        return ThreadPoolExecutor(self._threads)

    def _slices_of(self, running: Integers) -> list[wp.array]:
        """The instances that run, on the device, shared out; kept for the next launch of the same array."""
        if self._sliced[0] is not running:
            count = 1
            if self.device.is_cpu and self._threads > 1:
                count = min(self._threads * SLICES_PER_THREAD, len(running))
            elif not self.device.is_cpu and self._waves(len(running)) > 1.0:
                count = STREAMS
            slices = [wp.array(part, dtype=int, device=self.device) for part in np.array_split(running, count)]
            self._sliced = running, slices
        return self._sliced[1]


def resident_blocks(floats: int, registers: int = MAX_REGISTERS) -> int:
    """Blocks of GPU_BLOCK lanes that a multiprocessor holds at once.

    Args:
        floats: numbers of the working sets of a block. registers: of a lane.
    """
    warps = REGISTERS // (-(-GPU_BLOCK * registers // REGISTERS_AT_ONCE) * REGISTERS_AT_ONCE)
    return int(min(warps // 4 * 4, SHARED_MEMORY // (4 * floats + SHARED_BY_SYSTEM)))


def piece_lengths(steps: int, waves: float) -> list[int]:
    """Into how many steps each a launch is cut that keeps a GPU busy for so many waves."""
    pieces = min(math.ceil(WAVES / waves), steps)
    ends = [steps * k // pieces for k in range(pieces + 1)]
    return [after - before for before, after in pairwise(ends)]


def is_loaded(config: KernelConfig, device: Any) -> bool:
    """Whether the kernel of a configuration has been loaded by any batch."""
    return (config, str(device)) in _loaded
