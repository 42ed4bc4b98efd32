"""Equations of SIMBICON and of its PD control on plain values (Yin, Loken, van de Panne 2007)."""

import warp as wp

from warpmuscle.kernels.algebra.spline import curve_value
from warpmuscle.kernels.body.joint import hinge_rotation
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import REVERSE, SAME, Simbicon, at

LARGEST_TARGET = wp.constant(1000.0)  # rad; beyond it single precision has no good sine, and the instance diverges


@func
def balance_feedback(distance: wp.vec3, velocity: wp.vec3, axis: wp.vec3, gain: wp.vec2, limits: wp.vec4) -> float:
    """Linear balance feedback, rad: cd clamp(d . axis) + cv clamp(v . axis) (Yin 2007, eq. 1).

    Args:
        distance: d, from the stance foot to the centre of mass, character frame, m.
        velocity: v of the centre of mass, character frame, m/s.
        gain: cd, cv. limits: lowest and highest d . axis, then v . axis.
    """
    d = wp.clamp(wp.dot(distance, axis), limits[0], limits[1])
    v = wp.clamp(wp.dot(velocity, axis), limits[2], limits[3])
    return gain[0] * d + gain[1] * v


@func
def pd_torque(
    error: wp.vec3, velocity: wp.vec3, kp: float, kd: float, strength: float, scale: wp.vec3, limit: float
) -> wp.vec3:
    """PD torque along the child's axes, N m, as it acts on the parent: scale strength (-kp e + kd w), then clamped.

    Args:
        error: see `pd_error`. velocity: angular velocity towards which the error is measured, child axes, rad/s.
        scale: factor by axis on torque and limit. limit: largest torque, N m.
    """
    return clamp_torque(wp.cw_mul(scale, (kd * velocity - kp * error) * strength), torque_bound(scale, limit))


@func
def torque_bound(scale: wp.vec3, limit: float) -> wp.vec3:
    """Largest torque by child axis, N m."""
    return wp.vec3(wp.abs(scale[0]), wp.abs(scale[1]), wp.abs(scale[2])) * limit


@func
def clamp_torque(torque: wp.vec3, bound: wp.vec3) -> wp.vec3:
    """Every component within its own bound."""
    return wp.vec3(
        wp.clamp(torque[0], -bound[0], bound[0]),
        wp.clamp(torque[1], -bound[1], bound[1]),
        wp.clamp(torque[2], -bound[2], bound[2]),
    )


@func
def hip_damping(relative_yaw_rate: float, damping: float, largest: float) -> float:
    """Yaw torque of the stance hip, N m: -k w |w|, w the root's yaw rate relative to the thigh within +-largest."""
    w = wp.clamp(relative_yaw_rate, -largest, largest)
    return -damping * w * wp.abs(w)


@func
def stance_share(stance_force: float, swing_force: float) -> float:
    """Part of the root's torque that the stance hip takes, by vertical foot forces; -1 if neither foot is loaded."""
    total = stance_force + swing_force
    if wp.abs(total) < 1.0e-10:
        return -1.0
    return stance_force / total


@func
def strength_by_height(height: float) -> float:
    """Factor on all torques that lets a fallen character go limp: 1 above 0.4 m, 0 below 0.2 m."""
    return wp.clamp((height - 0.2) / 0.2, 0.0, 1.0)


@func
def transition_due(phase: float, longest: float, on_foot_down: int, swing_force: float) -> bool:
    """Whether a state ends: at its longest phase, or after phase 0.5 when the swing foot carries more than 20 N."""
    return phase >= longest or (on_foot_down == 1 and phase > 0.5 and wp.abs(swing_force) > 20.0)


@func
def stance_after(stance: int, rule: int) -> int:
    """Stance after entering a state with this rule."""
    if rule == REVERSE:
        return 1 - stance
    if rule == SAME:
        return stance
    return rule


@func
def component_rotation(
    simbicon: Simbicon, instance: int, c: int, phase: float, stance: int, distance: wp.vec3, velocity: wp.vec3
) -> wp.quat:
    """Rotation of component c: its base angle, reversed in one stance if it says so, plus balance feedback."""
    plan = simbicon.components[c]
    row = at(simbicon.component_rows, instance, c)
    angle = curve_value(simbicon.knots, instance, plan.first_knot, plan.end_knot, phase)
    if plan.reverse == stance:
        angle = -angle
    if plan.has_feedback == 1:
        angle += balance_feedback(distance, velocity, row.feedback_axis, row.feedback_gain, row.feedback_limits)
    return hinge_rotation(row.axis, wp.where(wp.abs(angle) <= LARGEST_TARGET, angle, wp.nan))


@func
def pd_inertia(kp: float, kd: float, strength: float, scale: wp.vec3, time_step: float) -> wp.vec3:
    """What a PD controller that is linearised over the step adds to the joint's inertia, by child axis, kg m^2.

    With the velocity after the step in the damper and the angle after the step in the spring: h (kd + h kp).
    """
    return scale * (strength * time_step * (kd + time_step * kp))


@func
def unless_clamped(inertia: wp.vec3, torque: wp.vec3, bound: wp.vec3) -> wp.vec3:
    """The implicit inertia, but none about axes whose torque is at its limit and so does not depend on velocity."""
    return wp.vec3(
        wp.where(wp.abs(torque[0]) < bound[0], inertia[0], 0.0),
        wp.where(wp.abs(torque[1]) < bound[1], inertia[1], 0.0),
        wp.where(wp.abs(torque[2]) < bound[2], inertia[2], 0.0),
    )
