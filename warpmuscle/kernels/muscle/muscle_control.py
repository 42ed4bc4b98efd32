"""From the torques that a controller wants to what its muscles hear: desired force, excitation, neural delay.

Bergmann 2017, section 5.1, after Geijtenbeek 2013.
"""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.muscle.activation import activation_rate, activation_relaxed, delayed_slot, neural_step
from warpmuscle.kernels.structs import (
    CLIP,
    DROP,
    ModelRef,
    MuscleRow,
    Muscles,
    MuscleState,
    ScratchRef,
    StateRef,
    TimedExcitation,
    at,
)

SMALLEST_ARM = 1.0e-6  # m


@func
def wanted_force(torque: wp.vec3, arm: wp.vec3) -> float:
    """Force with which a muscle gives a joint its torque along the moment arm, N: (r/|r| . torque)/|r| (steps 1, 2).

    Negative if the muscle had to push.
    """
    square = wp.dot(arm, arm)
    if square < wp.static(SMALLEST_ARM * SMALLEST_ARM):
        return 0.0
    return wp.dot(arm, torque) / square


@func
def counted(force: float, negative: int) -> wp.vec2:
    """What a joint adds to the sum of wanted forces, N, and to the number of joints that the average is over."""
    if negative == DROP and force <= 0.0:
        return wp.vec2(0.0, 0.0)
    if negative == CLIP:
        return wp.vec2(wp.max(force, 0.0), 1.0)
    return wp.vec2(force, 1.0)


@func
def average_force(wanted: wp.vec2) -> float:
    """Force that a muscle should have, N: the average over its joints, never negative (step 2), from `counted` sums."""
    return wp.max(wanted[0], 0.0) / wp.max(wanted[1], 1.0)


@func
def desired_force(instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """Force that a muscle should have, N, with the moment arms in the state and the torques in the working set."""
    paths = model.paths
    total = wp.vec2(0.0, 0.0)
    span = paths.span[muscle]
    for k in range(span.first_crossing, span.end_crossing):
        crossing = paths.of_muscle[k]
        arm = state.muscles.moment_arm[instance, crossing.number]
        total += counted(wanted_force(work.torque[crossing.joint], arm), model.muscles.negative)
    return average_force(total)


@func
def timed_excitation(muscles: Muscles, own: TimedExcitation, instance: int, time: float) -> float:
    """A muscle's own excitation at a time, s: straight between knots, constant beyond them, repeated if periodic."""
    first = own.first_knot
    last = own.end_knot - 1
    t = time
    if own.period > 0.0:
        t = time - wp.floor(time / own.period) * own.period
    if t <= at(muscles.knot_time, instance, first):
        return at(muscles.knot_value, instance, first)
    for k in range(first + 1, last + 1):
        after = at(muscles.knot_time, instance, k)
        if t < after:
            before = at(muscles.knot_time, instance, k - 1)
            part = (t - before) / (after - before)
            return wp.lerp(at(muscles.knot_value, instance, k - 1), at(muscles.knot_value, instance, k), part)
    return at(muscles.knot_value, instance, last)


@func
def within(excitation: float) -> float:
    """The excitation within 0..1; nothing for what is not a number."""
    return wp.where(excitation > 0.0, wp.min(excitation, 1.0), 0.0)


@func
def heard_before(instance: int, muscle: int, step: int, delay_steps: int, state: MuscleState) -> float:
    """What the muscle's delay line gives out now, unless the delay is less than a step."""
    capacity = state.excitation_ring.shape[1]
    return state.excitation_ring[instance, delayed_slot(step, delay_steps, capacity), muscle]


@func
def delayed(
    instance: int, muscle: int, step: int, delay_steps: int, excitation: float, before: float, state: MuscleState
) -> float:
    """Put an excitation into the muscle's delay line, and say what the muscle hears now (step 4).

    Args:
        before: from `heard_before`, which is asked for early, since it takes long to come from memory.
    """
    slot = step & (state.excitation_ring.shape[1] - 1)
    state.excitation_ring[instance, slot, muscle] = excitation
    if step == 0 or delay_steps == 0:
        return excitation
    return before


@func
def activated(activation: float, excitation: float, time_step: float, row: MuscleRow, scaled_rates: int) -> float:
    """Activation after a step towards an excitation."""
    if scaled_rates == 1:
        rate = activation_rate(activation, excitation, row.rise_time, row.fall_time)
        return activation_relaxed(activation, excitation, rate, time_step)
    rest = wp.where(excitation > activation, row.rise_rest, row.fall_rest)
    return excitation + (activation - excitation) * rest


@func
def neurally_activated(activation: float, neural: float, excitation: float, row: MuscleRow) -> wp.vec2:
    """Activation and neural signal after a step; that rises or falls as this ends up above or below it."""
    rest = row.rise_rest
    mix = row.rise_mix
    if excitation + (neural - excitation) * row.neural_rest < activation:
        rest = row.fall_rest
        mix = row.fall_mix
    return neural_step(activation, neural, excitation, rest, row.neural_rest, mix)
