"""Joint limits: one-sided spring-dampers, linearly implicit in the step."""

import warp as wp

from warpmuscle.kernels.algebra.spatial import symmetric_outer
from warpmuscle.kernels.body.kinematics import coordinate_quat
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import BALL, UNIVERSAL, ModelRef, ScratchRef, StateRef, at, nonnegative


@func
def limit_torque(
    angle: float, rate: float, low: float, high: float, stiffness: float, damping: float, time_step: float
) -> wp.vec2:
    """One-sided spring-damper at a joint limit, linearly implicit.

    Returns the torque along the coordinate, N m, that pushes back within low..high, and the joint-space inertia
    h (d + h k) that makes the step implicit; both 0 within the limits, and where the stop would pull.
    """
    excess = angle - wp.clamp(angle, low, high)
    if excess == 0.0:
        return wp.vec2(0.0, 0.0)
    effective = damping + time_step * stiffness
    torque = -stiffness * excess - effective * rate
    if torque * excess > 0.0:
        return wp.vec2(0.0, 0.0)
    return wp.vec2(torque, time_step * effective)


@func
def within(x: float, y: float, length: float, cosine: float, sine: float, half_cosine: float) -> bool:
    """Whether the angle of a vector (x, y) of known length is within an interval, without an arctangent.

    Args:
        cosine, sine: of the middle of the interval. half_cosine: cosine of half its width, -2 if it is a full turn.
    """
    return x * cosine + y * sine >= half_cosine * length


@func
def ball_within(
    rotation: wp.quat, swing: wp.vec3, twist: wp.vec3, cosine: wp.vec3, sine: wp.vec3, half_cosine: wp.vec3
) -> bool:
    """Whether all three `ball_angles` are within their intervals, each given as in `within`."""
    middle = wp.cross(swing, twist)
    turned_twist = wp.quat_rotate(rotation, twist)
    up = -wp.dot(swing, turned_twist)
    level = wp.sqrt(wp.max(1.0 - up * up, 0.0))
    first = within(wp.dot(twist, turned_twist), wp.dot(middle, turned_twist), level, cosine[0], sine[0], half_cosine[0])
    second = within(level, up, 1.0, cosine[1], sine[1], half_cosine[1])
    back = wp.quat_rotate_inv(rotation, swing)
    third = within(wp.dot(swing, back), wp.dot(middle, back), level, cosine[2], sine[2], half_cosine[2])
    return first and second and third


@func
def ball_angles(rotation: wp.quat, swing: wp.vec3, twist: wp.vec3) -> wp.vec3:
    """Angles of R = rot(x, swing) rot(y, swing x twist) rot(z, twist); y within -pi/2..pi/2, rad.

    Args:
        rotation: child in parent.
        swing, twist: orthogonal unit axes; swing is fixed in the parent, twist in the child.
    """
    middle = wp.cross(swing, twist)
    turned_swing = wp.quat_rotate(rotation, swing)
    turned_middle = wp.quat_rotate(rotation, middle)
    turned_twist = wp.quat_rotate(rotation, twist)
    return wp.vec3(
        wp.atan2(wp.dot(middle, turned_twist), wp.dot(twist, turned_twist)),
        -wp.asin(wp.clamp(wp.dot(swing, turned_twist), -1.0, 1.0)),
        wp.atan2(wp.dot(swing, turned_middle), wp.dot(swing, turned_swing)),
    )


@func
def ball_rate_axes(swing: wp.vec3, twist: wp.vec3) -> wp.mat33:
    """Rows g with d(angle)/dt = g . w for the angles of `ball_angles`, w the relative angular velocity.

    Near gimbal lock (swing parallel to twist) the rows are kept bounded.

    Args:
        swing: the parent's axis, world. twist: the child's axis, world.
    """
    across = wp.cross(twist, swing)
    n = wp.max(wp.length(across), 1.0e-6)
    middle = across / -n
    cosine = wp.max(n, 0.2)
    first = wp.cross(twist, middle) / cosine
    third = wp.cross(middle, swing) / cosine
    return wp.matrix_from_rows(first, middle, third)


@func
def add_limit(body: int, axis: wp.vec3, limit: wp.vec2, work: ScratchRef):
    """Add what a limit gives about an axis, see `limit_torque`, to a joint. (`+=` would be an atomic operation.)"""
    work.torque[body] = work.torque[body] - axis * limit[0]
    work.stiffness[body] = work.stiffness[body] + symmetric_outer(axis, limit[1])


@func
def limit_stage(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """Add the joint's limits, if any is exceeded, to its torque and implicit inertia."""
    skeleton = model.skeleton
    plan = skeleton.plan[body]
    row = at(skeleton.row, instance, body)
    limits = at(skeleton.limits, instance, body)
    kind = plan.joint_type
    low = limits.low
    high = limits.high
    stiffness = limits.stiffness
    damping = limits.damping
    axis_a = row.axis_a
    axis_b = row.axis_b
    parent = nonnegative(plan.parent)
    first = nonnegative(plan.coordinate_start)
    speed = nonnegative(plan.speed_start)
    half = 0.5 * model.time_step
    if kind == BALL:
        q = coordinate_quat(state, instance, first)
        cosine = limits.cosine
        sine = limits.sine
        if not ball_within(q, axis_a, axis_b, cosine, sine, limits.half_cosine):
            angles = ball_angles(q, axis_a, axis_b)
            g = ball_rate_axes(work.rotation[parent] * axis_a, work.rotation[body] * axis_b)
            angular = work.angular_velocity[body] - work.angular_velocity[parent]
            rates = g * (angular - work.lag_angular[body] + work.lag_angular[parent])
            for i in range(3):
                t = limit_torque(angles[i], rates[i], low[i], high[i], stiffness, damping, model.time_step)
                axis = wp.vec3(g[i, 0], g[i, 1], g[i, 2])
                add_limit(body, axis, t, work)
    else:
        x = state.coordinates[instance, first]
        if x < low[0] or x > high[0]:
            axis = work.rotation[body] * axis_a
            rate = state.speeds[instance, speed] - half * state.accelerations[instance, speed]
            t = limit_torque(x, rate, low[0], high[0], stiffness, damping, model.time_step)
            add_limit(body, axis, t, work)
        if kind == UNIVERSAL:
            y = state.coordinates[instance, first + 1]
            if y < low[1] or y > high[1]:
                axis = work.rotation[parent] * axis_b
                rate = state.speeds[instance, speed + 1] - half * state.accelerations[instance, speed + 1]
                t = limit_torque(y, rate, low[1], high[1], stiffness, damping, model.time_step)
                add_limit(body, axis, t, work)
