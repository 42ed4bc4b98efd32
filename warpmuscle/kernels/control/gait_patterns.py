"""Patterns of excitation over the time since a leg came into some states, and noise.

Shapes are those of SCONE's FeedForwardController, noise that of its NoiseController (scone-core,
`scone/controllers/FeedForwardController.h`, `NoiseController.h`; Geijtenbeek 2019, JOSS 4(38), 1421).
"""

import warp as wp

from warpmuscle.kernels.algebra.random_numbers import EXCITATION, random_of
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.gait_state_structs import CONSTANT, FLAT, NOTHING, POLYNOMIAL, GaitPatternPlan, GaitThresholds
from warpmuscle.kernels.structs import ModelRef, StateRef


@func
def pattern_value(time: float, plan: GaitPatternPlan, knot: wp.array2d[wp.vec2], row: int) -> float:
    """Value of a pattern at a time, s, from 0 on.

    Args:
        knot: (rows, knots) time, s, and value. row: of the instance.
    """
    value = knot[row, plan.first][1]
    if plan.shape == POLYNOMIAL:
        power = wp.float32(1.0)
        for k in range(plan.first + 1, plan.end):
            power *= time
            value += knot[row, k][1] * power
        return value
    for k in range(plan.first + 1, plan.end):
        before = knot[row, k - 1]
        after = knot[row, k]
        if plan.shape == CONSTANT:
            value = wp.where(time >= after[0], after[1], value)
        else:
            reached = wp.where(plan.shape == FLAT, wp.min(time, after[0]), time)
            slope = (after[1] - before[1]) / (after[0] - before[0])
            value = wp.where(time >= before[0], before[1] + slope * (reached - before[0]), value)
    return value


@func
def renew_patterns(instance: int, control_step: int, model: ModelRef, state: StateRef):
    """Since when each pattern acts, by the states of now. One lane calls it."""
    gait = model.gait
    began = state.gait.began
    for m in range(model.muscles.count):
        span = gait.pattern_span[m]
        bit = 1 << (state.gait.phase[instance, span.side] - 1)
        for k in range(span.first, span.end):
            if (gait.pattern[k].states & bit) == 0:
                began[instance, k] = NOTHING
            elif began[instance, k] == NOTHING:
                began[instance, k] = control_step


@func
def patterns(instance: int, muscle: int, control_step: int, model: ModelRef, state: StateRef) -> float:
    """What the patterns of a muscle add to its excitation."""
    gait = model.gait
    span = gait.pattern_span[muscle]
    row = wp.min(instance, gait.knot.shape[0] - 1)
    total = wp.float32(0.0)
    for k in range(span.first, span.end):
        began = state.gait.began[instance, k]
        if began != NOTHING:
            time = float(control_step - began) * gait.control_step
            total += pattern_value(time, gait.pattern[k], gait.knot, row)
    return total


@func
def noise_of(excitation: float, muscle: int, control_step: int, thresholds: GaitThresholds, seed: int) -> float:
    """What noise adds to an excitation: normal, with a deviation that grows with it, none where that is not positive.

    It depends on the muscle and the control step alone, so that all candidates of a search are disturbed alike.
    """
    deviation = thresholds.noise + thresholds.noise_share * excitation
    if deviation > 0.0:
        return deviation * wp.randn(random_of(seed, muscle, control_step, EXCITATION))
    return 0.0
