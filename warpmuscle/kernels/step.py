"""The fused kernel: many steps of many instances in one launch, stages in order, nothing else."""

from functools import cache, partial
from typing import Any

import warp as wp

from warpmuscle.kernels.body.joint_stages import joint_stages_of
from warpmuscle.kernels.functions import CPU_FLAGS, build_options
from warpmuscle.kernels.known_kernels import Postponed, known_kernel
from warpmuscle.kernels.memory.compiler_hints import known_rows_of
from warpmuscle.kernels.memory.main_memory import main_memory_of
from warpmuscle.kernels.memory.scratch import (
    NEAR,
    monomials_at,
    monomials_before_contacts,
    slots_of,
    work_floats,
    work_memory,
)
from warpmuscle.kernels.muscle.muscle_kind import MuscleKind
from warpmuscle.kernels.path_kernels import know_model, places_for_paths_of
from warpmuscle.kernels.recording.record import frame_of
from warpmuscle.kernels.step_parts import BEGIN as BEGIN
from warpmuscle.kernels.step_parts import FAILURE, StepKind, account_of, drive_of, end_of, move_of, no_mark, place_of
from warpmuscle.kernels.step_parts import STAGES as STAGES
from warpmuscle.kernels.step_parts import extensions_of as extensions_of
from warpmuscle.kernels.structs import (
    RUNNING,
    Model,
    ModelRef,
    Record,
    RecordRef,
    ScratchRef,
    State,
    StateRef,
    nonnegative,
    recomputed,
)

MAX_REGISTERS = 168  # three warps of 32 lanes in each quarter of a multiprocessor
REGISTERS = 64 * 1024  # of a multiprocessor
SHARED_MEMORY, SHARED_BY_SYSTEM = 228 * 1024, 1024  # bytes of a multiprocessor, and what it takes of them for a block
SHARED_BESIDE_CACHE = 196 * 1024  # that leave the first cache room for moment arms, where working sets have none
LEAST_REGISTERS = 96  # with fewer, long paths keep more on the stack than more blocks make up for ...
LEAST_OF_WRAPS = 168  # ... and paths around surfaces, unless a block has more threads than that leaves room for
WARP = 32  # threads that run together
FEWER_REGISTERS = 128  # four warps; of long paths without surfaces, which wait for memory more than they compute


@cache
def one_step_of(kind: StepKind, mark: Any = no_mark) -> Any:
    """The Warp function that makes one step of one instance and returns its status, the same on all lanes.

    Args:
        mark: called as each of `STAGES` ends, by its number.
    """
    place, drive, account = place_of(kind, mark), drive_of(kind, mark), account_of(kind, mark)
    move, end = move_of(kind, mark), end_of(kind, mark)
    framed, extensions_struct = kind.recorded.motion, kind.extensions

    @wp.func(inline=True)
    def one_step(
        instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, record: RecordRef, work: ScratchRef,
        extensions: wp.ref[extensions_struct],
    ) -> int:  # fmt: skip
        step = state.step[instance]
        frame = -1
        if wp.static(framed):
            frame = frame_of(instance, step, record)
        status = place(instance, lane, lanes, step, model, state, work)
        if status != RUNNING:
            return status
        mark(instance, lane, FAILURE, wp.uint64(0))
        drive(instance, lane, lanes, frame, model, state, record, work, extensions)
        account(instance, lane, lanes, step, frame, model, state, record, work, extensions)
        move(instance, lane, lanes, step, frame, model, state, record, work, extensions)
        return end(instance, lane, lanes, step, model, state, work)

    return one_step


def module_options(block_dim: int) -> dict[str, Any]:
    """How the kernel is compiled: loops stay loops; on the CPU all in one function, with fused products."""
    # On a GPU, division and square root to 2 units in the last place: see tools/gpu_agreement.py for what that does.
    loops = {"enable_backward": False, "max_unroll": 1, **build_options()}
    return {**loops, "block_dim": block_dim, "fast_math": True, "cpu_compiler_flags": CPU_FLAGS}


def registers_of(muscles: MuscleKind | None) -> int:
    """Registers that a lane may have at most, where muscles are of a kind."""
    if muscles is None or muscles.paths.routes is None or muscles.wraps:
        return MAX_REGISTERS
    return FEWER_REGISTERS


def blocks_of(threads: int, floats: int, muscles: MuscleKind | None = None) -> int:
    """Blocks of so many threads that a multiprocessor has shared memory and registers for; see `block_registers`.

    Args:
        floats: numbers of the working sets of a block. muscles: their kind.
    """
    block = 4 * floats + SHARED_BY_SYSTEM + 4 * threads
    wraps, in_scratch = muscles is not None and muscles.wraps, muscles is None or muscles.pulls_in_scratch
    memory = SHARED_MEMORY if in_scratch or block > SHARED_BESIDE_CACHE else SHARED_BESIDE_CACHE
    least = min(LEAST_OF_WRAPS, REGISTERS // threads) if wraps else LEAST_REGISTERS
    return int(min(memory // block, REGISTERS // (least * threads)))


def block_registers(threads: int, floats: int, muscles: MuscleKind | None = None) -> int:
    """Registers of a lane with which as many blocks fit a multiprocessor as `blocks_of` says."""
    return int(min(REGISTERS // (blocks_of(threads, floats, muscles) * threads) // 8 * 8, 255))


def monomial_views(monomials: int, own_slots: bool) -> tuple[Any, Any]:
    """The Warp functions of where monomials are, before contacts and behind all else; None for where they are not."""
    return (
        monomials_before_contacts if monomials > 0 and own_slots else None,
        monomials_at if monomials > 0 and not own_slots else None,
    )


def step_of(kind: StepKind, mark: Any, places: bool) -> Any:
    """The Warp function of a step, or of the places that paths need to know, see `step_kernel`."""
    step = places_for_paths_of(kind) if places else one_step_of(kind, mark)
    return if_running_of(step, kind.extensions) if kind.paths_apart else step


@cache
def if_running_of(step: Any, extensions_struct: Any) -> Any:
    """The Warp function of a step of an instance that may have ended in an earlier launch."""

    @wp.func(inline=True)
    def if_running(
        instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, record: RecordRef, work: ScratchRef,
        extensions: wp.ref[extensions_struct],
    ) -> int:  # fmt: skip
        status = state.status[instance]
        if status != RUNNING:
            return status
        return step(instance, lane, lanes, model, state, record, work, extensions)

    return if_running


@cache
def step_kernel(
    capacity: int,
    lanes: int,
    block_dim: int,
    kind: StepKind = StepKind(),  # noqa: B008, immutable
    slots: int | None = None,
    mark: Any = no_mark,
    places: bool = False,
) -> Any:
    """The fused kernel of a size class: launch with dim=(running instances, lanes) and this block_dim.

    Args:
        capacity: bodies that it has room for, see `scratch.capacity_of`.
        lanes: threads that share an instance; 1 on the CPU.
        block_dim: threads a block, a multiple of lanes; of more than a warp: the state's numbers of neighbouring
            instances lie side by side, see `core.arrays.instance_zeros`.
        kind: what is compiled in; how lanes lie in warps is found here.
        slots: of feet that it has room for, see `scratch.slots_for`; None for those of the size class.
        mark: see `one_step_of`. places: whether it leaves what paths need to know, in place of steps.
    """
    several, instances_per_block = block_dim > WARP, max(block_dim // lanes, 1)
    kind = kind._replace(several_warps=several, lanes_in_warp=WARP // instances_per_block if several else 0)
    muscles, skeleton, monomials, long_paths = kind.muscles, kind.skeleton, kind.monomials, kind.long_paths
    one_step, extensions_struct = Postponed("one_step", partial(step_of, kind, mark, places)), kind.extensions
    touching = any(force.touch for force in kind.forces)
    floats = work_floats(
        capacity, skeleton.with_coordinates, monomials, slots, skeleton.open, skeleton.constraints,
        skeleton.near_entries, skeleton.main,
    )  # fmt: skip
    own_slots, slots = slots is not None, slots_of(capacity) if slots is None else slots
    memory, block_floats = work_memory(floats, instances_per_block, several), instances_per_block * floats
    monomials_apart, monomials_behind = monomial_views(monomials, own_slots)
    before, behind = monomials_apart is not None, monomials_behind is not None
    keep_apart = main_memory_of(skeleton.apart(capacity, slots), 0 if several else floats)
    work_at, know_state = joint_stages_of(skeleton).work_at, known_rows_of(State, side_by_side=several)
    computed_anew = recomputed if long_paths else None  # else the compiler does well to compute places ahead

    @known_kernel(
        capacity, lanes, block_dim, kind, slots, mark, places,
        enable_backward=False,
        cuda_max_registers=block_registers(block_dim, block_floats, muscles) if several else registers_of(muscles),
        module_options=module_options(block_dim),
        grid_stride=False if several else None,
    )  # fmt: skip
    def step_many(
        # in
        steps: int, running: wp.array[int], model: Model,
        # in and out
        state: State, record: Record, buffer: wp.uint64, extensions: extensions_struct,
    ):  # fmt: skip
        i, number = wp.tid()
        if wp.static(several):  # neighbours in a warp are the same lane of several instances
            thread = i * lanes + number
            i = thread // block_dim * instances_per_block + thread % instances_per_block
            number = thread % block_dim // instances_per_block
            wp.tile_zeros(shape=wp.static(block_floats), dtype=float, storage="shared")  # so that there is the memory
            if i >= running.shape[0]:
                return
        character = model
        changing = state
        own = extensions
        know_model(character)
        know_state(changing)
        lane = nonnegative(number)
        instance = nonnegative(running[i])
        room = memory(i % instances_per_block, buffer)
        work = work_at(room, capacity, slots)
        if wp.static(before):
            work.monomial = monomials_apart(room, capacity, slots, monomials)
        elif wp.static(behind):
            work.monomial = monomials_behind(room, monomials)
        if wp.static(touching) and lane == 0:
            work.near[0] = 1  # as long as it is not known
        if wp.static(skeleton.main > NEAR):
            keep_apart(work, buffer, instance)
        status = int(RUNNING)
        mark(instance, lane, BEGIN, buffer)
        for _ in range(steps):
            if wp.static(long_paths):
                instance = nonnegative(computed_anew(instance))
            status = one_step(instance, lane, lanes, character, changing, record, work, own)
            if status != RUNNING:
                break
        if lane == 0 and status != RUNNING:
            state.status[instance] = status

    return step_many
