"""What a muscle can do at the length and speed that it has: its passive and its active force."""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.muscle.muscle import SMALLEST_COSINE, along_tendon, pennation_cosine
from warpmuscle.kernels.path.path import PathState
from warpmuscle.kernels.structs import ModelRef, MuscleRow, StateRef

WEAKEST = 1.0e-3  # active force over f_max, so that nothing is divided by zero


@func
def strength_of(half: float, full: float, least: float, f_max: float) -> wp.vec3:
    """What a muscle has of its forces at activations of 1/2 and 1, which lie on a line.

    Returns:
        Passive force, N, which it has at the least activation; active force, N; and the activation from which on there
        is any of that: a fibre that shortens fast takes some before damping leaves any force.
    """
    slope = 2.0 * (full - half)
    at_none = full - slope
    passive = wp.max(at_none + least * slope, 0.0)
    start = wp.max(-at_none, 0.0) / wp.max(slope, WEAKEST * f_max)
    return wp.vec3(passive, wp.max(full - passive, WEAKEST * f_max), wp.max(start, least))


@func
def as_stretched(instance: int, muscle: int, stretch: PathState, row: MuscleRow, model: ModelRef, state: StateRef):
    """The stretch with which a rigid tendon would give a fibre the length and speed that it has on a compliant one.

    Before the first step, and of a muscle without such a tendon, it is the one that is given.
    """
    length = state.muscles.fibre_length[instance, muscle]
    if length > 0.0:
        speed = (length - state.muscles.previous_fibre_length[instance, muscle]) / model.time_step
        stretch.moving = along_tendon(length, row.width) + row.l_slack - stretch.fixed
        stretch.speed = speed / wp.max(pennation_cosine(length, row.width), SMALLEST_COSINE)
    return stretch
