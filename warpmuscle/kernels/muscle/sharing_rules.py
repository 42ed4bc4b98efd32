"""The arithmetic of sharing torques out: shares of muscles, and prices of joints; see `sharing.py`.

A share is x, and carries its sign: positive while the muscle is free to do more or less.
"""

import warp as wp

from warpmuscle.kernels.algebra.spatial import symmetric
from warpmuscle.kernels.functions import func

RELAXATION = 1.2  # of a step of Newton's method
MARGIN = 0.05  # of full activation, within which a muscle at a bound counts as if it were not
NEAR = 0.02  # activation up to which a muscle that shortens fast is activated before it pulls
SMALLEST = 1.0e-12  # share of a muscle that is free to change


@func
def share_of(bid: float, most: float) -> float:
    """Share of a muscle to which its joints bid sum g . v, at most sqrt(m); negative where it is at a bound."""
    share = wp.clamp(bid, 0.0, most)
    beyond = wp.abs(bid - share) - MARGIN * most  # no branch, which the CPU would not foresee
    return wp.where(beyond < 0.0, wp.max(share, SMALLEST), -share)


@func
def activation_of(part: float, idle: float) -> float:
    """Activation with which a muscle has so much of its active force, 0..1; none for none."""
    return (1.0 - idle) * part + idle * wp.min(part * wp.static(1.0 / NEAR), 1.0)


@func
def symmetric_solution(s: symmetric, v: wp.vec3) -> wp.vec3:
    """S^-1 v by elimination, exact enough also where S is nearly singular, as of hinges, which cofactors are not."""
    p = 1.0 / s[0]
    a = s[1] * p
    b = s[2] * p
    q = 1.0 / (s[3] - a * s[1])
    below = s[4] - a * s[2]
    c = below * q
    y = v[1] - a * v[0]
    z = (v[2] - b * v[0] - c * y) / (s[5] - b * s[2] - c * below)
    y = y * q - c * z
    return wp.vec3(v[0] * p - a * y - b * z, y, z)


@func
def newton_step(inertia: symmetric, residual: wp.vec3, soft: float) -> wp.vec3:
    """Change of a price: (sum of w g g^T + s 1)^-1 residual, relaxed."""
    return symmetric_solution(inertia + symmetric(soft, 0.0, 0.0, soft, 0.0, soft), residual) * RELAXATION


@func
def within_length(v: wp.vec3, most: float) -> wp.vec3:
    """The vector, shortened to a length if it is longer."""
    length = wp.length(v)
    return v * wp.where(length > most, most / wp.max(length, SMALLEST), 1.0)
