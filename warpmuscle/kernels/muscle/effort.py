"""What recorded muscles spend: their passive forces and metabolic powers, for many moments at once."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.curve.custom_curves import with_curves
from warpmuscle.kernels.curve.shaped_curves import Shaped
from warpmuscle.kernels.functions import CPU_FLAGS
from warpmuscle.kernels.known_kernels import known_kernel
from warpmuscle.kernels.muscle.muscle import pennation_cosine
from warpmuscle.kernels.objective import term_functions as terms
from warpmuscle.kernels.objective.term_functions import MuscleWork
from warpmuscle.kernels.structs import Model, at

WANG, UMBERGER, BHARGAVA, BHARGAVA_STRICT, MARGARIA = 0, 1, 2, 3, 4


@cache
def muscle_effort_of(own: Shaped | None = None) -> Any:
    """The kernel `muscle_effort` for muscles whose curves have shapes of their own."""
    passive_force, wang, umberger, bhargava, strict, margaria = (
        with_curves(function, own)
        for function in (
            terms.passive_force, terms.metabolic_wang, terms.metabolic_umberger, terms.metabolic_bhargava,
            terms.metabolic_bhargava_strict, terms.metabolic_margaria,
        )
    )  # fmt: skip

    @known_kernel(own, module_options={"enable_backward": False, "max_unroll": 1, "cpu_compiler_flags": CPU_FLAGS})
    def muscle_effort(
        # in
        model: Model, metabolic_model: int, activation: wp.array2d[float], excitation: wp.array2d[float],
        length: wp.array2d[float], speed: wp.array2d[float],
        # out
        passive: wp.array2d[float], power: wp.array2d[float],
    ):  # fmt: skip
        """Passive force along the tendon, N, and metabolic power, W. Launch with dim = (moments, muscles).

        Args:
            model: its muscles count, of one instance. length, speed: of the fibre, m and m/s, lengthening.
        """
        i, m = wp.tid()
        row = at(model.muscles.row, 0, m)
        w = MuscleWork()
        w.activation = activation[i, m]
        w.excitation = excitation[i, m]
        w.length = length[i, m]
        w.speed = speed[i, m]
        passive[i, m] = passive_force(0, m, w, model) * pennation_cosine(w.length, row.width)
        if metabolic_model == WANG:
            power[i, m] = wang(0, m, w, model)
        elif metabolic_model == UMBERGER:
            power[i, m] = umberger(0, m, w, model)
        elif metabolic_model == BHARGAVA:
            power[i, m] = bhargava(0, m, w, model)
        elif metabolic_model == MARGARIA:
            power[i, m] = margaria(0, m, w, model)
        else:
            power[i, m] = strict(0, m, w, model)

    return muscle_effort
