"""Leapfrog integration of coordinates and speeds."""

import warp as wp

from warpmuscle.kernels.kinematics import coordinate_quat
from warpmuscle.kernels.lanes import synchronize
from warpmuscle.kernels.spatial import turn
from warpmuscle.kernels.structs import BALL, FIXED, ROOT_FREE, ROOT_PLANAR, UNIVERSAL, Model, State, Work, at


@wp.func
def kicked(
    state: State, instance: int, i: int, acceleration: float, kick: float, half: float, largest: float, work: Work
) -> float:
    """Store speed i after a step, and return it as it is in the middle of that step.

    Leapfrog: the velocity in the middle of a step moves the coordinates, and is what implicit forces start from; the
    speed stored is extrapolated to the end of the step, so that it belongs to the coordinates stored beside it and
    velocity products are second-order accurate. A speed that is not finite or beyond the largest flags divergence and
    is not stored.

    Args:
        kick: time that the acceleration has acted, s: a step, or half of it in the first step. half: half a step, s.
    """
    middle = state.speeds[instance, i] - half * state.accelerations[instance, i] + kick * acceleration
    if not (wp.abs(middle) <= largest):
        work.flags[1] = 1
        return 0.0
    state.speeds[instance, i] = middle + half * acceleration
    state.accelerations[instance, i] = acceleration
    return middle


@wp.func
def kicked_vector(
    state: State, instance: int, first: int, acceleration: wp.vec3, kick: float, half: float, largest: float, work: Work
) -> wp.vec3:
    """The same for speeds first..first + 2."""
    return wp.vec3(
        kicked(state, instance, first, acceleration[0], kick, half, largest, work),
        kicked(state, instance, first + 1, acceleration[1], kick, half, largest, work),
        kicked(state, instance, first + 2, acceleration[2], kick, half, largest, work),
    )


@wp.func
def store_quat(state: State, instance: int, first: int, q: wp.quat):
    """Store a quaternion at coordinates first..first + 3."""
    for i in range(4):
        state.coordinates[instance, first + i] = q[i]


@wp.func
def move(state: State, instance: int, i: int, way: float):
    """Add to coordinate i. (`+=` on an array would be an atomic operation.)"""
    state.coordinates[instance, i] = state.coordinates[instance, i] + way


@wp.func
def integrate_root(instance: int, model: Model, state: State, work: Work, kick: float, largest: float):
    """Move the root over a step."""
    h = model.time_step
    kind = model.skeleton.joint_type[0]
    alpha = work.angular_acceleration[0]
    a = work.acceleration[0]
    if kind == ROOT_FREE:
        v = kicked_vector(state, instance, 0, a, kick, 0.5 * h, largest, work)
        w = kicked_vector(state, instance, 3, alpha, kick, 0.5 * h, largest, work)
        for i in range(3):
            move(state, instance, i, h * v[i])
        q = work.orientation[0]
        store_quat(state, instance, 3, turn(q, wp.quat_rotate_inv(q, w), h))
    elif kind == ROOT_PLANAR:
        v = kicked_vector(state, instance, 0, wp.vec3(a[1], a[2], alpha[0]), kick, 0.5 * h, largest, work)
        for i in range(3):
            move(state, instance, i, h * v[i])


@wp.func
def integrate_body(
    instance: int, i: int, kind: int, kick: float, largest: float, model: Model, state: State, work: Work
):  # fmt: skip
    """Move the root, or the joint of a body, of a given type, over a step."""
    h = model.time_step
    half = 0.5 * h
    first = model.skeleton.coordinate_start[i]
    speed = model.skeleton.speed_start[i]
    x = work.factor_c[i]
    if i == 0:
        integrate_root(instance, model, state, work, kick, largest)
    elif kind == BALL:
        w = kicked_vector(state, instance, speed, x, kick, half, largest, work)
        store_quat(state, instance, first, turn(coordinate_quat(state, instance, first), w, h))
    elif kind != FIXED:
        move(state, instance, first, h * kicked(state, instance, speed, x[0], kick, half, largest, work))
        if kind == UNIVERSAL:
            middle = kicked(state, instance, speed + 1, x[1], kick, half, largest, work)
            move(state, instance, first + 1, h * middle)


@wp.func
def integrate_stage(instance: int, lane: int, lanes: int, model: Model, state: State, work: Work):
    """Move all coordinates over a step by leapfrog, see `kicked`. Ends with a barrier."""
    largest = at(model.failure, instance, 0)[2]
    kick = wp.where(state.step[instance] == 0, 0.5 * model.time_step, model.time_step)
    for i in range(lane, model.body_count, lanes):
        integrate_body(instance, i, model.skeleton.joint_type[i], kick, largest, model, state, work)
    synchronize()
