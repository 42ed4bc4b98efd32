"""The spring and damper of a contact of an object, over a step.

The force is f = k d - c v' at depth d, with c = 2 zeta sqrt(k m) and m what the contact feels of the masses: the
speed v' is that after the step, and elasticity is as by Newmark's method with beta = 1/4, so that no stiffness is
unstable and none loses energy (Newmark 1959). The contact never pulls, so that a restitution follows from zeta as in
Schwager and Poeschel 2007, eq. 21, whatever the speed is.
"""

import warp as wp

from warpmuscle.kernels.functions import func

BETA = 0.25  # of Newmark's method
FIRM = 0.5  # of a step's change of speed, up to which a force need not give way


@wp.struct
class Bounce:
    """A force along a normal at the start of a step, and what it gives way."""

    along: float  # N
    gives: float  # kg: by so much less for a unit of acceleration


@func
def bounce(depth: float, speed: float, stiffness: float, ratio: float, mobility: float, time_step: float) -> Bounce:
    """The force of a contact, N, never negative.

    Args:
        depth: m. speed: with which it becomes less, m/s. ratio: zeta. mobility: of both sides, 1/kg.
    """
    b = Bounce()
    damping = 2.0 * ratio * wp.sqrt(stiffness / wp.max(mobility, 1.0e-12))
    b.along = wp.max(stiffness * depth - damping * speed, 0.0)
    b.gives = time_step * (damping + BETA * time_step * stiffness)
    return b


@func
def eased(force: float, gives: float, mobility: float) -> float:
    """A force between an object and a body over a step, N, that was `force` at its start.

    With K w, of what the force gives and both mobilities, beyond 1/2, it is less by the rest of K w, as if it were
    implicit and nothing else acted: so no stiffness is unstable. Below that it is what it was, and bears weights at
    the depth of its spring.
    """
    return force / (1.0 + wp.max(gives * mobility - FIRM, 0.0))
