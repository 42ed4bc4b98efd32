"""Kernels over all muscles of all instances, for pipelines of one's own. Launch with dim = (instances, muscles).

Arrays of muscle numbers are (rows, muscles) with rows = 1 where all instances share them, or one row an instance.
"""

import warp as wp

from warpmuscle.kernels.activation import activation_rate, activation_relaxed, delayed_slot
from warpmuscle.kernels.muscle import compliant_force, compliant_step, fibre_equilibrium, rigid_force
from warpmuscle.kernels.structs import at

wp.set_module_options({"enable_backward": False, "max_unroll": 1})


@wp.struct
class Muscles:
    """What stays the same of the muscles."""

    model: int  # LEE, THELEN, MILLARD or DE_GROOTE
    f_max: wp.array2d[float]  # (rows, muscles) N
    l_opt: wp.array2d[float]  # (rows, muscles) m
    l_slack: wp.array2d[float]  # (rows, muscles) m
    width: wp.array2d[float]  # (rows, muscles) m, l_opt sin(pennation at l_opt)
    v_max: wp.array2d[float]  # (rows, muscles) l_opt/s
    damping: wp.array2d[float]  # (rows, muscles) force at v_max over f_max
    rise_time: wp.array2d[float]  # (rows, muscles) s, time constant of activation
    fall_time: wp.array2d[float]  # (rows, muscles) s, of deactivation
    delay_steps: wp.array2d[int]  # (rows, muscles) less than the capacity of the ring


@wp.struct
class MuscleState:
    """What changes of them."""

    activation: wp.array2d[float]  # (instances, muscles)
    excitation_ring: wp.array3d[float]  # (capacity, instances, muscles)
    fibre_length: wp.array2d[float]  # (instances, muscles) m; with compliant tendons
    force: wp.array2d[float]  # (instances, muscles) N


@wp.kernel
def activate(
    # in
    muscles: Muscles, excitation: wp.array2d[float], step: int, time_step: float,
    # in and out
    state: MuscleState,
):  # fmt: skip
    """Delay the excitations (instances, muscles), and move the activations over a step."""
    i, m = wp.tid()
    capacity = state.excitation_ring.shape[0]
    state.excitation_ring[step % capacity, i, m] = excitation[i, m]
    slot = delayed_slot(step, at(muscles.delay_steps, i, m), capacity)
    u = state.excitation_ring[slot, i, m]
    a = state.activation[i, m]
    rate = activation_rate(a, u, at(muscles.rise_time, i, m), at(muscles.fall_time, i, m))
    state.activation[i, m] = activation_relaxed(a, u, rate, time_step)


@wp.kernel
def muscle_force_rigid(
    # in
    muscles: Muscles, mt_length: wp.array2d[float], mt_speed: wp.array2d[float],
    # in and out
    state: MuscleState,
):  # fmt: skip
    """Forces, N, with rigid tendons, from lengths (m) and speeds (m/s) of the units, (instances, muscles)."""
    i, m = wp.tid()
    force = rigid_force(
        muscles.model, state.activation[i, m], mt_length[i, m], mt_speed[i, m],
        at(muscles.l_opt, i, m), at(muscles.l_slack, i, m), at(muscles.width, i, m), at(muscles.v_max, i, m),
        at(muscles.damping, i, m),
    )  # fmt: skip
    state.force[i, m] = at(muscles.f_max, i, m) * force


@wp.kernel
def settle_fibres(
    # in
    muscles: Muscles, mt_length: wp.array2d[float],
    # in and out
    state: MuscleState,
):  # fmt: skip
    """Set the fibre lengths to the equilibrium at rest with compliant tendons, as a simulation starts from."""
    i, m = wp.tid()
    state.fibre_length[i, m] = fibre_equilibrium(
        muscles.model, state.activation[i, m], mt_length[i, m],
        at(muscles.l_opt, i, m), at(muscles.l_slack, i, m), at(muscles.width, i, m),
    )  # fmt: skip


@wp.kernel
def muscle_force_compliant(
    # in
    muscles: Muscles, mt_length: wp.array2d[float], mt_speed: wp.array2d[float], time_step: float,
    # in and out
    state: MuscleState,
):  # fmt: skip
    """Fibre lengths and forces, N, with compliant tendons after a step; lengths and speeds of the units at its end."""
    i, m = wp.tid()
    l_slack = at(muscles.l_slack, i, m)
    width = at(muscles.width, i, m)
    length = compliant_step(
        muscles.model, state.activation[i, m], mt_length[i, m], mt_speed[i, m], state.fibre_length[i, m],
        at(muscles.l_opt, i, m), l_slack, width, at(muscles.v_max, i, m), at(muscles.damping, i, m), time_step,
    )  # fmt: skip
    force = compliant_force(muscles.model, mt_length[i, m], length, l_slack, width)
    state.fibre_length[i, m] = length
    state.force[i, m] = at(muscles.f_max, i, m) * force
