"""A curriculum: ground is rougher after an episode that did not fail, and smoother after one that did."""

import warp as wp

from warpmuscle.kernels.learning.decision import Decision
from warpmuscle.kernels.objective.declaration import Declaration
from warpmuscle.kernels.structs import Model, Scratch, State


@wp.func
def _by_success(instance: int, model: Model, state: State, work: Scratch, decision: Decision) -> float:
    """Difficulty of the next episode, from which the share of the variants follows that it is drawn from."""
    return decision.difficulty[instance] + wp.where(decision.failed[instance], -0.05, 0.05)


by_success = Declaration(function=_by_success, stage="decision")
