"""Thelen's with a force-velocity curve that does not depend on the activation.

(1 + v)/(1 - 4 v) shortening, (1 + 35 v)/(1 + 25 v) lengthening (Thelen 2003, eq. 6 and 7 at full activation, solved for
the force).
"""

import warp as wp

from warpmuscle.kernels.curve.curve_functions import CurveFunctions, hyperbolic_velocity
from warpmuscle.kernels.curve.thelen_curves import thelen_active, thelen_passive, thelen_tendon
from warpmuscle.kernels.functions import func


@func
def explicit_velocity(speed: float, activation: float) -> wp.vec2:
    """Force-velocity multiplier and its slope; negative for faster shortening than at v_max."""
    return hyperbolic_velocity(speed, 0.25, 1.4)


CURVES = CurveFunctions(thelen_active, thelen_passive, explicit_velocity, thelen_tendon)
