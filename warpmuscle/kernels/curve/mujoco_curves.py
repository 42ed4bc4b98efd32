"""MuJoCo's muscles (its documentation, "Muscle actuators"), with their default numbers and with a muscle's own.

Quadratic pieces throughout: an active force between lengths `least` and `most` that is 1 at 1, a passive one above 1
or from where the actuator's bias has it begin, and a multiplier of speed between 0 and its greatest. The tendon is
rigid; Thelen's stands in where one is asked for.
"""

import warp as wp

from warpmuscle.kernels.curve.curve_functions import CurveFunctions
from warpmuscle.kernels.curve.shaped_family import ShapedCurves, ShapedFamily
from warpmuscle.kernels.curve.thelen_curves import scaled_tendon, thelen_tendon
from warpmuscle.kernels.functions import func

LEAST, MOST = 0.5, 1.6  # lmin, lmax
PASSIVE, LENGTHENING = 1.3, 1.2  # fpmax, fvmax
SHORTEST = 1.0e-4  # of l_opt: a fibre shorter than that has no force
NARROW = 1.0e-6  # of l_opt, the least width of a piece


@func
def bump(length: float, least: float, most: float) -> float:
    """Active force: two parabolas on either side of 1, from 0 at `least` over 1 to 0 at `most`."""
    if length <= least or length >= most:
        return 0.0
    end = wp.where(length < 1.0, least, most)
    half = wp.max(0.5 * wp.abs(1.0 - end), NARROW)
    outer = wp.abs(length - end) / half
    inner = wp.abs(length - 1.0) / half
    return wp.where(outer < 1.0, 0.5 * outer * outer, 1.0 - 0.5 * inner * inner)


@func
def passive_between(length: float, least: float, most: float, force: float) -> float:
    """Passive force: a parabola from `least` to half-way to `most`, where it is half of `force`, then straight."""
    x = (length - least) / wp.max(0.5 * (most - least), NARROW)
    return force * wp.where(x <= 0.0, 0.0, wp.where(x <= 1.0, 0.5 * x * x, x - 0.5))


@func
def passive_rise(length: float, most: float, force: float) -> float:
    """Passive force that begins at 1."""
    return passive_between(length, 1.0, most, force)


@func
def speed_multiplier(speed: float, most: float) -> wp.vec2:
    """Force-velocity multiplier and its slope: (1 + v)^2 shortening; up to `most`, where lengthening reaches it."""
    gain = wp.max(most - 1.0, NARROW)
    if speed <= -1.0:
        return wp.vec2(0.0, 0.0)
    if speed <= 0.0:
        return wp.vec2((1.0 + speed) * (1.0 + speed), 2.0 * (1.0 + speed))
    left = wp.max(gain - speed, 0.0)
    return wp.vec2(most - left * left / gain, 2.0 * left / gain)


@func
def mujoco_active(length: float) -> float:
    """Active force with the default numbers."""
    return bump(length, LEAST, MOST)


@func
def mujoco_passive(length: float) -> float:
    """Passive force with the default numbers."""
    return passive_rise(length, MOST, PASSIVE)


@func
def mujoco_velocity(speed: float, activation: float) -> wp.vec2:
    """Multiplier and slope with the default numbers."""
    return speed_multiplier(speed, LENGTHENING)


CURVES = CurveFunctions(mujoco_active, mujoco_passive, mujoco_velocity, thelen_tendon)


# With numbers of a muscle's own.


@func
def shaped_active(curves: ShapedCurves, length: float) -> float:
    """Active force between lengths of a muscle's own."""
    return bump(length, curves.row.shortest, curves.row.active_width)


@func
def shaped_passive(curves: ShapedCurves, length: float) -> float:
    """Passive force of a muscle's own."""
    return passive_between(length, curves.row.passive_floor, curves.row.passive_rate, curves.row.passive_scale)


@func
def shaped_velocity(curves: ShapedCurves, speed: float, activation: float) -> wp.vec2:
    """Multiplier of a muscle's own."""
    return speed_multiplier(speed, curves.row.lengthening_force)


@func
def shaped_tendon(curves: ShapedCurves, x: float) -> wp.vec2:
    """Thelen's tendon."""
    return scaled_tendon(x)


FAMILY = ShapedFamily(shaped_active, shaped_passive, shaped_velocity, shaped_tendon, SHORTEST)
