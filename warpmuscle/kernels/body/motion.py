"""Prescribed motion: kinematic coordinates follow curves over time, whatever forces that takes.

Curves are polynomials of fifth degree, piece by piece. The dynamics takes the acceleration of a prescribed coordinate
as given, as hybrid dynamics does (Featherstone 2008, section 9.2): such a joint hands on the whole articulated inertia
of its child, and what its acceleration asks for is part of the bias.
"""

import warp as wp

from warpmuscle.kernels.body.kinematics import acceleration_vector
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import (
    BALL,
    FIRST_AXIS,
    SECOND_AXIS,
    ModelRef,
    PrescribedMotion,
    ScratchRef,
    StateRef,
    at,
    polynomial,
)


@func
def polynomial_rates(c: polynomial, x: float) -> wp.vec3:
    """Value, first and second derivative of c0 + c1 x + ... + c5 x^5."""
    value = c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * (c[4] + x * c[5]))))
    slope = c[1] + x * (2.0 * c[2] + x * (3.0 * c[3] + x * (4.0 * c[4] + x * (5.0 * c[5]))))
    bend = 2.0 * c[2] + x * (6.0 * c[3] + x * (12.0 * c[4] + x * (20.0 * c[5])))
    return wp.vec3(value, slope, bend)


@func
def piece_at(start: wp.array[float], time: float) -> int:
    """The piece that a time belongs to, the first or last one beyond all; `start` are the times where pieces start."""
    low = wp.int32(0)
    high = start.shape[0]
    while high - low > 1:
        middle = (low + high) / 2
        if start[middle] <= time:
            low = middle
        else:
            high = middle
    return low


@func
def quaternion_rate(p: wp.quat, rate: wp.quat, world: bool) -> wp.quat:
    """p' p^-1 along world axes, or p^-1 p' along those of the turned body, of a quaternion of any length.

    Twice its vector part is the angular velocity of the orientation p/|p|, rad/s.
    """
    inverse = wp.quat_inverse(p) * (1.0 / wp.dot(p, p))
    if world:
        return rate * inverse
    return inverse * rate


@func
def angular_acceleration(p: wp.quat, rate: wp.quat, bend: wp.quat, world: bool) -> wp.vec3:
    """Derivative of the angular velocity, rad/s^2: 2 vec(p'' p^-1 - (p' p^-1)^2), along the same axes."""
    a = quaternion_rate(p, rate, world)
    b = quaternion_rate(p, bend, world)
    return 2.0 * (wp.vec3(b[0], b[1], b[2]) - 2.0 * a[3] * wp.vec3(a[0], a[1], a[2]))


@func
def curve_at(motion: PrescribedMotion, row: int, piece: int, curve: int, x: float) -> wp.vec3:
    """Value and derivatives of a curve, x s after the start of a piece."""
    return polynomial_rates(motion.curve[row, piece, curve], x)


@func
def follow(instance: int, lane: int, lanes: int, time: float, model: ModelRef, state: StateRef):
    """Put kinematic coordinates, their speeds and accelerations to where they are at a time. No barrier."""
    motion = model.motion
    row = wp.min(instance, motion.curve.shape[0] - 1)
    if motion.row.shape[0] > 0:
        row = motion.row[instance]
    piece = piece_at(motion.start, time)
    x = time - motion.start[piece]
    for k in range(lane, motion.angle.shape[0], lanes):
        y = curve_at(motion, row, piece, motion.angle[k, 2], x)
        speed = motion.angle[k, 1]
        state.coordinates[instance, motion.angle[k, 0]] = y[0]
        state.speeds[instance, speed] = y[1]
        state.accelerations[instance, speed] = y[2]
    for k in range(lane, motion.turn.shape[0], lanes):
        p = wp.quat()
        rate = wp.quat()
        bend = wp.quat()
        for i in range(4):
            y = curve_at(motion, row, piece, motion.turn[k, 2] + i, x)
            p[i] = y[0]
            rate[i] = y[1]
            bend[i] = y[2]
        world = motion.turn[k, 3] == 1
        a = quaternion_rate(p, rate, world)
        alpha = angular_acceleration(p, rate, bend, world)
        q = wp.normalize(p)
        speed = motion.turn[k, 1]
        for i in range(4):
            state.coordinates[instance, motion.turn[k, 0] + i] = q[i]
        for i in range(3):
            state.speeds[instance, speed + i] = 2.0 * a[i]
            state.accelerations[instance, speed + i] = alpha[i]


@func
def prescribe_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """Add the prescribed accelerations of joints to the bias of their bodies. No barrier."""
    skeleton = model.skeleton
    for k in range(lane, model.motion.joint.shape[0], lanes):
        body = model.motion.joint[k, 0]
        axes = model.motion.joint[k, 1]
        first = skeleton.plan[body].speed_start
        relative = wp.vec3(0.0)
        if skeleton.plan[body].joint_type == BALL:
            relative = work.rotation[body] * acceleration_vector(state, instance, first)
        else:
            if axes != SECOND_AXIS:
                axis = work.rotation[body] * at(skeleton.row, instance, body).axis_a
                relative += axis * state.accelerations[instance, first]
            if axes != FIRST_AXIS:
                axis = work.rotation[skeleton.plan[body].parent] * at(skeleton.row, instance, body).axis_b
                relative += axis * state.accelerations[instance, first + 1]
        work.bias[body] = work.bias[body] + relative


@func
def prescribed_root(instance: int, planar: bool, state: StateRef) -> wp.spatial_vector:
    """Acceleration of a prescribed root, world: angular, rad/s^2, then linear, m/s^2."""
    a = state.accelerations
    if planar:
        return wp.spatial_vector(a[instance, 2], 0.0, 0.0, 0.0, a[instance, 0], a[instance, 1])
    return wp.spatial_vector(
        a[instance, 3], a[instance, 4], a[instance, 5], a[instance, 0], a[instance, 1], a[instance, 2]
    )
