"""Hybrid dynamics: the articulated-body algorithm where some degrees of freedom are prescribed, see `motion.py`."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import symmetric_times
from warpmuscle.kernels.body.dynamics import (
    accelerate_body,
    accelerate_root,
    backward_pass_of,
    forward_pass_of,
    joint_acceleration,
    leave_for_parent,
    move_body,
    reduce_ball,
    reduce_hinge,
    reduce_universal,
    with_children,
)
from warpmuscle.kernels.body.integration import integrate_angle, integrate_body
from warpmuscle.kernels.body.motion import follow, prescribed_root
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import (
    BALL,
    FIXED,
    HINGE,
    ROOT_PLANAR,
    ROOT_PRESCRIBED,
    SECOND_HINGE,
    UNIVERSAL,
    ModelRef,
    ScratchRef,
    StateRef,
    at,
    nonnegative,
)


@func
def second_axis(instance: int, body: int, model: ModelRef, work: ScratchRef) -> wp.vec3:
    """The axis of a universal joint that rides on the parent, world."""
    return work.rotation[model.skeleton.plan[body].parent] * at(model.skeleton.row, instance, body).axis_b


@func
def reduce_remaining(instance: int, body: int, model: ModelRef, work: ScratchRef):
    """Eliminate what is not prescribed of the joint of one body and leave the rest for its parent.

    Written as `dynamics.reduce_body`; sharing code with it changes how the compiler rounds there.
    """
    skeleton = model.skeleton
    x = with_children(body, skeleton, work)
    parent = nonnegative(skeleton.plan[body].parent)
    r = work.position[body] - work.position[parent]
    parent_angular = work.angular_velocity[parent]
    drift = wp.cross(parent_angular, wp.cross(parent_angular, r))
    x.n += symmetric_times(x.a, work.bias[body]) + x.b * drift
    x.f += wp.transpose(x.b) * work.bias[body] + symmetric_times(x.c, drift)
    torque = -work.torque[body]
    kind = model.motion.remaining[body]
    axis_a = work.rotation[body] * at(skeleton.row, instance, body).axis_a
    axis_b = work.rotation[parent] * at(skeleton.row, instance, body).axis_b
    if kind == BALL:
        reduce_ball(body, r, torque, x, work)
    elif kind == FIXED:
        leave_for_parent(body, r, x.a, x.b, x.c, x.n, x.f, work)
    elif kind == UNIVERSAL:
        reduce_universal(body, r, torque, x, axis_a, axis_b, work)
    elif kind == HINGE:
        reduce_hinge(body, r, torque, x, axis_a, work)
    else:
        reduce_hinge(body, r, torque, x, axis_b, work)


@func
def accelerate_remaining(instance: int, body: int, model: ModelRef, work: ScratchRef):
    """Acceleration of a body, and of what is not prescribed of its joint, from its parent's."""
    kind = model.motion.remaining[body]
    if kind == model.skeleton.plan[body].joint_type:
        accelerate_body(instance, body, model, work)
    else:
        parent = nonnegative(model.skeleton.plan[body].parent)
        alpha = work.angular_acceleration[parent]
        a = work.acceleration[parent] + wp.cross(alpha, work.position[body] - work.position[parent])
        x = wp.vec3(0.0)
        relative = wp.vec3(0.0)
        if kind != FIXED:
            x = joint_acceleration(HINGE, body, alpha, a, work)
            axis = second_axis(instance, body, model, work)
            if kind == HINGE:
                axis = work.rotation[body] * at(model.skeleton.row, instance, body).axis_a
            relative = axis * x[0]
        move_body(body, alpha, a, x, relative, model.skeleton, work)


@cache
def hybrid_acceleration_stage_of(backward_pass: Any, forward_pass: Any) -> Any:
    """The Warp function of accelerations of all bodies, and of joints where they are not prescribed.

    It ends with a barrier.

    Args:
        backward_pass, forward_pass: see `dynamics.backward_pass_of` and `dynamics.forward_pass_of`.
    """

    @func
    def hybrid_acceleration_stage(
        instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef
    ):
        backward_pass(instance, lane, lanes, model, work)
        if lane == 0:
            if model.motion.remaining[0] == ROOT_PRESCRIBED:
                x = prescribed_root(instance, model.skeleton.plan[0].joint_type == ROOT_PLANAR, state)
                work.angular_acceleration[0] = wp.spatial_top(x)
                work.acceleration[0] = wp.spatial_bottom(x)
            else:
                accelerate_root(model.skeleton.plan[0].joint_type, model.skeleton, work)
        synchronize()
        forward_pass(instance, lane, lanes, model, work)

    return hybrid_acceleration_stage


hybrid_acceleration_stage = hybrid_acceleration_stage_of(
    backward_pass_of(reduce_remaining), forward_pass_of(accelerate_remaining)
)


@func
def hybrid_integrate_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """Move all coordinates over a step: by leapfrog, or as their motion prescribes. Ends with a barrier."""
    h = model.time_step
    largest = at(model.failure, instance, 0).max_speed
    step = state.step[instance]
    kick = wp.where(step == 0, 0.5 * h, h)
    for i in range(lane, model.body_count, lanes):
        kind = model.motion.remaining[i]
        if kind == SECOND_HINGE:
            first = model.skeleton.plan[i].coordinate_start + 1
            speed = model.skeleton.plan[i].speed_start + 1
            integrate_angle(state, instance, first, speed, work.factor_c[i][0], kick, h, largest, work)
        elif kind != ROOT_PRESCRIBED:
            integrate_body(instance, i, kind, kick, largest, model, state, work)
    follow(instance, lane, lanes, float(step + 1) * h, model, state)
    synchronize()
