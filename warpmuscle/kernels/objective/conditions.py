"""Failing conditions of a scene's own: Warp functions that end an instance where they are met."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.objective.causes import CONDITION, cause_of
from warpmuscle.kernels.objective.failure import CONDITION_MET
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef


@func
def no_condition(instance: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """No condition of others is looked at."""


@cache
def failing_stage_of(conditions: tuple[Any, ...]) -> Any:
    """The Warp function (instance, model, state, work) that looks for failing conditions that are met; for one lane.

    Args:
        conditions: Warp functions (instance, model, state, work) -> bool. The first that is met counts.
    """
    every = no_condition
    for index, condition in enumerate(conditions):
        every = _and_condition(every, condition, cause_of(CONDITION, index))
    return every


def _and_condition(others: Any, condition: Any, cause: int) -> Any:
    @wp.func
    def look(instance: int, model: ModelRef, state: StateRef, work: ScratchRef):
        others(instance, model, state, work)
        if work.flags[1] == 0:  # noqa: SIM102, `and` would compute both
            if condition(instance, model, state, work):
                state.cause[instance] = wp.static(cause)
                work.flags[1] = CONDITION_MET

    return look
