"""Curves of the muscle_force_m2012fast of Hyfydy: polynomials near those of Millard 2013 (Hyfydy User Manual 1.0.2).

Speeds and lengths as in `curves.py`. The manual prints the first passive coefficient twice; the second here is the one
that keeps the curve near Millard's. Active force is 0 outside of the roots of its cubic, 0.469 and 1.805 l_opt.
"""

import warp as wp

from warpmuscle.kernels.curve.curve_functions import CurveFunctions
from warpmuscle.kernels.functions import func

SHORTEST_ACTIVE, LONGEST_ACTIVE = 0.46899, 1.80528  # l_opt


@func
def hyfydy_active(length: float) -> float:
    """1.5 (l - 1)^3 - 2.75 (l - 1)^2 + 1 between its roots."""
    if length <= SHORTEST_ACTIVE or length >= LONGEST_ACTIVE:
        return 0.0
    x = length - 1.0
    return x * x * (1.5 * x - 2.75) + 1.0


@func
def hyfydy_passive(length: float) -> float:
    """1.08027 (l - 1)^3 + 1.27368 (l - 1)^2 beyond l = 1."""
    x = wp.max(length - 1.0, 0.0)
    return x * x * (1.08027 * x + 1.27368)


@func
def hyfydy_velocity(speed: float, activation: float) -> wp.vec2:
    """Two hyperbolas, c (v + 1)/(c - v) with c = 0.227 and (b + 1.6 v)/(b + v) with b = 0.11; 0 beyond v = -1."""
    if speed <= -1.0:
        return wp.vec2(0.0, 0.0)
    if speed < 0.0:
        part = 1.0 / (0.227 - speed)
        return wp.vec2(0.227 * (speed + 1.0) * part, 0.278529 * part * part)  # 0.227 times 1.227
    part = 1.0 / (0.11 + speed)
    return wp.vec2((0.11 + 1.6 * speed) * part, 0.066 * part * part)  # 0.6 times 0.11


@func
def hyfydy_tendon(strain: float) -> wp.vec2:
    """260.972 e^2 + 7.9706 e, and its slope; none when slack."""
    if strain <= 0.0:
        return wp.vec2(0.0, 0.0)
    return wp.vec2(strain * (260.972 * strain + 7.9706), 521.944 * strain + 7.9706)


CURVES = CurveFunctions(hyfydy_active, hyfydy_passive, hyfydy_velocity, hyfydy_tendon)
