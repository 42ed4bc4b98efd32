"""Kernels over all muscles of all instances, for pipelines of one's own. Launch with dim = (instances, muscles).

Arrays of muscle numbers are (rows, muscles) with rows = 1 where all instances share them, or one row an instance.
All muscles have the curves of `Muscles.model` here; the fused step and `Stages` know of curves of their own.
"""

import warp as wp

from warpmuscle.kernels.muscle.muscle import compliant_force, compliant_step, fibre_equilibrium, rigid_force
from warpmuscle.kernels.muscle.muscle_control import activated, delayed, heard_before
from warpmuscle.kernels.structs import Muscles, MuscleState, at

wp.set_module_options({"enable_backward": False, "max_unroll": 1})


@wp.kernel
def activate(
    # in
    muscles: Muscles, excitation: wp.array2d[float], step: int, time_step: float,
    # in and out
    state: MuscleState,
):  # fmt: skip
    """Delay the excitations (instances, muscles), and move the activations over a step."""
    i, m = wp.tid()
    row = at(muscles.row, i, m)
    before = heard_before(i, m, step, row.delay_steps, state)
    heard = delayed(i, m, step, row.delay_steps, excitation[i, m], before, state)
    state.activation[i, m] = activated(state.activation[i, m], heard, time_step, row, muscles.scaled_rates)


@wp.kernel
def muscle_force_rigid(
    # in
    muscles: Muscles, mt_length: wp.array2d[float], mt_speed: wp.array2d[float],
    # in and out
    state: MuscleState,
):  # fmt: skip
    """Forces, N, with rigid tendons, from lengths (m) and speeds (m/s) of the units, (instances, muscles)."""
    i, m = wp.tid()
    row = at(muscles.row, i, m)
    force = rigid_force(
        muscles.model, state.activation[i, m], mt_length[i, m], mt_speed[i, m],
        row.l_opt, row.l_slack, row.width, row.v_max, row.damping,
    )  # fmt: skip
    state.force[i, m] = row.f_max * force


@wp.kernel
def settle_fibres(
    # in
    muscles: Muscles, mt_length: wp.array2d[float],
    # in and out
    state: MuscleState,
):  # fmt: skip
    """Set the fibre lengths to the equilibrium at rest with compliant tendons, as a simulation starts from."""
    i, m = wp.tid()
    row = at(muscles.row, i, m)
    length = fibre_equilibrium(
        muscles.model, state.activation[i, m], mt_length[i, m], row.l_opt, row.l_slack, row.width
    )
    state.fibre_length[i, m] = length
    state.previous_fibre_length[i, m] = length


@wp.kernel
def muscle_force_compliant(
    # in
    muscles: Muscles, mt_length: wp.array2d[float], time_step: float,
    # in and out
    state: MuscleState,
):  # fmt: skip
    """Fibre lengths and forces, N, with compliant tendons after a step; lengths of the units (m) at its end."""
    i, m = wp.tid()
    row = at(muscles.row, i, m)
    before = state.fibre_length[i, m]
    length = compliant_step(
        muscles.model, state.activation[i, m], mt_length[i, m], before, state.previous_fibre_length[i, m],
        row.l_opt, row.l_slack, row.width, row.v_max, row.damping, time_step,
    )  # fmt: skip
    force = compliant_force(muscles.model, mt_length[i, m], length, row.l_slack, row.width)
    state.previous_fibre_length[i, m] = before
    state.fibre_length[i, m] = length
    state.force[i, m] = row.f_max * force
