"""The law of the program of Bergmann 2017: one rate of activation, a switching tendon, no bounds, old moment arms."""

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.muscle.activation import activation_step
from warpmuscle.kernels.muscle.contraction import Contraction
from warpmuscle.kernels.muscle.hill_law import hill_strength_of
from warpmuscle.kernels.muscle.muscle import legacy_force, switched_fibre_length
from warpmuscle.kernels.muscle.muscle_kind import MuscleLaw
from warpmuscle.kernels.muscle.muscle_pipeline import MuscleStepRef
from warpmuscle.kernels.path.path import PathState
from warpmuscle.kernels.structs import ModelRef, MuscleRow, StateRef


@func(inline=True)
def activate(instance: int, m: int, muscle: MuscleStepRef, model: ModelRef, state: StateRef):
    """Activation at the rate of its rise (Bergmann 2017, eq. 10)."""
    muscle.activation = activation_step(
        muscle.activation, muscle.excitation, 1.0 / muscle.row.rise_time, model.time_step
    )


@func
def legacy_contraction(
    instance: int, m: int, activation: float, stretch: PathState, row: MuscleRow, model: ModelRef, state: StateRef
) -> Contraction:
    """As the program of Bergmann 2017 computed it: tendon switch, backward difference of the length, no bounds."""
    l_opt = row.l_opt
    c = Contraction()
    c.length = switched_fibre_length(stretch.moving, l_opt, row.l_slack - stretch.fixed)
    if state.step[instance] > 0:
        c.speed = (c.length - state.muscles.fibre_length[instance, m]) / model.time_step
    state.muscles.fibre_length[instance, m] = c.length
    c.force = legacy_force(row.f_max, activation, c.length, c.speed, l_opt)
    return c


@func(inline=True)
def contract(instance: int, m: int, muscle: MuscleStepRef, model: ModelRef, state: StateRef):
    """See `MuscleLaw.contract`."""
    muscle.fibre = legacy_contraction(instance, m, muscle.activation, muscle.stretch, muscle.row, model, state)


LEGACY = MuscleLaw(lambda kind: activate, lambda kind: contract, hill_strength_of, past_arms=True)
