"""Normalised curves of Hill-type muscles: active and passive force-length, force-velocity, tendon force-strain.

Forces are over f_max, fibre lengths over l_opt, speeds over v_max and positive when lengthening, tendon strains
l_tendon/l_slack - 1. `model` is the number of one of `curve_sets.CURVES`.
"""

import math

import warp as wp

from warpmuscle.kernels.curve_sets import DE_GROOTE, LEE, MILLARD, SARSHARI, THELEN, THELEN_EXPLICIT
from warpmuscle.kernels.millard import millard_active, millard_passive, millard_tendon, millard_velocity

PASSIVE_STRAIN = 0.6  # at f_max: LEE, THELEN and DE_GROOTE
GROOTE_FLOOR = math.exp(4.0 * (0.2 - 1.0) / PASSIVE_STRAIN)  # passive force is zero at length 0.2
GROOTE_STEEPNESS = math.log((1.0 + 0.2) / 0.2) / 0.049  # of the tendon: force 1 at strain 0.049
TOE_STRAIN = 0.04 * 0.99 * math.exp(3.0) / (1.66 * math.exp(3.0) - 0.67)  # Thelen's tendon, 0.04 at f_max


@wp.func
def gaussian_active(length: float, shape: float) -> float:
    """exp(-(l - 1)^2/shape) (Bergmann 2017, eq. 4, shape 0.5; Thelen 2003, eq. 4, shape 0.45)."""
    return wp.exp((length - 1.0) * (length - 1.0) * (-1.0 / shape))


@wp.func
def groote_active(length: float) -> float:
    """Sum of three bells b1 exp(-(l - b2)^2/2 (b3 + b4 l)^2) (De Groote 2016, supplement)."""
    x = (length - 1.054348561163096) / (0.16194288662761705 + 0.06381565266097716 * length)
    width = wp.max(-0.029060905806803296 + 0.19835014521987723 * length, 1.0e-3)
    y = (length - 0.7163004817144202) / width
    z = (length - 1.0) / 0.3535533905932738
    low = 0.43130780147182907 * wp.exp(-0.5 * y * y)
    return 0.8174335195120225 * wp.exp(-0.5 * x * x) + low + 0.1 * wp.exp(-0.5 * z * z)


@wp.func
def exponential_passive(length: float, rate: float, scale: float) -> float:
    """(exp(k (l - 1)/0.6) - 1)/(exp k - 1) beyond l = 1 (Bergmann 2017, eq. 6, k = 4; Thelen 2003, eq. 3, k = 5).

    Args:
        rate: k/0.6. scale: 1/(exp k - 1).
    """
    if length <= 1.0:
        return 0.0
    return (wp.exp(rate * (length - 1.0)) - 1.0) * scale


@wp.func
def lee_passive(length: float) -> float:
    """Passive force of Bergmann 2017, eq. 6."""
    return exponential_passive(length, wp.static(4.0 / PASSIVE_STRAIN), wp.static(1.0 / (math.exp(4.0) - 1.0)))


@wp.func
def thelen_passive(length: float) -> float:
    """Passive force of Thelen 2003, eq. 3."""
    return exponential_passive(length, wp.static(5.0 / PASSIVE_STRAIN), wp.static(1.0 / (math.exp(5.0) - 1.0)))


@wp.func
def groote_passive(length: float) -> float:
    """(exp(4 (l - 1)/0.6) - c)/(exp 4 - c), c so that it is zero at l = 0.2 (De Groote 2016, supplement)."""
    rise = wp.exp(4.0 * (length - 1.0) / PASSIVE_STRAIN) - GROOTE_FLOOR
    return wp.max(rise, 0.0) / wp.static(math.exp(4.0) - GROOTE_FLOOR)


@wp.func
def hyperbolic_velocity(speed: float, shape: float, longest: float) -> wp.vec2:
    """Force-velocity multiplier of two hyperbolas, and its slope (Bergmann 2017, eq. 5; Thelen 2003, eq. 6 and 7).

    Args:
        shape: A_f of the sources. longest: multiplier at infinite lengthening speed.
    """
    if speed <= 0.0:
        part = 1.0 / (1.0 - speed * (1.0 / shape))
        return wp.vec2((speed + 1.0) * part, (1.0 + 1.0 / shape) * part * part)
    scale = (2.0 + 2.0 / shape) / (longest - 1.0)
    part = 1.0 / (1.0 + scale * speed)
    return wp.vec2((1.0 + longest * scale * speed) * part, scale * (longest - 1.0) * part * part)


@wp.func
def thelen_velocity(speed: float) -> wp.vec2:
    """Thelen's hyperbolas, straight beyond multipliers 0 and 0.95 * 1.4, as OpenSim continues them; and the slope."""
    inside = wp.clamp(speed, -1.0, wp.static(0.33 * 0.4 / (10.0 * 0.07)))
    edge = hyperbolic_velocity(inside, 0.25, 1.4)
    return wp.vec2(edge[0] + edge[1] * (speed - inside), edge[1])


@wp.func
def groote_velocity(speed: float) -> wp.vec2:
    """d1 asinh(d2 v + d3) + d4 and its slope (De Groote 2016, supplement)."""
    x = -8.149 * speed - 0.374
    root = wp.sqrt(x * x + 1.0)
    arsinh = wp.sign(x) * wp.log(wp.abs(x) + root)
    return wp.vec2(-0.3211346127989808 * arsinh + 0.8825327733249912, 0.3211346127989808 * 8.149 / root)


@wp.func
def sarshari_passive(length: float) -> float:
    """0.067 exp(3.832 (l - 1)) + 0.00378 (Sarshari 2018)."""
    return 0.067 * wp.exp(3.832 * (length - 1.0)) + 0.00378


@wp.func
def sarshari_velocity(speed: float) -> wp.vec2:
    """1.9108/(1 + exp(-4.994 v)), and its slope (Sarshari 2018)."""
    fade = wp.exp(-4.994 * speed)
    part = 1.0 / (1.0 + fade)
    return wp.vec2(1.9108 * part, wp.static(1.9108 * 4.994) * fade * part * part)


@wp.func
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


@wp.func
def groote_tendon(strain: float) -> wp.vec2:
    """0.2 (exp(k strain) - 1), and its slope; none when slack (De Groote 2016, supplement)."""
    if strain <= 0.0:
        return wp.vec2(0.0, 0.0)
    growth = 0.2 * wp.exp(GROOTE_STEEPNESS * wp.min(strain, 0.2))
    return wp.vec2(growth - 0.2, GROOTE_STEEPNESS * growth)


@wp.func
def active_force_length(model: int, length: float) -> float:
    """Active isometric force at full activation."""
    if model == MILLARD:
        return millard_active(length)
    if model == DE_GROOTE:
        return groote_active(length)
    if model == SARSHARI:
        return gaussian_active(length, 0.0955)
    return gaussian_active(length, wp.where(model == LEE, 0.5, 0.45))


@wp.func
def passive_force_length(model: int, length: float) -> float:
    """Force of the passive fibre; unbounded."""
    if model == MILLARD:
        return millard_passive(length)
    if model == DE_GROOTE:
        return groote_passive(length)
    if model == THELEN or model == THELEN_EXPLICIT:  # noqa: SIM109, device code
        return thelen_passive(length)
    if model == SARSHARI:
        return sarshari_passive(length)
    return lee_passive(length)


@wp.func
def force_velocity_slope(model: int, speed: float, activation: float) -> wp.vec2:
    """Force-velocity multiplier and its derivative by speed.

    Args:
        activation: used by THELEN only, where a fibre shortens at most at 0.25 + 0.75 a. There and with LEE,
            THELEN_EXPLICIT and DE_GROOTE the multiplier is negative for faster shortening, with MILLARD it stays zero,
            and with SARSHARI it is positive at any speed.
    """
    if model == MILLARD:
        return millard_velocity(speed)
    if model == DE_GROOTE:
        return groote_velocity(speed)
    if model == THELEN:
        scale = 1.0 / (0.25 + 0.75 * activation)
        scaled = thelen_velocity(speed * scale)
        return wp.vec2(scaled[0], scaled[1] * scale)
    if model == THELEN_EXPLICIT:
        return hyperbolic_velocity(speed, 0.25, 1.4)
    if model == SARSHARI:
        return sarshari_velocity(speed)
    return hyperbolic_velocity(speed, 0.3, 1.8)


@wp.func
def force_velocity(model: int, speed: float, activation: float) -> float:
    """Force-velocity multiplier, see `force_velocity_slope`."""
    return force_velocity_slope(model, speed, activation)[0]


@wp.func
def tendon_force_slope(model: int, strain: float) -> wp.vec2:
    """Force of the tendon and its derivative by strain; zero when slack."""
    if model == MILLARD:
        return millard_tendon(strain)
    if model == DE_GROOTE:
        return groote_tendon(strain)
    return thelen_tendon(strain)


@wp.func
def tendon_force_strain(model: int, strain: float) -> float:
    """Force of the tendon at a strain."""
    return tendon_force_slope(model, strain)[0]
