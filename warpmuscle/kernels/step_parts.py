"""The parts of a step, each several stages in order: place, drive, account, move, end.

They are all inlined: else structures that are given by reference have to lie in memory. What a kind of scene does not
have is None: Warp reads all functions that another names, even where a `wp.static` leaves their calls out.
"""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.body.hybrid import hybrid_integrate_stage
from warpmuscle.kernels.body.joint_stages import SkeletonKind, joint_stages_of
from warpmuscle.kernels.constraint.constraints import constraint_stage
from warpmuscle.kernels.contact.belts import mean_velocity
from warpmuscle.kernels.contact.collision import collision_stage_of
from warpmuscle.kernels.contact.gait_cycle import advance_cycles
from warpmuscle.kernels.contact.ground_plane import above_ground
from warpmuscle.kernels.contact.terrain import FLAT, above_terrain
from warpmuscle.kernels.contact.touching import begin_looking, touching_stage_of
from warpmuscle.kernels.control.control import NO_CONTROLLER, ControllerKind, asks_torques, control_stage_of
from warpmuscle.kernels.force.extensions import extension_list
from warpmuscle.kernels.force.forces import ForceKind, body_forces_stage_of, joint_forces_stage_of
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.muscle.muscle_kind import MuscleKind
from warpmuscle.kernels.muscle.muscle_stage import muscle_stage_of
from warpmuscle.kernels.objective.conditions import failing_stage_of
from warpmuscle.kernels.objective.failure import (
    begin_step_of,
    condition_status,
    posture_status_of,
    progress_status,
    remember_place,
    step_status,
)
from warpmuscle.kernels.objective.term_sums import (
    ObjectiveKind,
    desired_stage_of,
    effort_stage,
    muscle_functions,
    objective_stage_of,
)
from warpmuscle.kernels.objects.stage import objects_stage_of
from warpmuscle.kernels.recording.frame import frame_stage_of
from warpmuscle.kernels.recording.record import RecordKind, custom_recorder_of, record_given_way_of, recorders_of
from warpmuscle.kernels.structs import (
    LEFT,
    RIGHT,
    RUNNING,
    ModelRef,
    RecordRef,
    ScratchRef,
    StateRef,
    component,
    not_unrolled,
    set_component,
)
from warpmuscle.kernels.water.stage import water_stage_of

# The stages of a step, in order, as they are timed.
STAGES = (
    "kinematics", "failure", "controller", "muscles", "objective", "recording", "inertia and contact", "acceleration",
    "integration", "end",
)  # fmt: skip
KINEMATICS, FAILURE, CONTROLLER, MUSCLES, OBJECTIVE, RECORDING, INERTIA, ACCELERATION, INTEGRATION, END = range(10)
BEGIN = -1


class StepKind(NamedTuple):
    """What is compiled into a step."""

    muscles: MuscleKind | None = None  # of the muscles; None for characters that torques alone drive
    objective: ObjectiveKind = ObjectiveKind()  # the terms that are summed up
    collisions: bool = False  # whether bodies are tested for running into each other
    motion: bool = False  # whether the motion of some coordinates is prescribed
    recorded: RecordKind = RecordKind()
    controller: ControllerKind = NO_CONTROLLER  # what controls joints and muscles
    skeleton: SkeletonKind = SkeletonKind()  # of the bodies and joints that the model has
    forces: tuple[ForceKind, ...] = ()  # the kinds of others that act
    several_warps: bool = False  # whether lanes of an instance are in several warps, see `step.step_kernel`
    lanes_in_warp: int = 0  # of them in each warp, where a warp has some of all instances of its block; else 0

    @property
    def monomials(self) -> int:
        """Of the paths that are polynomials, at most."""
        return 0 if self.muscles is None else self.muscles.paths.monomials

    @property
    def long_paths(self) -> bool:
        """Whether muscles have long paths."""
        return self.muscles is not None and self.muscles.long_paths

    @property
    def paths_apart(self) -> bool:
        """Whether a kernel of their own finds muscles' paths before each step."""
        return self.muscles is not None and self.muscles.apart

    @property
    def extensions(self) -> Any:
        """Structure of the parameters and states of the controller and of all kinds of forces."""
        return extensions_of(self.controller, self.forces)


def extensions_of(controller: ControllerKind, forces: tuple[ForceKind, ...]) -> Any:
    """Structure of the parameters and states of a controller and of all kinds of forces."""
    return extension_list((controller.extension, *(force.extension for force in forces)))


@func
def no_mark(instance: int, lane: int, stage: int, buffer: wp.uint64):
    """What is done as a stage ends: nothing. `tools/stage_times.py` reads the clock there."""


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


@func
def foot_force_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """Total contact force on each foot and its children, a component a lane. No barrier."""
    for k in range(lane, 6, lanes):
        not_unrolled()
        side = wp.where(k < 3, LEFT, RIGHT)
        axis = k % 3
        total = wp.float32(0.0)
        for slot in range(model.foot_slots):
            not_unrolled()
            if model.skeleton.foot_side[slot] == side:
                total += component(work.contact_force, slot, axis)
        set_component(state.foot_force[instance], side, axis, total)


@cache
def place_of(kind: StepKind, mark: Any) -> Any:
    """The Warp function that places the bodies and says who fell, stands still or has run into himself: the status."""
    kinematics_stage = joint_stages_of(kind.skeleton, kind.several_warps).kinematics
    touching, progress, several = any(force.touch for force in kind.forces), kind.objective.progress, kind.several_warps
    collision_stage = collision_stage_of(kind.collisions)
    above = above_ground if kind.skeleton.terrain == FLAT else above_terrain
    moves = kind.skeleton.moves
    ground_velocity, look = mean_velocity if moves else None, begin_looking if touching else None
    status_by_progress, end_here = progress_status if progress else None, end_lane if several else None
    begin_step, posture_status = begin_step_of(above), posture_status_of(above)

    @wp.func(inline=True)
    def place(
        instance: int, lane: int, lanes: int, step: int, model: ModelRef, state: StateRef, work: ScratchRef
    ) -> int:
        kinematics_stage(instance, lane, lanes, model, state, work)
        if lane == 0:
            if wp.static(moves):
                ground = ground_velocity(instance, step, model)
                work.center[1] = work.center[1] - ground
                if wp.static(progress):
                    state.passed[instance] = state.passed[instance] + ground * model.time_step
            begin_step(instance, step, model, state, work)
            if wp.static(touching):
                look(step, model, work)
        synchronize()
        mark(instance, lane, KINEMATICS, wp.uint64(0))
        status = posture_status(instance, model, state, work)
        if status != RUNNING:
            if wp.static(several):
                end_here(instance, lane, status, state)
            return status
        if wp.static(progress):
            status = status_by_progress(instance, step, model, state, work)
            if status != RUNNING:
                if wp.static(several):
                    end_here(instance, lane, status, state)
                return status
        return collision_stage(instance, lane, lanes, step, model, work)

    return place


@cache
def drive_of(kind: StepKind, mark: Any) -> Any:
    """The Warp function of what drives the joints: the controller, muscles, and forces on joints."""
    controller, skeleton, objective = kind.controller, kind.skeleton, kind.objective
    asking = asks_torques(controller)
    control_stage, extensions_struct = control_stage_of(controller), kind.extensions
    by_coordinate = bool(controller.coordinates and skeleton.joints and controller.custom.effort is None)
    coordinate_control_stage = controller.coordinates if by_coordinate else None
    record_desired, _ = recorders_of(kind.recorded)
    desired_stage, seen = desired_stage_of(objective), bool(objective.desired)
    muscle_stage, muscular = None, kind.muscles is not None
    if kind.muscles is not None:
        functions = muscle_functions(objective, kind.muscles.special_curves, kind.muscles.curves)
        muscle_stage = muscle_stage_of(kind.muscles, functions, kind.recorded.muscles, controller, kind.lanes_in_warp)
    pulling = any(force.effort for force in kind.forces)
    joint_forces_stage = joint_forces_stage_of(kind.forces) if pulling else None

    @wp.func(inline=True)
    def drive(
        instance: int, lane: int, lanes: int, frame: int, model: ModelRef, state: StateRef, record: RecordRef,
        work: ScratchRef, extensions: wp.ref[extensions_struct],
    ):  # fmt: skip
        control_stage(instance, lane, lanes, model, state, work, extensions.first)
        if wp.static(by_coordinate):
            coordinate_control_stage(instance, lane, lanes, model, work)
        if wp.static(asking):
            effort_stage(instance, lane, lanes, model, state, work)
        record_desired(instance, lane, lanes, frame, model, state, record, work)
        if wp.static(seen):
            synchronize()  # the torques of all joints are there
            if lane == 0:
                desired_stage(instance, model, state, work)
            synchronize()
        mark(instance, lane, CONTROLLER, wp.uint64(0))
        if wp.static(muscular):
            muscle_stage(instance, lane, lanes, frame, model, state, record, work, extensions.first)
        if wp.static(pulling):
            joint_forces_stage(instance, lane, lanes, model, state, work, extensions.rest)
        mark(instance, lane, MUSCLES, wp.uint64(0))

    return drive


@cache
def account_of(kind: StepKind, mark: Any) -> Any:
    """The Warp function that adds to the terms' sums, sees which conditions fail, and writes a frame."""
    objective, whole = kind.objective, kind.recorded.complete
    objective_stage, progress = objective_stage_of(objective), objective.progress
    conditional = bool(objective.conditions)
    failing_stage = failing_stage_of(tuple(f for _, f in objective.conditions)) if conditional else None
    extensions_struct = kind.extensions
    frame_stage = frame_stage_of(kind.recorded, kind.controller, kind.forces, kind.skeleton.moves)

    @wp.func(inline=True)
    def account(
        instance: int, lane: int, lanes: int, step: int, frame: int, model: ModelRef, state: StateRef,
        record: RecordRef, work: ScratchRef, extensions: wp.ref[extensions_struct],
    ):  # fmt: skip
        objective_stage(instance, lane, lanes, model, state, work)
        if wp.static(progress) and lane == 0:  # all lanes have seen the place before
            remember_place(instance, step, model, state, work)
        if wp.static(conditional):
            synchronize()
            if lane == 0:
                failing_stage(instance, model, state, work)
        mark(instance, lane, OBJECTIVE, wp.uint64(0))
        if wp.static(whole):
            synchronize()  # a term may put other torques into the working set for a while
        frame_stage(instance, lane, lanes, step, frame, model, state, record, work, extensions)
        synchronize()
        mark(instance, lane, RECORDING, wp.uint64(0))

    return account


@cache
def outer_forces_of(forces: tuple[ForceKind, ...]) -> Any:
    """The Warp function that adds all other forces on bodies: those of springs and loads, touching, water, objects."""
    pushing = any(force.wrench or force.pair for force in forces)
    touching = any(force.touch for force in forces)
    under_water = any(force.water for force in forces)
    with_objects = any(force.objects for force in forces)
    body_forces_stage = body_forces_stage_of(forces) if pushing else None
    touching_stage = touching_stage_of(forces) if touching else None
    water_stage = water_stage_of(forces) if under_water else None
    objects_stage = objects_stage_of(forces) if with_objects else None
    extensions_struct = extension_list(tuple(force.extension for force in forces))

    @wp.func(inline=True)
    def outer_forces(
        instance: int, lane: int, lanes: int, step: int, model: ModelRef, state: StateRef, work: ScratchRef,
        extensions: wp.ref[extensions_struct],
    ):  # fmt: skip
        if wp.static(pushing):
            body_forces_stage(instance, lane, lanes, model, state, work, extensions)
        if wp.static(touching):
            touching_stage(instance, lane, lanes, step, model, work, extensions)
        if wp.static(under_water):
            water_stage(instance, lane, lanes, model, work, extensions)
        if wp.static(with_objects):
            objects_stage(instance, lane, lanes, model, state, work, extensions)

    return outer_forces


@cache
def move_of(kind: StepKind, mark: Any) -> Any:
    """The Warp function that moves the bodies: inertia and contact, forces on bodies, accelerations, integration."""
    of_joints, motion, whole = joint_stages_of(kind.skeleton, kind.several_warps), kind.motion, kind.recorded.complete
    inertia_stage = of_joints.inertia
    prescribe_stage = hybrid_acceleration_stage = integrate_by_motion = acceleration_stage = integrate_stage = None
    if motion:
        prescribe_stage, hybrid_acceleration_stage = of_joints.prescribe, of_joints.hybrid_acceleration
        integrate_by_motion = hybrid_integrate_stage
    else:
        acceleration_stage, integrate_stage = of_joints.acceleration, of_joints.integrate
    forces_stage = outer_forces_of(kind.forces)
    record_given_way = record_given_way_of(bool(kind.skeleton.joints)) if whole else None
    accelerated, seen, extensions_struct = kind.objective.accelerated, kind.recorded.accelerated, kind.extensions
    accelerated_stage = objective_stage_of(kind.objective, accelerated=True) if accelerated else None
    record_accelerated = custom_recorder_of(kind.recorded, True)
    constrained = kind.skeleton.constraints > 0
    constrain = constraint_stage if constrained else None

    @wp.func(inline=True)
    def move(
        instance: int, lane: int, lanes: int, step: int, frame: int, model: ModelRef, state: StateRef,
        record: RecordRef, work: ScratchRef, extensions: wp.ref[extensions_struct],
    ):  # fmt: skip
        if wp.static(constrained):
            constrain(instance, lane, lanes, model, state, work)
        if wp.static(motion):
            prescribe_stage(instance, lane, lanes, model, state, work)
        inertia_stage(instance, lane, lanes, model, state, work)
        forces_stage(instance, lane, lanes, step, model, state, work, extensions.rest)
        mark(instance, lane, INERTIA, wp.uint64(0))
        if wp.static(motion):
            hybrid_acceleration_stage(instance, lane, lanes, model, state, work)
        else:
            acceleration_stage(instance, lane, lanes, model, work)
        if wp.static(whole):
            record_given_way(instance, lane, lanes, frame, model, record, work)
        if wp.static(bool(accelerated)):
            accelerated_stage(instance, lane, lanes, model, state, work)
        if wp.static(seen) and lane == 0:
            record_accelerated(instance, frame, model, state, record, work)
        if wp.static(bool(accelerated) or seen):
            synchronize()  # before speeds and coordinates go on
        mark(instance, lane, ACCELERATION, wp.uint64(0))
        if wp.static(motion):
            integrate_by_motion(instance, lane, lanes, model, state, work)
        else:
            integrate_stage(instance, lane, lanes, model, state, work)
        mark(instance, lane, INTEGRATION, wp.uint64(0))

    return move


@cache
def end_of(kind: StepKind, mark: Any) -> Any:
    """The Warp function that ends a step and returns the status: what the controller and gait cycles go on from."""
    conditional, follows_cycles = bool(kind.objective.conditions), kind.objective.follows_cycles
    advance, advances = kind.controller.advance, kind.controller.advance is not None
    advance_feet = advance_cycles if follows_cycles else None

    @wp.func(inline=True)
    def end(instance: int, lane: int, lanes: int, step: int, model: ModelRef, state: StateRef, work: ScratchRef) -> int:
        status = step_status(model, work)
        if wp.static(conditional) and status == RUNNING:
            status = condition_status(work)
        if status == RUNNING:
            foot_force_stage(instance, lane, lanes, model, state, work)
        synchronize()
        if status == RUNNING and lane == 0:
            if wp.static(advances):
                advance(instance, model, state)
            if wp.static(follows_cycles):
                advance_feet(instance, step, model, state, work)
            state.step[instance] = step + 1
        synchronize()
        mark(instance, lane, END, wp.uint64(0))
        return status

    return end
