"""Thelen 2003 with the constants of OpenSim 4.6, and with numbers of a muscle's own."""

import math

import warp as wp

from warpmuscle.kernels.curve.curve_functions import (
    PASSIVE_STRAIN,
    CurveFunctions,
    exponential_passive,
    gaussian_active,
    hyperbolic_velocity,
)
from warpmuscle.kernels.curve.shaped_family import ShapedCurves, ShapedFamily, exponential
from warpmuscle.kernels.functions import func

TOE = 0.99 * math.exp(3.0) / (1.66 * math.exp(3.0) - 0.67)  # strain where the tendon becomes straight, over f_max's
TOE_STRAIN = 0.04 * 0.99 * math.exp(3.0) / (1.66 * math.exp(3.0) - 0.67)  # the same where that is 0.04
FOOT = 0.33 / (math.exp(3.0) - 1.0)  # scale of the tendon below that
SHORTEST = 1.0e-4  # of l_opt: OpenSim's Thelen fibres may shorten to nothing, but for their pennation


@func
def thelen_active(length: float) -> float:
    """Active force of Thelen 2003, eq. 4."""
    return gaussian_active(length, 0.45)


@func
def thelen_passive(length: float) -> float:
    """Passive force of Thelen 2003, eq. 3."""
    return exponential_passive(length, wp.static(5.0 / PASSIVE_STRAIN), wp.static(1.0 / (math.exp(5.0) - 1.0)))


@func
def continued_velocity(speed: float) -> wp.vec2:
    """Thelen's hyperbolas, straight beyond multipliers 0 and 0.95 * 1.4, as OpenSim continues them; and the slope."""
    inside = wp.clamp(speed, -1.0, wp.static(0.33 * 0.4 / (10.0 * 0.07)))
    edge = hyperbolic_velocity(inside, 0.25, 1.4)
    return wp.vec2(edge[0] + edge[1] * (speed - inside), edge[1])


@func
def thelen_velocity(speed: float, activation: float) -> wp.vec2:
    """Force-velocity multiplier and its slope, of a fibre that shortens at most at 0.25 + 0.75 a of v_max."""
    scale = 1.0 / (0.25 + 0.75 * activation)
    scaled = continued_velocity(speed * scale)
    return wp.vec2(scaled[0], scaled[1] * scale)


@func
def thelen_tendon(strain: float) -> wp.vec2:
    """Tendon force, exponential up to 0.33, then straight, and its slope (Thelen 2003, eq. 5)."""
    if strain > TOE_STRAIN:
        slope = wp.static(0.67 / (0.04 - TOE_STRAIN))
        return wp.vec2(0.33 + slope * (strain - TOE_STRAIN), slope)
    if strain <= 0.0:
        return wp.vec2(0.0, 0.0)
    scale = wp.static(0.33 / (math.exp(3.0) - 1.0))
    growth = wp.exp(strain * wp.static(3.0 / TOE_STRAIN))
    return wp.vec2(scale * (growth - 1.0), scale * growth * wp.static(3.0 / TOE_STRAIN))


CURVES = CurveFunctions(thelen_active, thelen_passive, thelen_velocity, thelen_tendon)


# With numbers of a muscle's own.


@func
def shaped_active(curves: ShapedCurves, length: float) -> float:
    """Thelen's bell of a width."""
    return gaussian_active(length, curves.row.active_width)


@func
def shaped_velocity(curves: ShapedCurves, speed: float, activation: float) -> wp.vec2:
    """Thelen's hyperbolas, straight beyond multipliers 0 and straight_from lengthening_force; and the slope."""
    row = curves.row
    scale = 1.0 / (0.25 + 0.75 * activation)
    v = speed * scale
    inside = wp.clamp(v, -1.0, row.straight_speed)
    edge = hyperbolic_velocity(inside, row.velocity_shape, row.lengthening_force)
    return wp.vec2(edge[0] + edge[1] * (v - inside), edge[1] * scale)


@func
def scaled_tendon(x: float) -> wp.vec2:
    """Thelen's tendon force and its slope, at a strain over that at f_max."""
    if x > TOE:
        slope = wp.static(0.67 / (1.0 - TOE))
        return wp.vec2(0.33 + slope * (x - TOE), slope)
    if x <= 0.0:
        return wp.vec2(0.0, 0.0)
    growth = wp.exp(x * wp.static(3.0 / TOE)) * FOOT
    return wp.vec2(growth - FOOT, growth * wp.static(3.0 / TOE))


@func
def shaped_tendon(curves: ShapedCurves, x: float) -> wp.vec2:
    """Thelen's tendon, see `scaled_tendon`."""
    return scaled_tendon(x)


FAMILY = ShapedFamily(shaped_active, exponential, shaped_velocity, shaped_tendon, SHORTEST)
