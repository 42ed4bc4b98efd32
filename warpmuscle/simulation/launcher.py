"""Launches of the fused kernel: of slices of the instances, on several threads of a CPU or streams of a GPU.

A GPU that holds fewer instances than there are runs them in waves, and the last wave of a launch may leave most of it
idle. So instances that do not fit at once are shared out over streams, whose launches are cut into pieces: while one
stream waits for its last blocks, the others' fill the GPU.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from functools import cached_property
from itertools import pairwise
from threading import Lock, Thread
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Integers
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.warp_start import no_cache
from warpmuscle.kernels import structs
from warpmuscle.kernels.control import SIMBICON, Controller
from warpmuscle.kernels.joint_motion import MotionOf
from warpmuscle.kernels.muscle_stage import MuscleKind
from warpmuscle.kernels.objective_terms import ObjectiveKind
from warpmuscle.kernels.record import NOTHING, RecordKind
from warpmuscle.kernels.scratch import work_floats
from warpmuscle.kernels.step import step_kernel
from warpmuscle.simulation.kernel_cache import is_compiled

SLICES_PER_THREAD = 4  # so that threads stay busy when some slices lose their instances sooner
GPU_LANES = 8
MOST_LANES = 16  # that are of use to a biped
WARP = 32  # lanes that a multiprocessor runs together
BUSY_WARPS = 11  # of them keep a multiprocessor about as busy as more do
SHARED_BYTES = 48 * 1024  # of memory that a block may declare
GPU_BLOCK = 32
RESIDENT_BLOCKS = 12  # of GPU_BLOCK lanes that a multiprocessor has registers for, see `kernels.step.MAX_REGISTERS`
STREAMS = 4
WAVES = 24  # that the pieces of one launch make together at least, where instances do not fit at once

PLACE = re.compile(r'Error while parsing function "([^"]+)" at (.+?):(\d+):')  # as Warp says it

_making = Lock()  # Warp's own tables are not made for several threads
_loading: dict[tuple[Any, str], Lock] = {}  # of kernels on devices: different ones may be compiled at the same time
_loaded: set[tuple[Any, str]] = set()  # those that are there
_asked: set[tuple[Any, str]] = set()  # those that were looked for


class KernelConfig(NamedTuple):
    """What a fused kernel is made of; see `kernels.step.step_kernel`."""

    capacity: int
    lanes: int
    block_dim: int
    muscles: MuscleKind | None
    objective: ObjectiveKind
    collisions: bool
    motion: bool
    recorded: RecordKind
    controller: Controller = SIMBICON
    joints: tuple[MotionOf, ...] = ()

    @property
    def work_floats(self) -> int:
        """Numbers of the working set of an instance."""
        return int(work_floats(self.capacity, bool(self.joints)))


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
        raise RolloutError(f"{where}: {said}") from error


class Launcher:
    """The fused kernel of a recipe on a device, with the memory that its threads work in."""

    def __init__(self, recipe: KernelConfig, device: Any, threads: int) -> None:
        """Prepare to launch; raises RolloutError for functions of users that are no Warp code."""
        with one_line_errors(), _making:
            self.kernel = step_kernel(*recipe)
        self.recipe, self.device, self._threads = recipe, device, threads
        buffers = threads if device.is_cpu else 1
        self._loaded = False
        self._sliced: tuple[Integers | None, list[wp.array]] = (None, [])
        self._buffers = [wp.zeros(recipe.work_floats, dtype=float, device=device) for _ in range(buffers)]

    def load(self) -> None:
        """Have the kernel ready on the device, compiled now unless Warp has it in its cache.

        Raises:
            RolloutError: it does not compile, as may be with functions of users.
        """
        if not self._loaded:
            key = (self.recipe, str(self.device))
            with one_line_errors(), _loading.setdefault(key, Lock()):
                self.kernel.module.load(self.device, self.recipe.block_dim)
            self._loaded = True
            _loaded.add(key)

    @property
    def compiles(self) -> bool:
        """Whether the kernel is yet to be compiled, for some seconds, when it is run."""
        return not is_compiled(self.kernel, self.device, self.recipe.block_dim)

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

        def slice_(steps: int, part: wp.array, buffer: wp.array, stream: wp.Stream | None = None) -> None:
            wp.launch(
                self.kernel,
                dim=(len(part), self.recipe.lanes),
                inputs=[steps, part, model, state, record, wp.uint64(buffer.ptr), extension],
                device=self.device,
                stream=stream,
                block_dim=self.recipe.block_dim,
            )

        self.load()  # before threads, which must not meet in the compiler
        slices = self._slices_of(running)
        if len(slices) == 1:
            slice_(steps, slices[0], self._buffers[0])
        elif self.device.is_cpu:
            self._on_threads(lambda part, buffer: slice_(steps, part, buffer), slices)
        else:
            pieces = piece_lengths(steps, self._waves(len(running)))
            self._on_streams(lambda piece, part, stream: slice_(piece, part, self._buffers[0], stream), pieces, slices)

    def _on_threads(self, run: Callable[[wp.array, wp.array], None], slices: list[wp.array]) -> None:
        """Run every slice with a buffer of its own."""
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
        """Run pieces of so many steps of every slice, each slice on a stream of its own; later work waits for all."""
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
        resident = self.device.sm_count * RESIDENT_BLOCKS * (self.recipe.block_dim // self.recipe.lanes)
        return float(instances / resident)

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


def piece_lengths(steps: int, waves: float) -> list[int]:
    """Into how many steps each a launch is cut that keeps a GPU busy for so many waves."""
    pieces = min(math.ceil(WAVES / waves), steps)
    ends = [steps * k // pieces for k in range(pieces + 1)]
    return [after - before for before, after in pairwise(ends)]


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


def spread_recipe(recipe: KernelConfig, running: int, multiprocessors: int) -> KernelConfig | None:
    """What a kernel is made of with more lanes for so few instances that still run; None if theirs is as good.

    It is the one that replays use, since nothing is recorded where nothing is asked for.
    """
    lanes = usual_lanes(None, recipe.work_floats, running, multiprocessors)
    if lanes <= recipe.lanes or recipe.recorded not in (NOTHING, RecordKind()):
        return None
    return recipe._replace(lanes=lanes, recorded=RecordKind())


def soon_loaded(recipe: KernelConfig, device: Any) -> bool:
    """Whether a kernel is loaded; if it need not be compiled, that is begun now, in the background."""
    key = (recipe, str(device))
    if key not in _loaded and key not in _asked:
        _asked.add(key)
        Thread(target=_load_if_compiled, args=(recipe, device), name="kernel").start()
    return key in _loaded


def _load_if_compiled(recipe: KernelConfig, device: Any) -> None:
    """Load a kernel if Warp has it in its cache; whoever needs it says what is wrong with it."""
    with suppress(RolloutError):
        launcher = Launcher(recipe, device, threads=1)
        if not launcher.compiles:
            launcher.load()
