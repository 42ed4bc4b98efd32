"""Joints of one coordinate in the stages of a step: their motion is a function of it, see `joint_motion.py`.

Such a joint keeps torques, moment arms and implicit inertia of its coordinate as a hinge does, along an axis n of the
child, `BodyRow.axis_a`: a vector n Q for a generalised force Q, which is N m if the coordinate is an angle and N if it
is a length. So the stages of muscles, limits and controllers need not know it from a hinge. Kinematics and dynamics do:
the child's joint point moves, and the motion subspace S, an angular and a linear half, changes with the coordinate.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import symmetric_times
from warpmuscle.kernels.body.dynamics import (
    accelerate_body,
    along_one,
    leave_downdated,
    leave_for_parent,
    move_body,
    reduce_body,
    with_children,
)
from warpmuscle.kernels.body.hybrid import accelerate_remaining, reduce_remaining
from warpmuscle.kernels.body.joint_motion import MotionOf, has_motion, motion_of
from warpmuscle.kernels.body.kinematics import move_joint, place_body
from warpmuscle.kernels.body.motion import prescribe_stage
from warpmuscle.kernels.body.two_coordinates import move_by_two
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.main_memory import rotation_of
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import FIXED, ModelRef, ScratchRef, Skeleton, StateRef, at, nonnegative


@func
def coordinate_axis(instance: int, body: int, model: ModelRef, work: ScratchRef) -> wp.vec3:
    """The axis n that torques and moment arms of a joint of one coordinate are kept along, world."""
    return rotation_of(body, work) * at(model.skeleton.row, instance, body).axis_a


@func
def coordinate_velocities(instance: int, lane: int, lanes: int, model: ModelRef, work: ScratchRef):
    """Velocities of such joints in place of those of `path.joint_velocities`: n q'. Ends with a barrier."""
    for body in range(1 + lane, model.body_count, lanes):
        if has_motion(model.skeleton.plan[body].joint_type):
            now = work.coordinate_state[body]
            work.joint_velocity[body] = coordinate_axis(instance, body, model, work) * (now[1] - now[2])
    synchronize()


@func
def effort_on(body: int, torque: wp.vec3, force: wp.vec3, work: ScratchRef) -> float:
    """The generalised force that a force at a joint's point and a torque are, S . (torque, force)."""
    return wp.dot(work.coordinate_turning[body], torque) + wp.dot(work.coordinate_moving[body], force)


@func
def put_groups(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """What joints do together that one coordinate moves: S of all of them, in the place of the first. No barrier."""
    for g in range(lane, state.muscles.group_turning.shape[1], lanes):
        group = model.paths.member[nonnegative(g)]
        place = work.position[nonnegative(model.paths.member[nonnegative(group.start)].joint)]
        turning = wp.vec3(0.0)
        moving = wp.vec3(0.0)
        for k in range(group.start, group.end):
            member = model.paths.member[nonnegative(k)]
            joint = nonnegative(member.joint)
            s = work.coordinate_turning[joint] * member.sign
            turning += s
            moving += work.coordinate_moving[joint] * member.sign + wp.cross(s, place - work.position[joint])
        state.muscles.group_turning[instance, g] = turning
        state.muscles.group_moving[instance, g] = moving


@func(inline=True)
def group_effort(
    instance: int, joint: int, group: int, torque: wp.vec3, force: wp.vec3, state: StateRef, work: ScratchRef
) -> float:
    """`effort_on` a joint, or on a group, whose first it is; no group: below 0."""
    if group < 0:
        return effort_on(joint, torque, force, work)
    g = nonnegative(group)
    effort = wp.dot(state.muscles.group_turning[instance, g], torque)
    return effort + wp.dot(state.muscles.group_moving[instance, g], force)


@func
def along_coordinate(
    instance: int, body: int, torque: wp.vec3, force: wp.vec3, model: ModelRef, work: ScratchRef
) -> wp.vec3:
    """What a force at a joint's point and a torque do to its coordinate, n S . (torque, force)."""
    return coordinate_axis(instance, body, model, work) * effort_on(body, torque, force, work)


@func
def place_on_path(body: int, skeleton: Skeleton, work: ScratchRef):
    """What a joint of one coordinate adds to the motion of its child, whose joint point moves; S goes to world axes."""
    parent = nonnegative(skeleton.plan[body].parent)
    parent_rotation = rotation_of(parent, work)
    moving = parent_rotation * work.coordinate_moving[body]
    now = work.coordinate_state[body]
    work.coordinate_turning[body] = parent_rotation * work.coordinate_turning[body]
    work.coordinate_moving[body] = moving
    work.velocity[body] = work.velocity[body] + moving * now[1]
    work.lag_velocity[body] = work.lag_velocity[body] + moving * now[2]
    work.bias[body] = work.bias[body] + parent_rotation * work.coordinate_turning_drift[body]
    coriolis = 2.0 * wp.cross(work.angular_velocity[parent], moving * now[1])
    work.coordinate_drift[body] = parent_rotation * work.coordinate_drift[body] + coriolis


@func
def place_any(skeleton: Skeleton, body: int, work: ScratchRef):
    """`place_body` where there may be joints of one coordinate."""
    place_body(skeleton, body, work)
    if has_motion(skeleton.plan[body].joint_type):
        place_on_path(body, skeleton, work)


@func
def joint_drift(body: int, skeleton: Skeleton, work: ScratchRef) -> wp.vec3:
    """Acceleration of a body's joint of one coordinate at a constant speed."""
    parent = nonnegative(skeleton.plan[body].parent)
    w = work.angular_velocity[parent]
    r = work.position[body] - work.position[parent]
    return wp.cross(w, wp.cross(w, r)) + work.coordinate_drift[body]


@func
def reduce_coordinate(instance: int, body: int, free: bool, model: ModelRef, work: ScratchRef):
    """Eliminate a joint of one coordinate: rank-1 downdate by S (Featherstone 2008, eq. 7.43); none if prescribed."""
    x = with_children(body, model.skeleton, work)
    r = work.position[body] - work.position[nonnegative(model.skeleton.plan[body].parent)]
    bias = work.bias[body]
    drift = joint_drift(body, model.skeleton, work)
    x.n += symmetric_times(x.a, bias) + x.b * drift
    x.f += wp.transpose(x.b) * bias + symmetric_times(x.c, drift)
    if not free:
        leave_for_parent(body, r, x.a, x.b, x.c, x.n, x.f, work)
        return
    s = work.coordinate_turning[body]
    t = work.coordinate_moving[body]
    axis = coordinate_axis(instance, body, model, work)
    force = -wp.dot(axis, work.torque[body])
    stiffness = wp.dot(axis, symmetric_times(work.stiffness[body], axis))
    ua = symmetric_times(x.a, s) + x.b * t
    ub = wp.transpose(x.b) * s + symmetric_times(x.c, t)
    d = 1.0 / (wp.dot(s, ua) + wp.dot(t, ub) + stiffness)
    q = (force - wp.dot(s, x.n) - wp.dot(t, x.f)) * d
    leave_downdated(body, r, x, ua, ub, d, q, work)


@func
def accelerate_coordinate(body: int, free: bool, skeleton: Skeleton, work: ScratchRef):
    """Acceleration of a body and of its joint of one coordinate, unless that is prescribed, from its parent's."""
    parent = nonnegative(skeleton.plan[body].parent)
    alpha = work.angular_acceleration[parent]
    a = work.acceleration[parent] + wp.cross(alpha, work.position[body] - work.position[parent])
    x = wp.float32(0.0)
    if free:
        x = along_one(work.factor_a[body], alpha, a)
    along = a + work.coordinate_drift[body] + work.coordinate_moving[body] * x
    move_body(body, alpha, along, wp.vec3(x, 0.0, 0.0), work.coordinate_turning[body] * x, skeleton, work)


@func
def reduce_any(instance: int, body: int, model: ModelRef, work: ScratchRef):
    """`reduce_body` where there may be joints of one coordinate."""
    if has_motion(model.skeleton.plan[body].joint_type):
        reduce_coordinate(instance, body, True, model, work)
    else:
        reduce_body(instance, body, model, work)


@func
def accelerate_any(instance: int, body: int, model: ModelRef, work: ScratchRef):
    """`accelerate_body` where there may be joints of one coordinate."""
    if has_motion(model.skeleton.plan[body].joint_type):
        accelerate_coordinate(body, True, model.skeleton, work)
    else:
        accelerate_body(instance, body, model, work)


@func
def reduce_any_remaining(instance: int, body: int, model: ModelRef, work: ScratchRef):
    """`reduce_remaining` where there may be joints of one coordinate."""
    if has_motion(model.skeleton.plan[body].joint_type):
        reduce_coordinate(instance, body, model.motion.remaining[body] != FIXED, model, work)
    else:
        reduce_remaining(instance, body, model, work)


@func
def accelerate_any_remaining(instance: int, body: int, model: ModelRef, work: ScratchRef):
    """`accelerate_remaining` where there may be joints of one coordinate."""
    if has_motion(model.skeleton.plan[body].joint_type):
        accelerate_coordinate(body, model.motion.remaining[body] != FIXED, model.skeleton, work)
    else:
        accelerate_remaining(instance, body, model, work)


@func
def prescribe_any(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """`prescribe_stage` where there may be joints of one coordinate. No barrier."""
    prescribe_stage(instance, lane, lanes, model, state, work)
    for k in range(lane, model.motion.joint.shape[0], lanes):
        body = model.motion.joint[k, 0]
        if has_motion(model.skeleton.plan[body].joint_type):
            rate = state.accelerations[instance, model.skeleton.plan[body].speed_start]
            # in place of what a hinge about n would have got
            turning = work.coordinate_turning[body] - coordinate_axis(instance, body, model, work)
            work.bias[body] = work.bias[body] + turning * rate
            work.coordinate_drift[body] = work.coordinate_drift[body] + work.coordinate_moving[body] * rate


@cache
def move_any_of(
    joints: tuple[MotionOf, ...], displaced: bool = False, of_two: bool = False, sparse: bool = False
) -> Any:
    """The Warp function `move_joint` where there may be such joints of one coordinate, or of two."""
    joint_motion = motion_of(joints, displaced, sparse)

    @wp.func
    def move_any(instance: int, body: int, half: float, model: ModelRef, state: StateRef, work: ScratchRef):
        move_joint(instance, body, half, model, state, work)
        if has_motion(model.skeleton.plan[body].joint_type):
            speed = nonnegative(model.skeleton.plan[body].speed_start)
            q = state.coordinates[instance, nonnegative(model.skeleton.plan[body].coordinate_start)]
            v = state.speeds[instance, speed]
            gain = half * state.accelerations[instance, speed]
            m = joint_motion(instance, body, q, model, work)
            work.anchor[body] = work.anchor[body] + m.place
            work.turned[body] = m.orientation
            work.rate[body] = wp.vec3(0.0)
            work.gain[body] = wp.vec3(0.0)
            work.parent_rate[body] = m.turning * v
            work.parent_gain[body] = m.turning * gain
            work.coordinate_turning[body] = m.turning
            work.coordinate_moving[body] = m.moving
            work.coordinate_turning_drift[body] = m.turning_slope * (v * v)
            work.coordinate_drift[body] = m.moving_slope * (v * v)
            work.coordinate_state[body] = wp.vec3(q, v, gain)
            if wp.static(of_two):
                move_by_two(instance, body, model, state, work)

    return move_any
