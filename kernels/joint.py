"""Joint kinematics and joint limits."""

import warp as wp
from warpmuscle.kernels.angles import sine_cosine


@wp.func
def hinge_rotation(axis: wp.vec3, angle: float) -> wp.quat:
    """Rotation by `angle` (rad) about a unit axis."""
    half = sine_cosine(0.5 * angle)
    return wp.quat(axis[0] * half[0], axis[1] * half[0], axis[2] * half[0], half[1])


@wp.func
def universal_rotation(axis_a: wp.vec3, axis_b: wp.vec3, angle_a: float, angle_b: float) -> wp.quat:
    """Rotation of a universal joint: by b about the parent's axis, then by a about the child's own."""
    return hinge_rotation(axis_b, angle_b) * hinge_rotation(axis_a, angle_a)


@wp.func
def universal_bias(parent_velocity: wp.vec3, rate_a: wp.vec3, rate_b: wp.vec3) -> wp.vec3:
    """Velocity-product angular acceleration of a universal joint, rad/s^2.

    Axis b moves with the parent and axis a with the child: d/dt (b b') and d/dt (a a') at constant rates.

    Args:
        parent_velocity: angular velocity of the parent, world, rad/s.
        rate_a, rate_b: a a' and b b', the axes times their rates, world, rad/s.
    """
    return wp.cross(parent_velocity + rate_a + rate_b, rate_a) + wp.cross(parent_velocity, rate_b)


@wp.func
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


@wp.func
def within(x: float, y: float, length: float, cosine: float, sine: float, half_cosine: float) -> bool:
    """Whether the angle of a vector (x, y) of known length is within an interval, without an arctangent.

    Args:
        cosine, sine: of the middle of the interval. half_cosine: cosine of half its width, -2 if it is a full turn.
    """
    return x * cosine + y * sine >= half_cosine * length


@wp.func
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


@wp.func
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


@wp.func
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
