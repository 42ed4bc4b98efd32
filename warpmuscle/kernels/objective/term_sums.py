"""Which terms of the objective a step sums up, and the stages that add to their sums."""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.curve.custom_curves import CustomCurves, with_curves
from warpmuscle.kernels.curve.shaped_curves import Shaped
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.objective.causes import TERM, cause_of, checked
from warpmuscle.kernels.objective.term_functions import (
    BODY_TERMS,
    CYCLE_TERMS,
    INSTANCE_TERMS,
    MUSCLE_TERMS,
    MuscleWork,
)
from warpmuscle.kernels.structs import LARGEST, ModelRef, ScratchRef, State, StateRef, not_unrolled, recomputed


@func
def sane(value: float, work: ScratchRef) -> wp.float64:
    """The value in double precision; nothing for what is too large or not a number, and the step has diverged."""
    if wp.abs(value) < LARGEST:
        return wp.float64(value)
    work.flags[1] = 1
    return wp.float64(0.0)


@func
def effort_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """Add this step's feedback torque of every joint to its integral (Bergmann 2017, section 6). No barrier.

    One sum a joint, in double precision, so that the result does not depend on lanes or on chunks of steps.
    """
    for i in range(1 + lane, model.body_count, recomputed(lanes)):  # see `objective_stage_of`
        not_unrolled()
        effort = wp.length(work.torque[i])
        if effort < LARGEST:
            # not `+=`, which would be an atomic operation
            state.torque_integral[instance, i] = state.torque_integral[instance, i] + wp.float64(effort)
        else:
            work.flags[1] = 1


@func
def no_muscle_terms(instance: int, m: int, w: MuscleWork, model: ModelRef, state: StateRef, work: ScratchRef):
    """No term is summed over muscles."""


@func
def no_body_terms(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """No term is summed over bodies."""


@func
def no_instance_terms(instance: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """No term of the whole instance is summed."""


class ObjectiveKind(NamedTuple):
    """Names of the terms that a step sums up, in the order of their sums, and the functions of terms of others."""

    muscle: tuple[str, ...] = ()
    body: tuple[str, ...] = ()
    instance: tuple[str, ...] = ()
    custom: tuple[tuple[str, Any], ...] = ()  # by name, Warp functions like those of `MUSCLE_TERMS` and so on
    desired: tuple[str, ...] = ()  # those of `whole` that see the torques which the controller wants
    conditions: tuple[tuple[str, Any], ...] = ()  # by name, failing conditions of others, see `failing_stage_of`
    progress: bool = False  # whether an instance that stands still has failed
    accelerated: tuple[str, ...] = ()  # those of `body` and `whole` that see accelerations
    cycles: bool = False  # whether some of others ask where feet are in their gait cycles
    earned: tuple[str, ...] = ()  # of those of others, that are to be great; what they sum up lowers the cost

    @property
    def follows_cycles(self) -> bool:
        """Whether a step has to follow the gait cycles of the feet."""
        return self.cycles or bool(CYCLE_TERMS & {*self.body, *self.instance})

    def cause(self, name: str) -> int:
        """The number of a term of others, see `causes.py`; 0 of any other."""
        names = [own for own, _ in self.custom]
        return cause_of(TERM, names.index(name)) if name in names else 0


def muscle_functions(
    kind: ObjectiveKind, own: CustomCurves | Shaped | None = None, curves: int | None = None
) -> tuple[Any, ...]:
    """The Warp functions of the terms over muscles; metabolic powers with the curves that muscles have.

    Args:
        own, curves: as of `muscle_kind.MuscleKind`; no curves: those of all sets.

    With each stands its number if it is a term of others, see `causes.py`, else 0.
    """
    given = dict(kind.custom)
    return tuple(
        (given[name], kind.cause(name)) if name in given else (with_curves(MUSCLE_TERMS[name], own, curves), 0)
        for name in kind.muscle
    )


@cache
def muscle_terms_of(terms: tuple[Any, ...]) -> Any:
    """The Warp function (instance, muscle, what it does, model, state, work) that adds a step to the terms' sums."""
    every = no_muscle_terms
    for index, (term, cause) in enumerate(terms):
        every = _and_muscle_term(every, term, index, cause)
    return every


def _counted(cause: int) -> Any:
    """The Warp function (value, instance, state, work) that takes a term's value into its sum, see `sane`.

    Args:
        cause: number of a term of others, which is to blame if it gives no number; 0 of any other.
    """

    @wp.func
    def of_others(value: float, instance: int, state: StateRef, work: ScratchRef) -> wp.float64:
        return sane(checked(value, instance, wp.static(cause), state, work), work)

    @wp.func
    def shipped(value: float, instance: int, state: StateRef, work: ScratchRef) -> wp.float64:
        return sane(value, work)

    return of_others if cause > 0 else shipped


def takes_state(function: Any) -> bool:
    """Whether the Warp function of a muscle takes the state, where the memory of a part of the scene's own is."""
    return any(kind is State or getattr(kind, "value_type", None) is State for kind in function.input_types.values())


def _and_muscle_term(others: Any, term: Any, index: int, cause: int) -> Any:
    counted, with_state = _counted(cause), takes_state(term)

    @wp.func
    def add(instance: int, m: int, w: MuscleWork, model: ModelRef, state: StateRef, work: ScratchRef):
        others(instance, m, w, model, state, work)
        if wp.static(with_state):
            value = counted(term(instance, m, w, model, state), instance, state, work)
        else:
            value = counted(term(instance, m, w, model), instance, state, work)
        state.muscle_terms[instance, index, m] = state.muscle_terms[instance, index, m] + value

    return add


def _and_body_term(others: Any, term: Any, index: int, cause: int) -> Any:
    counted = _counted(cause)

    @wp.func
    def add(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef):
        others(instance, body, model, state, work)
        value = counted(term(instance, body, model, state, work), instance, state, work)
        state.body_terms[instance, index, body] = state.body_terms[instance, index, body] + value

    return add


def _and_instance_term(others: Any, term: Any, index: int, cause: int) -> Any:
    counted, with_total = _counted(cause), "total" in term.input_types

    @wp.func
    def add(instance: int, model: ModelRef, state: StateRef, work: ScratchRef):
        others(instance, model, state, work)
        total = state.instance_terms[instance, index]
        if wp.static(with_total):
            value = counted(term(instance, model, state, work, float(total)), instance, state, work)
        else:
            value = counted(term(instance, model, state, work), instance, state, work)
        state.instance_terms[instance, index] = total + value

    return add


@cache
def objective_stage_of(kind: ObjectiveKind, accelerated: bool = False) -> Any:
    """The Warp function that adds a step of the terms of bodies and of the whole to their sums. No barrier.

    One sum a body, in double precision, so that results depend neither on lanes nor on chunks of steps.

    Args:
        accelerated: of those that see accelerations, else of all but these.
    """
    body_terms, instance_terms = no_body_terms, no_instance_terms
    own, other = dict(kind.custom), set(kind.desired)
    for index, name in enumerate(kind.body):
        if (name in kind.accelerated) == accelerated:
            body_terms = _and_body_term(body_terms, own.get(name) or BODY_TERMS[name], index, kind.cause(name))
    for index, name in enumerate(kind.instance):
        if (name in kind.accelerated) == accelerated and name not in other:
            instance_terms = _and_instance_term(
                instance_terms, own.get(name) or INSTANCE_TERMS[name], index, kind.cause(name)
            )

    @wp.func
    def objective_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
        # With a stride that the compiler knows, it prepares for a second body of a lane, which few lanes have.
        for i in range(1 + lane, model.body_count, recomputed(lanes)):
            body_terms(instance, i, model, state, work)
        if lane == 0:
            instance_terms(instance, model, state, work)

    return objective_stage


@cache
def desired_stage_of(kind: ObjectiveKind) -> Any:
    """The Warp function (instance, model, state, work) that adds a step of the terms that see desired torques.

    One lane calls it when the controller has put these into the working set, and no muscle has acted yet.
    """
    terms, own = no_instance_terms, dict(kind.custom)
    for index, name in enumerate(kind.instance):
        if name in kind.desired:
            terms = _and_instance_term(terms, own[name], index, kind.cause(name))
    return terms
