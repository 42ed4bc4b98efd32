"""The fused kernel: many steps of many instances in one launch, stages in order, nothing else."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.collision import collision_stage_of
from warpmuscle.kernels.compiler_hints import known_rows_of
from warpmuscle.kernels.conditions import failing_stage_of
from warpmuscle.kernels.control import SIMBICON, Controller, control_stage_of
from warpmuscle.kernels.coordinate_control import coordinate_control_stage
from warpmuscle.kernels.extensions import extension_list
from warpmuscle.kernels.failure import (
    begin_step,
    condition_status,
    posture_status,
    progress_status,
    remember_place,
    step_status,
)
from warpmuscle.kernels.forces import Force, body_forces_stage_of, joint_forces_stage_of
from warpmuscle.kernels.gait_cycle import advance_cycles
from warpmuscle.kernels.hybrid import hybrid_integrate_stage
from warpmuscle.kernels.joint_stages import SkeletonKind, joint_stages_of
from warpmuscle.kernels.muscle_stage import MuscleKind, muscle_stage_of
from warpmuscle.kernels.record import RecordKind, frame_of, own_recorder_of, record_given_way_of, recorders_of
from warpmuscle.kernels.scratch import (
    monomials_at,
    monomials_before_contacts,
    slots_of,
    synchronize,
    work_floats,
    work_memory,
)
from warpmuscle.kernels.structs import (
    LEFT,
    RIGHT,
    RUNNING,
    Model,
    ModelRef,
    Record,
    RecordRef,
    ScratchRef,
    State,
    StateRef,
    afresh,
    component,
    rolled,
    set_component,
    whole,
)
from warpmuscle.kernels.term_functions import (
    ObjectiveKind,
    desired_stage_of,
    effort_stage,
    muscle_functions,
    objective_stage_of,
)
from warpmuscle.kernels.touching import begin_looking, touching_stage_of

OTHERS = "actuation.effort", "muscles.knot_value"  # which others give with any strides
know_model = known_rows_of(Model, OTHERS, pairs=("muscles.curve_table",))

# The stages of a step, in order, as they are timed.
STAGES = (
    "kinematics", "failure", "controller", "muscles", "objective", "recording", "inertia and contact", "acceleration",
    "integration", "end",
)  # fmt: skip
KINEMATICS, FAILURE, CONTROLLER, MUSCLES, OBJECTIVE, RECORDING, INERTIA, ACCELERATION, INTEGRATION, END = range(10)
BEGIN = -1

MAX_REGISTERS = 168  # three warps of 32 lanes in each quarter of a multiprocessor
REGISTERS = 64 * 1024  # of a multiprocessor
SHARED_MEMORY, SHARED_BY_SYSTEM = 228 * 1024, 1024  # bytes of a multiprocessor, and what it takes of them for a block
SHARED_BESIDE_CACHE = 196 * 1024  # that leave the first cache room for moment arms, where working sets have none
LEAST_REGISTERS = 96  # with fewer, long paths keep more on the stack than more blocks make up for ...
LEAST_OF_WRAPS = 168  # ... and paths around surfaces
WARP = 32  # threads that run together
FEWER_REGISTERS = 128  # four warps; of long paths without surfaces, which wait for memory more than they compute


@wp.func
def foot_force_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """Total contact force on each foot and its children, a component a lane. No barrier."""
    for k in range(lane, 6, lanes):
        rolled()
        side = wp.where(k < 3, LEFT, RIGHT)
        axis = k % 3
        total = wp.float32(0.0)
        for slot in range(model.foot_slots):
            rolled()
            if model.skeleton.foot_side[slot] == side:
                total += component(work.contact_force, slot, axis)
        set_component(state.foot_force[instance], side, axis, total)


def extensions_of(controller: Controller, forces: tuple[Force, ...]) -> Any:
    """Structure of the parameters and states of a controller and of all kinds of forces."""
    return extension_list((controller.extension, *(force.extension for force in forces)))


@wp.func
def no_lap(instance: int, lane: int, stage: int, buffer: wp.uint64):
    """What is done as a stage ends: nothing. `tools/stage_times.py` reads the clock there."""


@cache
def one_step_of(
    muscles: MuscleKind | None,
    objective: ObjectiveKind,
    collisions: bool,
    motion: bool = False,
    recorded: RecordKind = RecordKind(),  # noqa: B008, immutable
    controller: Controller = SIMBICON,
    skeleton: SkeletonKind = SkeletonKind(),  # noqa: B008, immutable
    forces: tuple[Force, ...] = (),
    lap: Any = no_lap,
    across: bool = False,
    together: int = 0,
) -> Any:
    """The Warp function that makes one step of one instance and returns its status, the same on all lanes.

    Args:
        muscles: kind of the muscles, None for characters that torques alone drive.
        objective: the terms that are summed up.
        collisions: whether bodies are tested for running into each other.
        motion: whether the motion of some coordinates is prescribed.
        recorded: what is recorded.
        controller: what controls joints and muscles. forces: the kinds of others that act.
        skeleton: of the bodies and joints that the model has.
        lap: called as each of `STAGES` ends, by its number.
        across: whether lanes of an instance are in several warps, see `step_kernel`.
        together: of them in each warp, where a warp has some of all instances of its block; else 0.
    """
    record_desired, record_stage = recorders_of(recorded)
    record_given_way = record_given_way_of(bool(skeleton.joints))
    record_own, record_accelerated = (own_recorder_of(recorded, accelerated) for accelerated in (False, True))
    control_stage, advance = control_stage_of(controller), controller.advance
    muscle_stage, muscular = control_stage, muscles is not None
    by_coordinate = bool(skeleton.joints) and controller.custom.effort is None
    of_joints = joint_stages_of(skeleton, across)
    kinematics_stage, inertia_stage, integrate_stage = of_joints.kinematics, of_joints.inertia, of_joints.integrate
    acceleration_stage, hybrid_acceleration_stage = of_joints.acceleration, of_joints.hybrid_acceleration
    prescribe_stage = of_joints.prescribe
    pulling = any(force.effort for force in forces)
    pushing = any(force.wrench or force.pair for force in forces)
    touching = any(force.touch for force in forces)
    joint_forces_stage, body_forces_stage = joint_forces_stage_of(forces), body_forces_stage_of(forces)
    touching_stage = touching_stage_of(forces) if touching else body_forces_stage
    extensions_struct = extensions_of(controller, forces)
    if muscles is not None:
        functions = muscle_functions(objective, muscles.own)
        muscle_stage = muscle_stage_of(muscles, functions, recorded.muscles, controller, together)
    objective_stage, desired_stage = objective_stage_of(objective), desired_stage_of(objective)
    accelerated_stage = objective_stage_of(objective, accelerated=True)
    failing_stage, conditional = failing_stage_of(tuple(f for _, f in objective.conditions)), bool(objective.conditions)
    collision_stage = collision_stage_of(collisions)

    @wp.func(inline=True)  # else structures that are given by reference have to lie in memory
    def one_step(
        instance: int,
        lane: int,
        lanes: int,
        model: ModelRef,
        state: StateRef,
        record: RecordRef,
        work: ScratchRef,
        extensions: wp.ref[extensions_struct],
    ) -> int:
        step = state.step[instance]
        frame = -1
        if wp.static(recorded.motion):
            frame = frame_of(instance, step, record)
        kinematics_stage(instance, lane, lanes, model, state, work)
        if lane == 0:
            begin_step(instance, step, model, state, work)
            if wp.static(touching):
                begin_looking(step, model, work)
        synchronize()
        lap(instance, lane, KINEMATICS, wp.uint64(0))
        status = posture_status(instance, model, state, work)
        if status != RUNNING:
            if wp.static(across):
                end_lane(instance, lane, status, state)
            return status
        if wp.static(objective.progress):
            status = progress_status(instance, step, model, state, work)
            if status != RUNNING:
                if wp.static(across):
                    end_lane(instance, lane, status, state)
                return status
        status = collision_stage(instance, lane, lanes, step, model, work)
        if status != RUNNING:
            return status
        lap(instance, lane, FAILURE, wp.uint64(0))
        control_stage(instance, lane, lanes, model, state, work, extensions.first)
        if wp.static(by_coordinate):
            coordinate_control_stage(instance, lane, lanes, model, work)
        effort_stage(instance, lane, lanes, model, state, work)
        record_desired(instance, lane, lanes, frame, model, state, record, work)
        if wp.static(bool(objective.desired)):
            synchronize()  # the torques of all joints are there
            if lane == 0:
                desired_stage(instance, model, state, work)
            synchronize()
        lap(instance, lane, CONTROLLER, wp.uint64(0))
        if wp.static(muscular):
            muscle_stage(instance, lane, lanes, frame, model, state, record, work, extensions.first)
        if wp.static(pulling):
            joint_forces_stage(instance, lane, lanes, model, state, work, extensions.rest)
        lap(instance, lane, MUSCLES, wp.uint64(0))
        objective_stage(instance, lane, lanes, model, state, work)
        if wp.static(objective.progress) and lane == 0:  # all lanes have seen the place before
            remember_place(instance, step, model, state, work)
        if wp.static(conditional):
            synchronize()
            if lane == 0:
                failing_stage(instance, model, state, work)
        lap(instance, lane, OBJECTIVE, wp.uint64(0))
        if wp.static(recorded.whole):
            synchronize()  # a term may put other torques into the working set for a while
        record_stage(instance, lane, lanes, frame, model, state, record, work)
        if wp.static(bool(recorded.own)) and lane == 0:
            record_own(instance, frame, model, state, record, work)
        synchronize()
        lap(instance, lane, RECORDING, wp.uint64(0))
        if wp.static(motion):
            prescribe_stage(instance, lane, lanes, model, state, work)
        inertia_stage(instance, lane, lanes, model, state, work)
        if wp.static(pushing):
            body_forces_stage(instance, lane, lanes, model, state, work, extensions.rest)
        if wp.static(touching):
            touching_stage(instance, lane, lanes, step, model, work, extensions.rest)
        lap(instance, lane, INERTIA, wp.uint64(0))
        if wp.static(motion):
            hybrid_acceleration_stage(instance, lane, lanes, model, state, work)
        else:
            acceleration_stage(instance, lane, lanes, model, work)
        if wp.static(recorded.whole):
            record_given_way(instance, lane, lanes, frame, model, record, work)
        if wp.static(bool(objective.accelerated)):
            accelerated_stage(instance, lane, lanes, model, state, work)
        if wp.static(recorded.accelerated) and lane == 0:
            record_accelerated(instance, frame, model, state, record, work)
        if wp.static(bool(objective.accelerated) or recorded.accelerated):
            synchronize()  # before speeds and coordinates go on
        lap(instance, lane, ACCELERATION, wp.uint64(0))
        if wp.static(motion):
            hybrid_integrate_stage(instance, lane, lanes, model, state, work)
        else:
            integrate_stage(instance, lane, lanes, model, state, work)
        lap(instance, lane, INTEGRATION, wp.uint64(0))
        status = step_status(model, work)
        if wp.static(conditional) and status == RUNNING:
            status = condition_status(work)
        if status == RUNNING:
            foot_force_stage(instance, lane, lanes, model, state, work)
        synchronize()
        if status == RUNNING and lane == 0:
            advance(instance, model, state)
            if wp.static(objective.follows_cycles):
                advance_cycles(instance, step, model, state, work)
            state.step[instance] = step + 1
        synchronize()
        lap(instance, lane, END, wp.uint64(0))
        return status

    return one_step


@wp.func_native(
    snippet="""
if (lane == 0)
    *wp::address(state.status, instance) = status;
#if defined(__CUDA_ARCH__)
asm volatile("exit;");
#endif
"""
)
def end_lane(instance: int, lane: int, status: int, state: StateRef):
    """Let an instance rest, and its lane be no more, for which those of other instances need not wait."""


def module_options(block_dim: int) -> dict[str, Any]:
    """How the kernel is compiled: loops stay loops; on the CPU all in one function, with fused products."""
    flags = (
        "-march=native -ffp-contract=fast -mllvm=-inline-threshold=100000 -mllvm=-inline-cold-callsite-threshold=100000"
    )
    # On a GPU, division and square root to 2 units in the last place: see tools/gpu_agreement.py for what that does.
    return {"block_dim": block_dim, "max_unroll": 1, "fast_math": True, "cpu_compiler_flags": flags}


def registers_of(muscles: MuscleKind | None) -> int:
    """Registers that a lane may have at most, where muscles are of a kind."""
    if muscles is None or muscles.paths.routes is None or muscles.paths.wraps:
        return MAX_REGISTERS
    return FEWER_REGISTERS


def blocks_of(threads: int, floats: int, muscles: MuscleKind | None = None) -> int:
    """Blocks of so many threads that a multiprocessor has shared memory and registers for; see `block_registers`.

    Args:
        floats: numbers of the working sets of a block. muscles: their kind.
    """
    block = 4 * floats + SHARED_BY_SYSTEM + 4 * threads
    wraps, at_hand = muscles is not None and muscles.paths.wraps, muscles is None or muscles.pulls_at_hand
    memory = SHARED_MEMORY if at_hand or block > SHARED_BESIDE_CACHE else SHARED_BESIDE_CACHE
    return int(min(memory // block, REGISTERS // ((LEAST_OF_WRAPS if wraps else LEAST_REGISTERS) * threads)))


def block_registers(threads: int, floats: int, muscles: MuscleKind | None = None) -> int:
    """Registers of a lane with which as many blocks fit a multiprocessor as `blocks_of` says."""
    return int(min(REGISTERS // (blocks_of(threads, floats, muscles) * threads) // 8 * 8, 255))


@cache
def step_kernel(
    capacity: int,
    lanes: int,
    block_dim: int,
    muscles: MuscleKind | None = None,
    objective: ObjectiveKind = ObjectiveKind(),  # noqa: B008, immutable
    collisions: bool = False,
    motion: bool = False,
    recorded: RecordKind = RecordKind(),  # noqa: B008, immutable
    controller: Controller = SIMBICON,
    skeleton: SkeletonKind = SkeletonKind(),  # noqa: B008, immutable
    forces: tuple[Force, ...] = (),
    slots: int | None = None,
    lap: Any = no_lap,
) -> Any:
    """The fused kernel of a size class: launch with dim=(running instances, lanes) and this block_dim.

    Args:
        capacity: bodies that it has room for, see `scratch.capacity_of`.
        lanes: threads that share an instance; 1 on the CPU.
        block_dim: threads a block, a multiple of lanes; of more than a warp: the state's numbers of neighbouring
            instances lie side by side, see `core.arrays.instance_zeros`.
        muscles, objective, collisions, motion, recorded, controller, skeleton, forces, lap: see `one_step_of`.
        slots: of feet that it has room for, see `scratch.slots_for`; None for those of the size class.
    """
    across = block_dim > WARP
    instances_per_block = max(block_dim // lanes, 1)
    one_step = one_step_of(
        muscles, objective, collisions, motion, recorded, controller, skeleton, forces, lap, across,
        together=WARP // instances_per_block if across else 0,
    )  # fmt: skip
    extensions_struct = extensions_of(controller, forces)
    touching = any(force.touch for force in forces)
    monomials = 0 if muscles is None else muscles.paths.monomials
    floats = work_floats(capacity, bool(skeleton.joints), monomials, slots, skeleton.followed)
    roomy, slots = slots is not None, slots_of(capacity) if slots is None else slots
    memory, block_floats = work_memory(floats, instances_per_block, across), instances_per_block * floats
    work_at = joint_stages_of(skeleton).work_at
    know_state = known_rows_of(State, side_by_side=across)
    crowded = muscles is not None and muscles.long_paths  # else the compiler does well to compute places ahead

    @wp.kernel(
        module="unique",
        enable_backward=False,
        cuda_max_registers=block_registers(block_dim, block_floats, muscles) if across else registers_of(muscles),
        module_options=module_options(block_dim),
        grid_stride=False if across else None,
    )
    def step_many(
        # in
        steps: int, running: wp.array[int], model: Model,
        # in and out
        state: State, record: Record, buffer: wp.uint64, extensions: extensions_struct,
    ):  # fmt: skip
        i, number = wp.tid()
        if wp.static(across):  # neighbours in a warp are the same lane of several instances
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
        lane = whole(number)
        instance = whole(running[i])
        room = memory(i % instances_per_block, buffer)
        work = work_at(room, capacity, slots)
        if wp.static(monomials > 0 and roomy):
            work.monomial = monomials_before_contacts(room, capacity, slots, monomials)
        elif wp.static(monomials > 0):
            work.monomial = monomials_at(room, monomials)
        if wp.static(touching) and lane == 0:
            work.near[0] = 1  # as long as it is not known
        status = int(RUNNING)
        lap(instance, lane, BEGIN, buffer)
        for _ in range(steps):
            if wp.static(crowded):
                instance = whole(afresh(instance))
            status = one_step(instance, lane, lanes, character, changing, record, work, own)
            if status != RUNNING:
                break
        if lane == 0 and status != RUNNING:
            state.status[instance] = status

    return step_many
