"""Contact as the original program has it: a soft constraint on the velocity after the step, with restitution.

A point at depth d that moves along the normal at v is to leave at

    c = max(min(p (d - d_0)/h, 1 m/s), e (-v))        with h the time step, the second of approaching points only

and pushes with f = (c - v')/s, where v' = v + h a is its velocity after the step, p the penalty (ODE's ERP), s the
softness (ODE's CFM), d_0 = 1 mm a depth without a push, and e the restitution (Smith 2006, Open Dynamics Engine v0.5,
sections 3.7 and 7.3). That is the force f0 - K a of `contact.py` with K = h/s. Which points push, and how much friction
they bear, is decided at the start of the step; the original solves for both.
"""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import SoftConstraint

FREE_DEPTH = 0.001  # m, that is not pushed out
FASTEST = 1.0  # m/s, at which depth is pushed out
SLOWEST = 1.0e-5  # m/s, of a point that bounces


@func
def leaving_speed(depth: float, speed: float, penalty: float, restitution: float, time_step: float) -> float:
    """Speed along the normal, m/s, that a point is to have after the step.

    Args:
        depth: penetration, m, positive inside the ground. speed: of the point along the normal, m/s.
    """
    pushed_out = wp.min(penalty / time_step * wp.max(depth - FREE_DEPTH, 0.0), FASTEST)
    if -speed > SLOWEST:
        return wp.max(pushed_out, -restitution * speed)
    return pushed_out


@func
def constraint_force(depth: float, speed: float, soft: SoftConstraint, time_step: float) -> float:
    """Force of a contact along the normal at the start of a step, N; it pushes where it is positive."""
    return (leaving_speed(depth, speed, soft.penalty, soft.restitution, time_step) - speed) / soft.softness
