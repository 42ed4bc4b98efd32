"""Lee 2014 as in Bergmann 2017, eq. 4-6; that source treats the tendon as rigid: Thelen's curve stands in."""

import math

import warp as wp

from warpmuscle.kernels.curve.curve_functions import (
    PASSIVE_STRAIN,
    CurveFunctions,
    exponential_passive,
    gaussian_active,
    hyperbolic_velocity,
)
from warpmuscle.kernels.curve.thelen_curves import thelen_tendon
from warpmuscle.kernels.functions import func


@func
def lee_active(length: float) -> float:
    """Active force of Bergmann 2017, eq. 4."""
    return gaussian_active(length, 0.5)


@func
def lee_passive(length: float) -> float:
    """Passive force of Bergmann 2017, eq. 6."""
    return exponential_passive(length, wp.static(4.0 / PASSIVE_STRAIN), wp.static(1.0 / (math.exp(4.0) - 1.0)))


@func
def lee_velocity(speed: float, activation: float) -> wp.vec2:
    """Force-velocity multiplier of Bergmann 2017, eq. 5; negative for faster shortening than at v_max."""
    return hyperbolic_velocity(speed, 0.3, 1.8)


CURVES = CurveFunctions(lee_active, lee_passive, lee_velocity, thelen_tendon)
