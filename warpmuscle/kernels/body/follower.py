"""Joints that follow another joint's coordinate, in the articulated-body algorithm: exact, without constraint forces.

A joint (the driver) and those that follow it make a cluster of one coordinate q. With their motion subspaces S, the
twist of a child in its parent by q' = 1, and the articulated inertia I and bias p of each of their bodies, a follower F
leaves all of I and p for its parent, as a fixed joint does, and besides, for the driver,

    U_F = I_F S_F + sum U,    D_F = S_F . I_F S_F + 2 S_F . sum U + sum D,    u_F = -S_F . p_F + sum (u - U . c_F)

with sums over the followers that hang on its body and c_F the acceleration of that at q'' = 0. The driver eliminates q
with its own U, D and u of this form, to which those of followers beside it, on its parent, are added: they do not move
with its child. (Jain 2011, Robot and Multibody Dynamics, ch. 15, calls such clusters aggregate bodies.)
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import symmetric_times
from warpmuscle.kernels.body.coordinate_joint import coordinate_axis, effort_on, joint_drift, reduce_any_remaining
from warpmuscle.kernels.body.dynamics import (
    Articulated,
    leave_downdated,
    leave_for_parent,
    move_body,
    reduce_body,
    with_children,
)
from warpmuscle.kernels.body.integration import integrate_body
from warpmuscle.kernels.body.joint_motion import has_motion
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import FIXED, FOLLOWER, ModelRef, ScratchRef, StateRef, at, nonnegative


@wp.struct
class Cluster:
    """What followers leave for the joint that they follow, about one point."""

    moment: wp.vec3  # angular half of U
    force: wp.vec3  # linear half of U
    d: float
    u: float


@wp.struct
class Gathered:
    """A joint's body with all that hangs on it."""

    x: Articulated
    joint: Cluster  # U, D and u of the joint itself with its followers on the body


@func
def driver_of(body: int, model: ModelRef) -> int:
    """The body whose joint's coordinate moves the joint of a body: itself, or another one if it follows that."""
    return nonnegative(model.couplings.joint[body].driver)


@func
def along_driver(
    instance: int, body: int, torque: wp.vec3, force: wp.vec3, model: ModelRef, work: ScratchRef
) -> wp.vec3:
    """What a force at a joint's point and a torque do to the coordinate that moves it, along the axis n of that."""
    return coordinate_axis(instance, driver_of(body, model), model, work) * effort_on(body, torque, force, work)


@func
def followers_on(parent: int, driver: int, body: int, model: ModelRef, work: ScratchRef) -> Cluster:
    """What the followers of a joint on a parent leave, about the joint of a body."""
    total = Cluster()
    first = model.skeleton.plan[parent].first_child
    for child in range(first, first + model.skeleton.plan[parent].child_count):
        if model.skeleton.plan[child].joint_type == FOLLOWER and driver_of(child, model) == driver:
            left = work.factor_a[child]
            force = wp.vec3(left[0, 1], left[1, 1], left[2, 1])
            r = work.position[child] - work.position[body]
            total.moment = total.moment + wp.vec3(left[0, 0], left[1, 0], left[2, 0]) + wp.cross(r, force)
            total.force = total.force + force
            total.d = total.d + left[0, 2]
            total.u = total.u + left[1, 2]
    return total


@func
def with_followers(body: int, driver: int, model: ModelRef, work: ScratchRef) -> Gathered:
    """What a joint's body carries, and U, D and u of the joint with the followers that hang on the body."""
    g = Gathered()
    g.x = with_children(body, model.skeleton, work)
    bias = work.bias[body]
    drift = joint_drift(body, model.skeleton, work)
    g.x.n += symmetric_times(g.x.a, bias) + g.x.b * drift
    g.x.f += wp.transpose(g.x.b) * bias + symmetric_times(g.x.c, drift)
    s = work.coordinate_turning[body]
    t = work.coordinate_moving[body]
    on = followers_on(body, driver, body, model, work)
    g.joint.moment = symmetric_times(g.x.a, s) + g.x.b * t + on.moment
    g.joint.force = wp.transpose(g.x.b) * s + symmetric_times(g.x.c, t) + on.force
    g.joint.d = wp.dot(s, g.joint.moment + on.moment) + wp.dot(t, g.joint.force + on.force) + on.d
    g.joint.u = on.u - wp.dot(s, g.x.n) - wp.dot(t, g.x.f) - wp.dot(on.moment, bias) - wp.dot(on.force, drift)
    return g


@func
def reduce_follower(body: int, model: ModelRef, work: ScratchRef):
    """Leave all of a follower's inertia for its parent, and U, D and u for the joint that it follows."""
    g = with_followers(body, driver_of(body, model), model, work)
    r = work.position[body] - work.position[nonnegative(model.skeleton.plan[body].parent)]
    work.factor_a[body] = wp.matrix_from_cols(g.joint.moment, g.joint.force, wp.vec3(g.joint.d, g.joint.u, 0.0))
    leave_for_parent(body, r, g.x.a, g.x.b, g.x.c, g.x.n, g.x.f, work)


@func
def reduce_driver(instance: int, body: int, model: ModelRef, work: ScratchRef):
    """Eliminate the coordinate of a joint and of those that follow it: `reduce_coordinate` of a cluster."""
    g = with_followers(body, body, model, work)
    parent = nonnegative(model.skeleton.plan[body].parent)
    r = work.position[body] - work.position[parent]
    axis = coordinate_axis(instance, body, model, work)
    beside = followers_on(parent, body, body, model, work)
    d = g.joint.d + beside.d
    d = 1.0 / (d + wp.dot(axis, symmetric_times(work.stiffness[body], axis)))
    q = (g.joint.u + beside.u - wp.dot(axis, work.torque[body])) * d
    leave_downdated(body, r, g.x, g.joint.moment + beside.moment, g.joint.force + beside.force, d, q, work)


@func
def accelerate_follower(body: int, model: ModelRef, work: ScratchRef):
    """Acceleration of a body from its parent's and that of the coordinate which its joint follows."""
    parent = nonnegative(model.skeleton.plan[body].parent)
    alpha = work.angular_acceleration[parent]
    a = work.acceleration[parent] + wp.cross(alpha, work.position[body] - work.position[parent])
    x = work.factor_c[driver_of(body, model)][0]
    along = a + work.coordinate_drift[body] + work.coordinate_moving[body] * x
    move_body(body, alpha, along, wp.vec3(x, 0.0, 0.0), work.coordinate_turning[body] * x, model.skeleton, work)


@func
def reduce_any_cluster(instance: int, body: int, model: ModelRef, work: ScratchRef):
    """`reduce_any` where other joints may follow."""
    if has_motion(model.skeleton.plan[body].joint_type):
        reduce_driver(instance, body, model, work)
    else:
        reduce_body(instance, body, model, work)


@func
def reduce_remaining_cluster(instance: int, body: int, model: ModelRef, work: ScratchRef):
    """`reduce_any_remaining` where other joints may follow; of what is prescribed, the bias of all of them knows."""
    if has_motion(model.skeleton.plan[body].joint_type) and model.motion.remaining[body] != FIXED:
        reduce_driver(instance, body, model, work)
    else:
        reduce_any_remaining(instance, body, model, work)


@cache
def backward_pass_of_clusters(reduce: Any) -> Any:
    """`dynamics.backward_pass_of` where joints may follow others, which come before those beside them."""

    @wp.func
    def backward_pass(instance: int, lane: int, lanes: int, model: ModelRef, work: ScratchRef):
        for step in range(1, model.level_count):
            level = model.level_count - step
            for body in range(nonnegative(model.level_start[level] + lane), model.level_start[level + 1], lanes):
                if model.skeleton.plan[body].joint_type == FOLLOWER:
                    reduce_follower(body, model, work)
            synchronize()
            for body in range(nonnegative(model.level_start[level] + lane), model.level_start[level + 1], lanes):
                if model.skeleton.plan[body].joint_type != FOLLOWER:
                    reduce(instance, body, model, work)
            synchronize()

    return backward_pass


@cache
def forward_pass_of_clusters(accelerate: Any) -> Any:
    """`dynamics.forward_pass_of` where joints may follow others, which come behind those beside them."""

    @wp.func
    def forward_pass(instance: int, lane: int, lanes: int, model: ModelRef, work: ScratchRef):
        for level in range(1, model.level_count):
            for body in range(nonnegative(model.level_start[level] + lane), model.level_start[level + 1], lanes):
                if model.skeleton.plan[body].joint_type != FOLLOWER:
                    accelerate(instance, body, model, work)
            synchronize()
            for body in range(nonnegative(model.level_start[level] + lane), model.level_start[level + 1], lanes):
                if model.skeleton.plan[body].joint_type == FOLLOWER:
                    accelerate_follower(body, model, work)
            synchronize()

    return forward_pass


@func
def integrate_drivers_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """`integrate_stage` where joints may follow others, and have no coordinates. Ends with a barrier."""
    largest = at(model.failure, instance, 0).max_speed
    kick = wp.where(state.step[instance] == 0, 0.5 * model.time_step, model.time_step)
    for i in range(lane, model.body_count, lanes):
        if model.skeleton.plan[i].joint_type != FOLLOWER:
            integrate_body(instance, i, model.skeleton.plan[i].joint_type, kick, largest, model, state, work)
    synchronize()
