"""Leapfrog integration of coordinates and speeds."""

import warp as wp

from warpmuscle.kernels.algebra.spatial import turn
from warpmuscle.kernels.body.kinematics import acceleration_vector, coordinate_quat, coordinate_vector, speed_vector
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import (
    BALL,
    FIXED,
    ROOT_FREE,
    ROOT_PLANAR,
    UNIVERSAL,
    ModelRef,
    ScratchRef,
    StateRef,
    at,
    nonnegative,
)


@func
def kicked(before: float, last: float, acceleration: float, kick: float, half: float) -> float:
    """A speed in the middle of a step, from what was stored at its start.

    Leapfrog: the velocity in the middle of a step moves the coordinates, and is what implicit forces start from; the
    speed stored is extrapolated to the end of the step, so that it belongs to the coordinates stored beside it and
    velocity products are second-order accurate.

    Args:
        before: the speed. last: its acceleration in the step before.
        kick: time that the acceleration has acted, s: a step, or half of it in the first step. half: half a step, s.
    """
    return before - half * last + kick * acceleration


@func
def store_speed(
    state: StateRef,
    instance: int,
    i: int,
    middle: float,
    acceleration: float,
    half: float,
    largest: float,
    work: ScratchRef,
) -> float:
    """Store speed i after a step from that in its middle, which is returned.

    A speed that is not finite or beyond the largest flags divergence and is not stored; it counts as zero.
    """
    if not (wp.abs(middle) <= largest):
        work.flags[1] = 1
        return 0.0
    state.speeds[instance, i] = middle + half * acceleration
    state.accelerations[instance, i] = acceleration
    return middle


@func
def kicked_speed(
    state: StateRef,
    instance: int,
    i: int,
    acceleration: float,
    kick: float,
    half: float,
    largest: float,
    work: ScratchRef,
) -> float:
    """Speed i in the middle of a step; what it is after the step is stored."""
    middle = kicked(state.speeds[instance, i], state.accelerations[instance, i], acceleration, kick, half)
    return store_speed(state, instance, i, middle, acceleration, half, largest, work)


@func
def kicked_vector(
    state: StateRef,
    instance: int,
    first: int,
    acceleration: wp.vec3,
    kick: float,
    half: float,
    largest: float,
    work: ScratchRef,
) -> wp.vec3:
    """The same for speeds first..first + 2, which are fetched at once."""
    before = speed_vector(state, instance, first)
    last = acceleration_vector(state, instance, first)
    middle = wp.vec3(
        kicked(before[0], last[0], acceleration[0], kick, half),
        kicked(before[1], last[1], acceleration[1], kick, half),
        kicked(before[2], last[2], acceleration[2], kick, half),
    )
    return wp.vec3(
        store_speed(state, instance, first, middle[0], acceleration[0], half, largest, work),
        store_speed(state, instance, first + 1, middle[1], acceleration[1], half, largest, work),
        store_speed(state, instance, first + 2, middle[2], acceleration[2], half, largest, work),
    )


@func
def store_quat(state: StateRef, instance: int, first: int, q: wp.quat):
    """Store a quaternion at coordinates first..first + 3."""
    for i in range(4):
        state.coordinates[instance, first + i] = q[i]


@func
def integrate_root(instance: int, model: ModelRef, state: StateRef, work: ScratchRef, kick: float, largest: float):
    """Move the root over a step."""
    h = model.time_step
    kind = model.skeleton.plan[0].joint_type
    alpha = work.angular_acceleration[0]
    a = work.acceleration[0]
    if kind == ROOT_FREE:
        p = coordinate_vector(state, instance, 0)
        v = kicked_vector(state, instance, 0, a, kick, 0.5 * h, largest, work)
        w = kicked_vector(state, instance, 3, alpha, kick, 0.5 * h, largest, work)
        for i in range(3):
            state.coordinates[instance, i] = p[i] + h * v[i]
        q = work.orientation[0]
        store_quat(state, instance, 3, turn(q, wp.quat_rotate_inv(q, w), h))
    elif kind == ROOT_PLANAR:
        p = coordinate_vector(state, instance, 0)
        v = kicked_vector(state, instance, 0, wp.vec3(a[1], a[2], alpha[0]), kick, 0.5 * h, largest, work)
        for i in range(3):
            state.coordinates[instance, i] = p[i] + h * v[i]


@func
def integrate_angle(
    state: StateRef, instance: int, i: int, speed: int, acceleration: float, kick: float, h: float, largest: float,
    work: ScratchRef,
):  # fmt: skip
    """Move coordinate i, whose speed has a number of its own, over a step."""
    angle = state.coordinates[instance, i]
    middle = kicked_speed(state, instance, speed, acceleration, kick, 0.5 * h, largest, work)
    state.coordinates[instance, i] = angle + h * middle


@func
def integrate_body(
    instance: int, i: int, kind: int, kick: float, largest: float, model: ModelRef, state: StateRef, work: ScratchRef
):  # fmt: skip
    """Move the root, or the joint of a body, of a given type, over a step."""
    h = model.time_step
    half = 0.5 * h
    plan = model.skeleton.plan[i]
    first = nonnegative(plan.coordinate_start)
    speed = nonnegative(plan.speed_start)
    x = work.factor_c[i]
    if i == 0:
        integrate_root(instance, model, state, work, kick, largest)
    elif kind == BALL:
        q = coordinate_quat(state, instance, first)
        w = kicked_vector(state, instance, speed, x, kick, half, largest, work)
        store_quat(state, instance, first, turn(q, w, h))
    elif kind != FIXED:
        integrate_angle(state, instance, first, speed, x[0], kick, h, largest, work)
        if kind == UNIVERSAL:
            integrate_angle(state, instance, first + 1, speed + 1, x[1], kick, h, largest, work)


@func
def integrate_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """Move all coordinates over a step by leapfrog, see `kicked`. Ends with a barrier."""
    largest = at(model.failure, instance, 0).max_speed
    kick = wp.where(state.step[instance] == 0, 0.5 * model.time_step, model.time_step)
    for i in range(lane, model.body_count, lanes):
        integrate_body(instance, i, model.skeleton.plan[i].joint_type, kick, largest, model, state, work)
    synchronize()
