"""De Groote 2016 with the constants of OpenSim 4.6, and with numbers of a muscle's own.

OpenSim corrected the constants so that f_l(1) = f_v(0) = 1, f_v(-1) = 0, and the tendon is slack at strain 0.
"""

import math

import warp as wp

from warpmuscle.kernels.curve.curve_functions import PASSIVE_STRAIN, CurveFunctions
from warpmuscle.kernels.curve.shaped_family import ShapedCurves, ShapedFamily, exponential
from warpmuscle.kernels.functions import func

GROOTE_FLOOR = math.exp(4.0 * (0.2 - 1.0) / PASSIVE_STRAIN)  # passive force is zero at length 0.2
GROOTE_STEEPNESS = math.log((1.0 + 0.2) / 0.2) / 0.049  # of the tendon: force 1 at strain 0.049


@func
def groote_active(length: float) -> float:
    """Sum of three bells b1 exp(-(l - b2)^2/2 (b3 + b4 l)^2) (De Groote 2016, supplement)."""
    x = (length - 1.054348561163096) / (0.16194288662761705 + 0.06381565266097716 * length)
    width = wp.max(-0.029060905806803296 + 0.19835014521987723 * length, 1.0e-3)
    y = (length - 0.7163004817144202) / width
    z = (length - 1.0) / 0.3535533905932738
    low = 0.43130780147182907 * wp.exp(-0.5 * y * y)
    return 0.8174335195120225 * wp.exp(-0.5 * x * x) + low + 0.1 * wp.exp(-0.5 * z * z)


@func
def groote_passive(length: float) -> float:
    """(exp(4 (l - 1)/0.6) - c)/(exp 4 - c), c so that it is zero at l = 0.2 (De Groote 2016, supplement)."""
    rise = wp.exp(4.0 * (length - 1.0) / PASSIVE_STRAIN) - GROOTE_FLOOR
    return wp.max(rise, 0.0) / wp.static(math.exp(4.0) - GROOTE_FLOOR)


@func
def groote_velocity(speed: float, activation: float) -> wp.vec2:
    """d1 asinh(d2 v + d3) + d4 and its slope (De Groote 2016, supplement)."""
    x = -8.149 * speed - 0.374
    root = wp.sqrt(x * x + 1.0)
    arsinh = wp.sign(x) * wp.log(wp.abs(x) + root)
    return wp.vec2(-0.3211346127989808 * arsinh + 0.8825327733249912, 0.3211346127989808 * 8.149 / root)


@func
def groote_tendon(strain: float) -> wp.vec2:
    """0.2 (exp(k strain) - 1), and its slope; none when slack (De Groote 2016, supplement)."""
    if strain <= 0.0:
        return wp.vec2(0.0, 0.0)
    growth = 0.2 * wp.exp(GROOTE_STEEPNESS * wp.min(strain, 0.2))
    return wp.vec2(growth - 0.2, GROOTE_STEEPNESS * growth)


CURVES = CurveFunctions(groote_active, groote_passive, groote_velocity, groote_tendon)


# With numbers of a muscle's own.


@func
def fregly_active(length: float) -> float:
    """De Groote's active force with the constants of OpenSim 4.6, up to 5e-4 from those of `groote_active`."""
    x = (length - 1.055033428970575) / (0.162384573599574 + 0.063303448465465 * length)
    y = (length - 0.716775413397760) / wp.max(-0.029947116970696 + 0.200356847296188 * length, 1.0e-3)
    z = (length - 1.0) / 0.353553390593274
    low = 0.433004984392647 * wp.exp(-0.5 * y * y) + 0.1 * wp.exp(-0.5 * z * z)
    return 0.8150671134243542 * wp.exp(-0.5 * x * x) + low


@func
def shaped_active(curves: ShapedCurves, length: float) -> float:
    """Active force whose widths are scaled."""
    return fregly_active((length - 1.0) * curves.row.active_width + 1.0)


@func
def shaped_velocity(curves: ShapedCurves, speed: float, activation: float) -> wp.vec2:
    """The multiplier has no numbers of a muscle's own."""
    return groote_velocity(speed, activation)


@func
def shaped_tendon(curves: ShapedCurves, x: float) -> wp.vec2:
    """De Groote's tendon force 0.2 (6^x - 1) and its slope, at a strain over that at f_max; none when slack."""
    if x <= 0.0:
        return wp.vec2(0.0, 0.0)
    rate = wp.static(math.log(6.0))
    growth = 0.2 * wp.exp(rate * wp.min(x, 4.0))
    return wp.vec2(growth - 0.2, rate * growth)


FAMILY = ShapedFamily(shaped_active, exponential, shaped_velocity, shaped_tendon)
