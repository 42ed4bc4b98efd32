"""What muscles come to over a window of time along paths whose lengths are told, under constant excitations."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.functions import build_options
from warpmuscle.kernels.muscle.muscle_kind import MuscleKind
from warpmuscle.kernels.muscle.muscle_laws import function_of
from warpmuscle.kernels.muscle.muscle_pipeline import MuscleStep
from warpmuscle.kernels.path.path import PathState
from warpmuscle.kernels.structs import Model, State, at


@cache
def window_forces_of(kind: MuscleKind) -> Any:
    """The kernel (model, state, steps, start, end, excitation, force, final) of muscles of a kind, one a thread.

    The state is that of muscles at the window's start, and is moved on to its end. Where its step is 0, fibres begin
    in equilibrium.

    What it takes and gives, all (instances, muscles):
        start, end: lengths of paths, m, which change evenly. excitation: over the window.
        force: N, along the tendon, in the last step. final: activation after it.
    """
    activate, contract = function_of(kind, "activate"), function_of(kind, "contract")

    @wp.kernel(
        module="unique",
        enable_backward=False,
        module_options={"enable_backward": False, "max_unroll": 1, **build_options()},
    )
    def kernel(
        # in
        model: Model, state: State, steps: int, start: wp.array2d[float], end: wp.array2d[float],
        excitation: wp.array2d[float],
        # out
        force: wp.array2d[float], final: wp.array2d[float],
    ):  # fmt: skip
        i, m = wp.tid()
        paths_given = model
        changing = state
        muscle = MuscleStep()
        muscle.step = 1
        muscle.row = at(model.muscles.row, i, m)
        muscle.activation = state.muscles.activation[i, m]
        muscle.excitation = excitation[i, m]
        stretch = PathState()
        rise = (end[i, m] - start[i, m]) / float(steps)
        stretch.speed = rise / model.time_step
        for k in range(steps):
            stretch.moving = start[i, m] + rise * float(k)
            muscle.stretch = stretch
            activate(i, m, muscle, paths_given, changing)
            contract(i, m, muscle, paths_given, changing)
        force[i, m] = muscle.fibre.force
        final[i, m] = muscle.activation

    return kernel
