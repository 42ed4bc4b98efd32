"""Failing conditions of a scene's own: the first that is met ends an instance, unless it has ended before."""

import numpy as np
import warp as wp

from warpmuscle.kernels.objective.causes import CONDITION, ENTRY, FORCE
from warpmuscle.kernels.objective.conditions import failing_stage_of
from warpmuscle.kernels.objective.failure import CONDITION_MET
from warpmuscle.kernels.structs import Model, ModelRef, Scratch, ScratchRef, State, StateRef


@wp.func
def late(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> bool:
    return state.step[instance] > 3


@wp.func
def early(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> bool:
    return state.step[instance] > 1


look, look_nowhere = failing_stage_of((late, early)), failing_stage_of(())


@wp.kernel(enable_backward=False)
def looked(model: Model, state: State, flags: wp.array2d[int], nowhere: bool):
    i = wp.tid()
    work = Scratch()
    work.flags = flags[i]
    if nowhere:
        look_nowhere(i, model, state, work)
    else:
        look(i, model, state, work)


def after(steps: list[int], cause: list[int], flag: list[int], nowhere: bool = False) -> tuple[list[int], list[int]]:
    """Causes and flags of instances that have made so many steps, from those before."""
    state = State()
    state.step, state.cause = (wp.array(np.int32(v), dtype=int, device="cpu") for v in (steps, cause))
    flags = wp.array(np.int32([[0, f] for f in flag]), dtype=int, device="cpu")
    wp.launch(looked, len(steps), [Model(), state, flags, nowhere], device="cpu")
    return state.cause.numpy().tolist(), flags.numpy()[:, 1].tolist()


def test_the_first_condition_that_is_met_ends_an_instance_and_is_named():
    cause, flag = after([0, 1, 2, 3, 4, 9], [0] * 6, [0] * 6)
    assert cause == [0, 0, CONDITION + 8, CONDITION + 8, CONDITION, CONDITION]
    assert flag == [0, 0, *[CONDITION_MET] * 4]


def test_what_has_diverged_keeps_its_cause():
    before = FORCE + 2 * ENTRY
    assert after([9, 9], [before, before], [1, 1]) == ([before, before], [1, 1])


def test_without_conditions_nothing_ends():
    assert after([9], [0], [0], nowhere=True) == ([0], [0])
