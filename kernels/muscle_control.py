"""From the torques that a controller wants to what its muscles hear: desired force, excitation, neural delay.

Bergmann 2017, section 5.1, after Geijtenbeek 2013.
"""

import warp as wp

from warpmuscle.kernels.activation import activation_rate, activation_relaxed, delayed_slot, neural_step
from warpmuscle.kernels.structs import CLIP, DROP, Model, Muscles, MuscleState, State, Work, at

SMALLEST_ARM = 1.0e-6  # m


@wp.func
def wanted_force(torque: wp.vec3, arm: wp.vec3) -> float:
    """Force with which a muscle gives a joint its torque along the moment arm, N: (r/|r| . torque)/|r| (steps 1, 2).

    Negative if the muscle had to push.
    """
    square = wp.dot(arm, arm)
    if square < wp.static(SMALLEST_ARM * SMALLEST_ARM):
        return 0.0
    return wp.dot(arm, torque) / square


@wp.func
def counted(force: float, negative: int) -> wp.vec2:
    """What a joint adds to the sum of wanted forces, N, and to the number of joints that the average is over."""
    if negative == DROP and force <= 0.0:
        return wp.vec2(0.0, 0.0)
    if negative == CLIP:
        return wp.vec2(wp.max(force, 0.0), 1.0)
    return wp.vec2(force, 1.0)


@wp.func
def desired_force(instance: int, muscle: int, model: Model, state: State, work: Work) -> float:
    """Force that a muscle should have, N: the average over its joints, never negative (step 2).

    The moment arms are those in the state, the wanted torques those in the working set.
    """
    paths = model.paths
    total = wp.vec2(0.0, 0.0)
    for k in range(paths.muscle_crossing_start[muscle], paths.muscle_crossing_start[muscle + 1]):
        crossing = paths.muscle_crossing[k]
        torque = work.torque[paths.crossing_joint[crossing]]
        total += counted(wanted_force(torque, state.muscles.moment_arm[instance, crossing]), model.muscles.negative)
    return wp.max(total[0], 0.0) / wp.max(total[1], 1.0)


@wp.func
def timed_excitation(muscles: Muscles, instance: int, muscle: int, time: float) -> float:
    """A muscle's own excitation at a time, s: straight between knots, constant beyond them, repeated if periodic."""
    first = muscles.knot_start[muscle]
    last = muscles.knot_start[muscle + 1] - 1
    period = at(muscles.period, instance, muscle)
    t = time
    if period > 0.0:
        t = time - wp.floor(time / period) * period
    if t <= at(muscles.knot_time, instance, first):
        return at(muscles.knot_value, instance, first)
    for k in range(first + 1, last + 1):
        after = at(muscles.knot_time, instance, k)
        if t < after:
            before = at(muscles.knot_time, instance, k - 1)
            part = (t - before) / (after - before)
            return wp.lerp(at(muscles.knot_value, instance, k - 1), at(muscles.knot_value, instance, k), part)
    return at(muscles.knot_value, instance, last)


@wp.func
def delayed(instance: int, muscle: int, step: int, excitation: float, muscles: Muscles, state: MuscleState) -> float:
    """Put an excitation into the muscle's delay line, and take out what the muscle hears of it now (step 4)."""
    capacity = state.excitation_ring.shape[1]
    state.excitation_ring[instance, step & (capacity - 1), muscle] = excitation
    slot = delayed_slot(step, at(muscles.delay_steps, instance, muscle), capacity)
    return state.excitation_ring[instance, slot, muscle]


@wp.func
def activated(
    instance: int, muscle: int, excitation: float, time_step: float, muscles: Muscles, state: MuscleState
) -> float:
    """Activation after a step towards an excitation; it is stored."""
    a = state.activation[instance, muscle]
    if muscles.scaled_rates == 1:
        rise = at(muscles.rise_time, instance, muscle)
        rate = activation_rate(a, excitation, rise, at(muscles.fall_time, instance, muscle))
        a = activation_relaxed(a, excitation, rate, time_step)
    elif excitation > a:
        a = excitation + (a - excitation) * at(muscles.rise_rest, instance, muscle)
    else:
        a = excitation + (a - excitation) * at(muscles.fall_rest, instance, muscle)
    state.activation[instance, muscle] = a
    return a


@wp.func
def neurally_activated(
    instance: int, muscle: int, step: int, excitation: float, muscles: Muscles, state: MuscleState
) -> float:
    """Activation now, a step after the last one, by way of a neural signal; both are stored, and as given at step 0.

    The activation rises or falls as the neural signal ends up above or below it.
    """
    a = state.activation[instance, muscle]
    if step == 0:
        return a
    e = state.neural[instance, muscle]
    neural_rest = at(muscles.neural_rest, instance, muscle)
    rest = at(muscles.rise_rest, instance, muscle)
    mix = at(muscles.rise_mix, instance, muscle)
    if excitation + (e - excitation) * neural_rest < a:
        rest = at(muscles.fall_rest, instance, muscle)
        mix = at(muscles.fall_mix, instance, muscle)
    after = neural_step(a, e, excitation, rest, neural_rest, mix)
    state.activation[instance, muscle] = after[0]
    state.neural[instance, muscle] = after[1]
    return after[0]
