"""What controls the joints: SIMBICON, or efforts from outside or from a function compiled into the step.

SIMBICON may renew its targets in some steps only; PD follows them in every step.
An effort of a joint is a generalised force: its power is that of effort times speed, for each of the joint's speeds.
A positive one turns the child, and the parent backwards, in the sense in which the speed is positive, N m.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.scratch import synchronize
from warpmuscle.kernels.simbicon import control_stage, targets_stage, torques_stage
from warpmuscle.kernels.spatial import symmetric
from warpmuscle.kernels.structs import BALL, HINGE, UNIVERSAL, ModelRef, StateRef, WorkRef, at, rolled


@wp.func
def effort_torque(instance: int, body: int, effort: wp.vec3, model: ModelRef, work: WorkRef) -> wp.vec3:
    """Torque on the parent of a joint, world, N m, that does what the efforts of its speeds ask for."""
    kind = model.skeleton.plan[body].joint_type
    rotation = work.rotation[body]
    if kind == BALL:
        return -(rotation * effort)
    a = rotation * at(model.skeleton.row, instance, body).axis_a
    if kind == HINGE:
        return -(a * effort[0])
    if kind == UNIVERSAL:
        b = work.rotation[model.skeleton.plan[body].parent] * at(model.skeleton.row, instance, body).axis_b
        c = wp.dot(a, b)
        return (a * (c * effort[1] - effort[0]) + b * (c * effort[0] - effort[1])) / (1.0 - c * c)
    return wp.vec3(0.0)


@wp.func
def given_effort(instance: int, body: int, model: ModelRef, state: StateRef, work: WorkRef) -> wp.vec3:
    """Efforts of a joint as given from outside."""
    first = model.skeleton.plan[body].speed_start
    count = model.skeleton.plan[body].speed_end - first
    column = first - model.skeleton.plan[1].speed_start
    effort = wp.vec3(0.0)
    if count > 0:  # one by one, so that they stay in registers
        effort[0] = at(model.actuation.effort, instance, column)
    if count > 1:
        effort[1] = at(model.actuation.effort, instance, column + 1)
    if count > 2:
        effort[2] = at(model.actuation.effort, instance, column + 2)
    return effort


@wp.func
def held_control_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: WorkRef):
    """Torques of SIMBICON towards the targets of the last step in which it renewed them. Ends with a barrier."""
    renewed = state.step[instance] % model.simbicon.every == 0
    if renewed:
        targets_stage(instance, lane, lanes, model, state, work)
    for i in range(lane, model.body_count, lanes):
        rolled()
        if renewed:
            state.target[instance, i] = work.target[i]
            state.target_plan[instance, i] = wp.vec2(work.strength[i], float(work.frame[i]))
        else:
            plan = state.target_plan[instance, i]
            work.target[i] = state.target[instance, i]
            work.strength[i] = plan[0]
            work.frame[i] = int(plan[1])
    synchronize()
    torques_stage(instance, lane, lanes, model, state, work)


@cache
def control_stage_of(effort: Any = None, held: bool = False) -> Any:
    """The Warp function that puts what is wanted of the joints into the working set. It ends with a barrier.

    Args:
        effort: a Warp function (instance, body, model, state, work) -> efforts of the joint that carries a body; None:
            SIMBICON.
        held: whether SIMBICON holds its targets for some steps.
    """
    if effort is None:
        return held_control_stage if held else control_stage

    @wp.func
    def effort_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: WorkRef):
        if lane == 0:
            work.target[0] = wp.quat(0.0, 0.0, 0.0, 1.0)
            work.torque[0] = wp.vec3(0.0)
            work.stiffness[0] = symmetric(0.0)
        for i in range(1 + lane, model.body_count, lanes):
            work.target[i] = wp.quat(0.0, 0.0, 0.0, 1.0)
            work.torque[i] = effort_torque(instance, i, effort(instance, i, model, state, work), model, work)
            work.stiffness[i] = symmetric(0.0)
        synchronize()

    return effort_stage
