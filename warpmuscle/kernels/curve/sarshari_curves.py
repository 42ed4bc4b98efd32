"""Sarshari 2018 (thesis, EPFL), as the CusToM toolbox (Muller 2019) has them, on Thelen's tendon.

A bell of width 0.0955, and a force-velocity curve that is 0.955 at rest.
"""

import warp as wp

from warpmuscle.kernels.curve.curve_functions import CurveFunctions, gaussian_active
from warpmuscle.kernels.curve.thelen_curves import thelen_tendon
from warpmuscle.kernels.functions import func


@func
def sarshari_active(length: float) -> float:
    """Active force (Sarshari 2018)."""
    return gaussian_active(length, 0.0955)


@func
def sarshari_passive(length: float) -> float:
    """0.067 exp(3.832 (l - 1)) + 0.00378 (Sarshari 2018)."""
    return 0.067 * wp.exp(3.832 * (length - 1.0)) + 0.00378


@func
def sarshari_velocity(speed: float, activation: float) -> wp.vec2:
    """1.9108/(1 + exp(-4.994 v)), and its slope: positive at any speed (Sarshari 2018)."""
    fade = wp.exp(-4.994 * speed)
    part = 1.0 / (1.0 + fade)
    return wp.vec2(1.9108 * part, wp.static(1.9108 * 4.994) * fade * part * part)


CURVES = CurveFunctions(sarshari_active, sarshari_passive, sarshari_velocity, thelen_tendon)
