"""Muscle reflexes by states of gait: a leg's load and place say its state, which says what reflexes act.

States and their order are those of SCONE's GaitStateController (Geijtenbeek 2019, SCONE: Open Source Software for
Predictive Simulation of Biological Motion, JOSS 4(38), 1421), after Geyer and Herr 2010; so are the terms. Control is
renewed once a control step, from what was sensed a reflex's delay ago and from the state as it is.
"""

import warp as wp

from warpmuscle.kernels.contact.contact import body_weight
from warpmuscle.kernels.control.gait_patterns import noise_of, patterns, renew_patterns
from warpmuscle.kernels.control.gait_sensors import sensed
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.gait_state_structs import (
    EARLY_STANCE,
    LANDING,
    LATE_STANCE,
    LIFTOFF,
    NOTHING,
    SWING,
    UNKNOWN,
    GaitThresholds,
    StateReflexRow,
)
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.muscle.activation import delayed_slot
from warpmuscle.kernels.muscle.muscle import UNSETTLED
from warpmuscle.kernels.objective.accelerations import centre_of_mass
from warpmuscle.kernels.structs import LEFT, ModelRef, MuscleRow, ScratchRef, StateRef, at


@func
def first_state(ahead: float, other_ahead: float, loaded: bool, other_loaded: bool, limits: GaitThresholds) -> int:
    """The state that a leg starts in."""
    if not loaded:
        return wp.where(ahead > limits.landing, LANDING, SWING)
    if other_loaded and ahead < other_ahead:
        return LIFTOFF
    return wp.where(ahead < limits.late_stance, LATE_STANCE, EARLY_STANCE)


@func
def next_state(
    now: int, ahead: float, other_ahead: float, load: float, other_loaded: bool, limits: GaitThresholds
) -> int:
    """The state of a leg after a control step; it goes one state on at most.

    Args:
        now: before. ahead, other_ahead: of both feet in front of the base, m. load: on the leg, body weights.
        other_loaded: whether the other leg carries what lets it stand. limits: of the leg.
    """
    loaded = load > limits.stance_load
    behind = other_loaded and ahead < other_ahead
    if now == UNKNOWN:
        return first_state(ahead, other_ahead, loaded, other_loaded, limits)
    if now == EARLY_STANCE:
        if behind:
            return LIFTOFF
        return wp.where(ahead < limits.late_stance, LATE_STANCE, EARLY_STANCE)
    if now == LATE_STANCE:
        return wp.where(behind or ahead < limits.liftoff, LIFTOFF, LATE_STANCE)
    if now == LIFTOFF:
        return wp.where(load <= limits.swing_load, SWING, LIFTOFF)
    if now == SWING:
        if not loaded and ahead > limits.landing:
            return LANDING
        return wp.where(loaded and ahead > other_ahead, EARLY_STANCE, SWING)
    return wp.where(loaded, EARLY_STANCE, LANDING)


@func
def silenced(angle: float, rate: float, row: StateReflexRow) -> bool:
    """Whether a joint is beyond its interval and goes on that way."""
    return (angle > row.high and rate >= 0.0) or (angle < row.low and rate < 0.0)


@func
def state_reflex_term(signal: float, row: StateReflexRow, positive: int) -> float:
    """What a term adds to an excitation: gain (signal - offset), its positive part, or gain max(signal - offset, 0)."""
    excess = signal - row.offset
    if positive == 2:
        excess = wp.max(excess, 0.0)
    value = row.gain * excess
    return wp.where(positive == 1, wp.max(value, 0.0), value)


@func
def leg_weight(instance: int, side: int, model: ModelRef, state: StateRef) -> float:
    """Ground force on a leg in the step before, its length, body weights."""
    return wp.length(state.foot_force[instance, side]) / body_weight(instance, model)


@func
def renew_states(instance: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """Both legs' states, each by what was before. One lane calls it."""
    limits = at(model.gait.thresholds, instance, LEFT)
    right_limits = at(model.gait.thresholds, instance, 1 - LEFT)
    base = centre_of_mass(instance, model.gait.base, model, work)[2]
    left = centre_of_mass(instance, model.feet.left, model, work)[2] - base
    right = centre_of_mass(instance, model.feet.right, model, work)[2] - base
    left_load = leg_weight(instance, LEFT, model, state)
    right_load = leg_weight(instance, 1 - LEFT, model, state)
    phase = state.gait.phase
    phase[instance, LEFT] = next_state(
        phase[instance, LEFT], left, right, left_load, right_load > right_limits.stance_load, limits
    )
    phase[instance, 1 - LEFT] = next_state(
        phase[instance, 1 - LEFT], right, left, right_load, left_load > limits.stance_load, right_limits
    )


@func
def heard(instance: int, sensor: int, control_step: int, delay_steps: int, state: StateRef) -> float:
    """What a sensor told so many control steps ago, or first of all."""
    ring = state.gait.heard
    return ring[instance, delayed_slot(control_step, delay_steps, ring.shape[1]), sensor]


@func
def state_excitation(instance: int, muscle: int, control_step: int, model: ModelRef, state: StateRef) -> float:
    """Excitation of a muscle by what acts in the state of its leg, with its noise, from the least one to 1."""
    gait = model.gait
    span = gait.span[muscle]
    bit = 1 << (state.gait.phase[instance, span.side] - 1)
    total = wp.float32(0.0)
    for k in range(span.first, span.end):
        plan = gait.plan[k]
        row = at(gait.row, instance, k)
        acts = (plan.states & bit) != 0
        if acts and plan.angle != NOTHING:
            angle = heard(instance, plan.angle, control_step, row.delay_steps, state)
            acts = not silenced(angle, heard(instance, plan.rate, control_step, row.delay_steps, state), row)
        if acts:
            signal = wp.float32(1.0)
            if plan.sensor != NOTHING:
                signal = heard(instance, plan.sensor, control_step, row.delay_steps, state)
                if plan.change == 1:
                    before = heard(instance, plan.sensor, control_step, row.delay_steps + 1, state)
                    signal = (signal - before) / gait.control_step
            total += state_reflex_term(signal, row, plan.positive)
    limits = at(gait.thresholds, instance, 0)
    total += patterns(instance, muscle, control_step, model, state)
    total += noise_of(total, muscle, control_step, limits, gait.noise_seed)
    return wp.clamp(total, limits.least, 1.0)


@func
def gait_state_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """States and excitations, once a control step; from the second step on, when fibres have been felt.

    Activations start at the first excitations, and fibres in equilibrium with them, unless the scene has others:
    what is sensed first is that of the scene's. Ends with a barrier.
    """
    gait = model.gait
    step = state.step[instance]
    if step > 0 and (step - 1) % gait.every == 0:
        control_step = (step - 1) // gait.every
        slot = control_step & (state.gait.heard.shape[1] - 1)
        if lane == 0:
            renew_states(instance, model, state, work)
            renew_patterns(instance, control_step, model, state)
        for s in range(lane, gait.sensor.shape[0], lanes):
            state.gait.heard[instance, slot, s] = sensed(instance, gait.sensor[s], model, state, work)
        synchronize()
        for m in range(lane, model.muscles.count, lanes):
            excitation = state_excitation(instance, m, control_step, model, state)
            state.muscles.reflex[instance, m] = excitation
            if step == gait.begins:
                state.muscles.activation[instance, m] = excitation
                if gait.settles == 1:
                    state.muscles.fibre_length[instance, m] = UNSETTLED
    synchronize()


@func
def state_force(instance: int, muscle: int, asked: float, row: MuscleRow, model: ModelRef, state: StateRef) -> float:
    """Force that is wanted of a muscle by its reflexes, N; in the first step none is known yet."""
    if state.step[instance] == 0:
        return row.f_max * state.muscles.activation[instance, muscle]
    return row.f_max * state.muscles.reflex[instance, muscle]
