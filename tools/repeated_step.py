"""A step like the fused one whose stages can be repeated or left out, so that differences of time are theirs."""

from __future__ import annotations

import time
from functools import cache
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.kernels.actuation import actuation_stage_of, muscle_torque, pulled_torque
from warpmuscle.kernels.collision import collision_stage_of
from warpmuscle.kernels.contact import contact_stage
from warpmuscle.kernels.dynamics import (
    accelerate_body,
    accelerate_root,
    backward_pass_of,
    body_inertia,
    forward_pass_of,
    push_now,
    reduce_body,
)
from warpmuscle.kernels.extensions import NoExtensions
from warpmuscle.kernels.failure import begin_step, posture_status
from warpmuscle.kernels.gait_cycle import advance_cycles
from warpmuscle.kernels.integration import integrate_stage
from warpmuscle.kernels.kinematics import kinematics_stage
from warpmuscle.kernels.limits import limit_stage
from warpmuscle.kernels.muscle_stage import MuscleKind, arms_at_hand, arms_in_state, muscle_stage_of
from warpmuscle.kernels.objective_terms import ObjectiveKind, effort_stage, muscle_functions, objective_stage_of
from warpmuscle.kernels.path import joint_velocities, stretch_of
from warpmuscle.kernels.scratch import capacity_of, slots_of, synchronize, work_at, work_memory
from warpmuscle.kernels.simbicon import advance_phase, targets_stage, torques_stage
from warpmuscle.kernels.spatial import symmetric
from warpmuscle.kernels.springs import SPRINGS
from warpmuscle.kernels.step import MAX_REGISTERS, foot_force_stage, know_model, know_state, module_options
from warpmuscle.kernels.structs import MIXED, RUNNING, Model, ModelRef, Record, State, StateRef, WorkRef
from warpmuscle.model.collisions import collision_pairs
from warpmuscle.model.muscles import compiled_kind, driven
from warpmuscle.model.objective import objective_kind
from warpmuscle.simulation.rollout import Rollout

REPEATED = 3  # extra runs of a stage
KINEMATICS, FAILURE, TARGETS, TORQUES, PATHS, ACTUATION, OBJECTIVE, DYNAMICS, INTEGRATION = range(9)
PARTS, NO_MUSCLES, NO_LIMITS = 9, 10, 11  # parts of the dynamics that are repeated; what is left out
SWITCHES = 12
RESTORE, INERTIA, CONTACT, BACKWARD, FORWARD = range(5)  # parts of the dynamics, each with those before
Switches = dict[int, int]


@wp.struct
class Kept:
    """What the dynamics read and then use the memory of; arrays are (instances, bodies)."""

    torque: wp.array2d[wp.vec3]
    stiffness: wp.array2d[symmetric]
    velocity: wp.array2d[wp.vec3]
    lag_angular: wp.array2d[wp.vec3]
    lag_velocity: wp.array2d[wp.vec3]


@wp.func
def keep(instance: int, lane: int, lanes: int, model: ModelRef, work: WorkRef, kept: Kept):
    """Put it by."""
    for i in range(lane, model.body_count, lanes):
        kept.torque[instance, i] = work.torque[i]
        kept.stiffness[instance, i] = work.stiffness[i]
        kept.velocity[instance, i] = work.velocity[i]
        kept.lag_angular[instance, i] = work.lag_angular[i]
        kept.lag_velocity[instance, i] = work.lag_velocity[i]
    synchronize()


@wp.func
def restore(instance: int, lane: int, lanes: int, model: ModelRef, work: WorkRef, kept: Kept):
    """Take it back."""
    for i in range(lane, model.body_count, lanes):
        work.torque[i] = kept.torque[instance, i]
        work.stiffness[i] = kept.stiffness[instance, i]
        work.velocity[i] = kept.velocity[instance, i]
        work.lag_angular[i] = kept.lag_angular[instance, i]
        work.lag_velocity[i] = kept.lag_velocity[instance, i]
    synchronize()


backward_pass, forward_pass = backward_pass_of(reduce_body), forward_pass_of(accelerate_body)


@wp.func
def dynamics_parts(
    instance: int, lane: int, lanes: int, parts: int, limits: bool, model: ModelRef, state: StateRef, work: WorkRef
):
    """`inertia_stage` and `acceleration_stage` up to one of their parts, with or without the joint limits."""
    if parts < INERTIA:
        return
    if lane == 0:
        work.flags[0] = 0
    synchronize()
    for i in range(lane, model.body_count, lanes):
        body_inertia(instance, i, model, work)
        if i == 0:
            work.bias_force[0] = work.bias_force[0] - push_now(instance, state)
        if limits and model.skeleton.plan[i].has_limits == 1:
            limit_stage(instance, i, model, state, work)
        if parts >= CONTACT:
            contact_stage(instance, i, model, work)
    synchronize()
    if parts >= BACKWARD:
        backward_pass(instance, lane, lanes, model, work)
    if parts >= FORWARD:
        if lane == 0:
            accelerate_root(model.skeleton.plan[0].joint_type, model.skeleton, work)
        synchronize()
        forward_pass(instance, lane, lanes, model, work)


def all_paths(muscles: MuscleKind) -> Any:
    """A Warp function for lengths and moment arms of all muscles."""
    arms = arms_at_hand if muscles.pulls_at_hand else arms_in_state
    muscle_stretch = stretch_of(muscles.pulleys, muscles.conditions, muscles.straight)

    @wp.func
    def paths(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: WorkRef):
        joint_velocities(lane, lanes, model, work)
        for m in range(lane, model.muscles.count, lanes):
            muscle_stretch(instance, m, model, state, work, arms(instance, state, work))
        synchronize()

    return paths


@wp.func
def no_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: WorkRef):
    """Of a character without muscles."""


@cache
def repeated_step_kernel(
    capacity: int, lanes: int, block_dim: int, muscles: MuscleKind | None, objective: ObjectiveKind, collisions: bool
) -> Any:
    """The kernel of many steps. Stage k runs 1 + extra[k] times, PATHS and ACTUATION extra[k] times more.

    `spare` is a state of which only coordinates, speeds and accelerations are its own: repetitions of the integration
    work on it, so that they do not change the motion.
    """
    per_block, slots = max(block_dim // lanes, 1), slots_of(capacity)
    memory = work_memory(capacity, per_block)
    muscle_stage, paths, actuation_stage = no_stage, no_stage, no_stage
    muscular = muscles is not None
    if muscles is not None:
        muscle_stage = muscle_stage_of(muscles, muscle_functions(objective))
        paths = all_paths(muscles)
        actuation_stage = actuation_stage_of(
            pulled_torque if muscles.pulls_at_hand else muscle_torque, SPRINGS, muscles.mixed
        )
    objective_stage, collision_stage = objective_stage_of(objective), collision_stage_of(collisions)

    @wp.kernel(
        module="unique",
        enable_backward=False,
        cuda_max_registers=MAX_REGISTERS,
        module_options=module_options(block_dim),
    )
    def repeated_step(
        steps: int, model_given: Model, state_given: State, spare: State, record: Record, buffer: wp.uint64,
        extra: wp.array[int], kept: Kept,
    ):  # fmt: skip
        i, lane = wp.tid()
        model = model_given
        state = state_given
        know_model(model)
        know_state(state)
        work = work_at(memory(i % per_block, buffer), capacity, slots)
        for _ in range(steps):
            step = state.step[i]
            for _k in range(1 + extra[KINEMATICS]):
                kinematics_stage(i, lane, lanes, model, state, work)
            if lane == 0:
                begin_step(i, step, model, state, work)
            synchronize()
            status = int(RUNNING)
            for _k in range(1 + extra[FAILURE]):
                status = posture_status(i, model, state, work)
                if status == RUNNING:
                    status = collision_stage(i, lane, lanes, step, model, work)
                synchronize()
            if lane == 0 and status != RUNNING:
                state.status[i] = status
            for _k in range(1 + extra[TARGETS]):
                targets_stage(i, lane, lanes, model, state, work)
            for _k in range(1 + extra[TORQUES]):
                torques_stage(i, lane, lanes, model, state, work)
            effort_stage(i, lane, lanes, model, state, work)
            if wp.static(muscular) and extra[NO_MUSCLES] == 0:
                muscle_stage(i, lane, lanes, -1, model, state, record, work, NoExtensions())
            for _k in range(extra[PATHS]):
                paths(i, lane, lanes, model, state, work)
            for _k in range(extra[ACTUATION]):
                actuation_stage(i, lane, lanes, model, state, work)
            objective_stage(i, lane, lanes, model, state, work)
            for _k in range(extra[OBJECTIVE]):
                effort_stage(i, lane, lanes, model, state, work)
                objective_stage(i, lane, lanes, model, state, work)
                synchronize()
            synchronize()
            if extra[DYNAMICS] > 0:
                keep(i, lane, lanes, model, work, kept)
            for k in range(1 + extra[DYNAMICS]):
                if k > 0:
                    restore(i, lane, lanes, model, work, kept)
                last = k == extra[DYNAMICS]
                limits = last and extra[NO_LIMITS] == 0
                dynamics_parts(i, lane, lanes, wp.where(last, FORWARD, extra[PARTS]), limits, model, state, work)
            for _k in range(extra[INTEGRATION]):
                integrate_stage(i, lane, lanes, model, spare, work)
            if extra[INTEGRATION] > 0 and lane == 0:
                work.flags[1] = 0
            synchronize()
            integrate_stage(i, lane, lanes, model, state, work)
            foot_force_stage(i, lane, lanes, model, state, work)
            synchronize()
            if lane == 0:
                if model.simbicon.enabled == 1:
                    advance_phase(i, model, state)
                if wp.static(objective.follows_cycles):
                    advance_cycles(i, step, model, state)
                state.step[i] = step + 1
            synchronize()

    return repeated_step


def spare_state(state: State) -> State:
    """The same state with coordinates, speeds and accelerations of its own."""
    spare = State()
    for name in State.vars:
        setattr(spare, name, getattr(state, name))
    for name in ("coordinates", "speeds", "accelerations"):
        setattr(spare, name, wp.clone(getattr(state, name)))
    return spare


class RepeatedStep:
    """The kernel for the scene of a rollout, on its state."""

    def __init__(self, rollout: Rollout, noise: float) -> None:
        """Args: noise: of the starting velocities, m/s."""
        scene, names = rollout.scene, rollout.names
        self.rollout, self.noise = rollout, noise
        capacity = capacity_of(len(names.bodies))
        self.muscles = compiled_kind(scene, names, driven(scene, names), capacity, lean=not rollout.device.is_cpu)
        self.kernel = repeated_step_kernel(
            capacity, rollout.lanes, rollout.block_dim, self.muscles,
            objective_kind(scene, self.muscles is not None), bool(collision_pairs(scene, names)),
        )  # fmt: skip
        self.mixed = bool((rollout.model.actuation.drive.numpy() == MIXED).any())
        self.spare = spare_state(rollout.state)
        self.kept = Kept()
        for name, array in Kept.vars.items():
            zeros = wp.zeros((rollout.instances, len(names.bodies)), dtype=array.type.dtype, device=rollout.device)
            setattr(self.kept, name, zeros)
        self.buffer = wp.zeros(100_000, dtype=float, device=rollout.device)

    def run(self, steps: int, switches: Switches) -> float:
        """Time of some steps from the start, s."""
        rollout, device = self.rollout, self.rollout.device
        rollout.reset(self.noise, seed=1)
        for name in ("coordinates", "speeds", "accelerations"):
            wp.copy(getattr(self.spare, name), getattr(rollout.state, name))
        values = np.zeros(SWITCHES, dtype=np.int32)
        values[list(switches)] = list(switches.values())
        inputs = [
            steps, rollout.model, rollout.state, self.spare, Record(), wp.uint64(self.buffer.ptr),
            wp.array(values, dtype=int, device=device), self.kept,
        ]  # fmt: skip
        dim = (rollout.instances, rollout.lanes)
        wp.synchronize()
        begin = time.perf_counter()
        wp.launch(self.kernel, dim=dim, inputs=inputs, device=device, block_dim=rollout.block_dim)
        wp.synchronize()
        return time.perf_counter() - begin

    def split(self, steps: int, repeats: int) -> dict[str, float]:
        """Time of a step of the whole batch and of its stages, microseconds; the fastest of `repeats` runs."""
        again = [KINEMATICS, FAILURE, TARGETS, TORQUES, OBJECTIVE, INTEGRATION]
        again += [] if self.muscles is None else [PATHS] if self.mixed else [PATHS, ACTUATION]
        variants: dict[Any, Switches] = {"all": {}} | {stage: {stage: REPEATED} for stage in again}
        variants |= {("dynamics", part): {DYNAMICS: REPEATED, PARTS: part} for part in range(1 + FORWARD)}
        variants |= {NO_LIMITS: {NO_LIMITS: 1}} | ({} if self.muscles is None else {NO_MUSCLES: {NO_MUSCLES: 1}})
        self.run(steps, {})  # compiles and warms up
        times = [[self.run(steps, switches) for switches in variants.values()] for _ in range(repeats)]
        fastest = dict(zip(variants, 1e6 / steps * np.min(times, axis=0), strict=True))
        whole = fastest["all"]

        def extra(variant: Any) -> float:
            return float(fastest[variant] - whole) / REPEATED

        dynamics = [extra(("dynamics", part)) for part in range(1 + FORWARD)]
        inertia, contact, backward, forward = np.diff(dynamics).tolist()
        stages = {"forward kinematics": extra(KINEMATICS), "failure tests": extra(FAILURE)}
        stages |= {"controller targets": extra(TARGETS), "controller torques": extra(TORQUES)}
        if self.muscles is not None:
            stages["muscles"] = float(whole - fastest[NO_MUSCLES])
        stages |= {"objective": extra(OBJECTIVE), "inertia": inertia, "contact": contact}
        stages["joint limits"] = float(whole - fastest[NO_LIMITS])
        stages |= {"backward pass": backward, "forward pass": forward, "integration": extra(INTEGRATION)}
        stages["rest"] = float(whole) - sum(stages.values())
        if self.muscles is not None:
            stages["muscles: paths alone"] = extra(PATHS)
            if not self.mixed:
                stages["muscles: sums by joint alone"] = extra(ACTUATION)
        return {"all": float(whole)} | stages
