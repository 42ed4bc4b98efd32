"""A custom term of the objective."""

import warp as wp

from warpmuscle.kernels.structs import Model, Scratch, State


@wp.func
def sway(instance: int, model: Model, state: State, work: Scratch) -> float:
    """Squared sideways velocity of the centre of mass, which a step adds up over time."""
    return work.center[1][0] * work.center[1][0]
