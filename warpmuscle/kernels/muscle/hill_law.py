"""The law of Hill-type muscles: activation dynamics, and contraction of a fibre on a tendon."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.muscle.activation import (
    activation_rate,
    activation_relaxed,
    blended_rate,
    excited_rate,
    excited_rise_rate,
    smoothed_rate,
)
from warpmuscle.kernels.muscle.cables import cable_signals, with_cables
from warpmuscle.kernels.muscle.contraction import RIGID, contraction_of
from warpmuscle.kernels.muscle.muscle_control import activated, neurally_activated
from warpmuscle.kernels.muscle.muscle_kind import MuscleKind, MuscleLaw
from warpmuscle.kernels.muscle.muscle_pipeline import MuscleStepRef
from warpmuscle.kernels.muscle.muscle_strength import as_stretched, strength_of
from warpmuscle.kernels.path.path import PathState
from warpmuscle.kernels.structs import BLENDED, EXCITED, EXCITED_RISE, ModelRef, MuscleRow, StateRef, at


@func
def least_activation(instance: int, m: int, model: ModelRef) -> float:
    """The activation that a muscle never goes below."""
    return at(model.muscles.shape, instance, m).minimum_activation


@func(inline=True)
def follow(instance: int, m: int, activation: float, muscle: MuscleStepRef, model: ModelRef, state: StateRef) -> float:
    """Activation after a step towards the excitation."""
    return activated(activation, muscle.excitation, model.time_step, muscle.row, model.muscles.scaled_rates)


@func(inline=True)
def follow_excited(
    instance: int, m: int, activation: float, muscle: MuscleStepRef, model: ModelRef, state: StateRef
) -> float:
    """The same at a rate that depends on the excitation."""
    rate = excited_rate(muscle.excitation, muscle.row.rise_time, muscle.row.fall_time)
    return activation_relaxed(activation, muscle.excitation, rate, model.time_step)


@func(inline=True)
def follow_excited_rise(
    instance: int, m: int, activation: float, muscle: MuscleStepRef, model: ModelRef, state: StateRef
) -> float:
    """The same at a rate that depends on the excitation where the activation rises."""
    rate = excited_rise_rate(activation, muscle.excitation, muscle.row.rise_time, muscle.row.fall_time)
    return activation_relaxed(activation, muscle.excitation, rate, model.time_step)


@func(inline=True)
def follow_blended(
    instance: int, m: int, activation: float, muscle: MuscleStepRef, model: ModelRef, state: StateRef
) -> float:
    """The same at a rate between those of rising and falling."""
    rate = blended_rate(activation, muscle.excitation, muscle.row.rise_time, muscle.row.fall_time)
    return activation_relaxed(activation, muscle.excitation, rate, model.time_step)


@func(inline=True)
def follow_smoothly(
    instance: int, m: int, activation: float, muscle: MuscleStepRef, model: ModelRef, state: StateRef
) -> float:
    """The same with scaled rates, of some muscles with time constants that change smoothly, or by another law."""
    row = muscle.row
    width = at(model.muscles.smoothing, instance, m)
    rate = activation_rate(activation, muscle.excitation, row.rise_time, row.fall_time)
    if width > 0.0:
        rate = smoothed_rate(activation, muscle.excitation, row.rise_time, row.fall_time, width)
    elif width == BLENDED:
        rate = blended_rate(activation, muscle.excitation, row.rise_time, row.fall_time)
    elif width == EXCITED:
        rate = excited_rate(muscle.excitation, row.rise_time, row.fall_time)
    elif width == EXCITED_RISE:
        rate = excited_rise_rate(activation, muscle.excitation, row.rise_time, row.fall_time)
    return activation_relaxed(activation, muscle.excitation, rate, model.time_step)


@func(inline=True)
def follow_neural_signal(
    instance: int, m: int, activation: float, muscle: MuscleStepRef, model: ModelRef, state: StateRef
) -> float:
    """The same after a neural signal that follows the excitation; the first activation is as given."""
    a = activation
    if muscle.step > 0:
        after = neurally_activated(activation, state.muscles.neural[instance, m], muscle.excitation, muscle.row)
        state.muscles.neural[instance, m] = after[1]
        a = after[0]
    return a


@cache
def activate_of(kind: MuscleKind) -> Any:
    """See `MuscleLaw.activate`."""
    dynamics, floored, cables = follow_neural_signal if kind.neural else follow, kind.floored, kind.cables
    if kind.excited:
        dynamics = follow_excited
    if kind.excited_rise:
        dynamics = follow_excited_rise
    if kind.blended:
        dynamics = follow_blended
    if kind.smoothed:
        dynamics = follow_smoothly

    least, signals_of = least_activation if floored else None, cable_signals if cables else None

    @wp.func(inline=True)
    def activate(instance: int, m: int, muscle: MuscleStepRef, model: ModelRef, state: StateRef):
        a = muscle.activation
        if wp.static(floored):
            a = wp.max(a, least(instance, m, model))
        a = dynamics(instance, m, a, muscle, model, state)
        if wp.static(floored):  # as OpenSim does it: only the activation is held up, not the excitation
            a = wp.max(a, least(instance, m, model))
        if wp.static(cables):
            signals = signals_of(instance, m, a, muscle.excitation, model)
            a = signals[0]
            muscle.excitation = signals[1]
        muscle.activation = a

    return activate


@cache
def contract_of(kind: MuscleKind) -> Any:
    """See `MuscleLaw.contract`."""
    contraction = contraction_of(kind.curves, kind.tendon, kind.implicit, kind.special_curves)
    if kind.cables:
        contraction = with_cables(contraction)

    @wp.func(inline=True)
    def contract(instance: int, m: int, muscle: MuscleStepRef, model: ModelRef, state: StateRef):
        muscle.fibre = contraction(instance, m, muscle.activation, muscle.stretch, muscle.row, model, state)

    return contract


@cache
def hill_strength_of(kind: MuscleKind) -> Any:
    """See `MuscleLaw.strength`; a fibre on a compliant tendon has the length and speed that it has now."""
    contraction = contraction_of(kind.curves, RIGID if kind.elastic else kind.tendon, False, kind.special_curves)
    elastic, floored = kind.elastic, kind.floored

    @wp.func
    def strength(instance: int, m: int, path: PathState, row: MuscleRow, model: ModelRef, state: StateRef) -> wp.vec3:
        stretch = path
        if wp.static(elastic):
            stretch = as_stretched(instance, m, stretch, row, model, state)
        half = contraction(instance, m, 0.5, stretch, row, model, state)
        most = contraction(instance, m, 1.0, stretch, row, model, state)
        least = wp.float32(0.0)
        if wp.static(floored):
            least = least_activation(instance, m, model)
        return strength_of(half.force, most.force, least, row.f_max)

    return strength


HILL = MuscleLaw(activate_of, contract_of, hill_strength_of)
