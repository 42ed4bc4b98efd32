"""The law of ideal muscles: the desired force at once, without activation and contraction (Bergmann 2017, 7.1)."""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.muscle.contraction import Contraction
from warpmuscle.kernels.muscle.muscle_kind import MuscleLaw
from warpmuscle.kernels.muscle.muscle_pipeline import MuscleStepRef
from warpmuscle.kernels.path.path import PathState
from warpmuscle.kernels.structs import ModelRef, MuscleRow, StateRef


@func(inline=True)
def activate(instance: int, m: int, muscle: MuscleStepRef, model: ModelRef, state: StateRef):
    """The excitation, at once."""
    muscle.activation = muscle.excitation


@func(inline=True)
def contract(instance: int, m: int, muscle: MuscleStepRef, model: ModelRef, state: StateRef):
    """The fibre is what the path leaves of the tendon."""
    c = Contraction()
    c.length = muscle.stretch.moving + (muscle.stretch.fixed - muscle.row.l_slack)
    c.speed = muscle.stretch.speed
    c.force = muscle.desired
    muscle.fibre = c


@func
def strength(instance: int, m: int, stretch: PathState, row: MuscleRow, model: ModelRef, state: StateRef) -> wp.vec3:
    """All of its force is active, see `muscle_strength.strength_of`."""
    return wp.vec3(0.0, row.f_max, 0.0)


IDEAL = MuscleLaw(lambda kind: activate, lambda kind: contract, lambda kind: strength, delayed=False)
