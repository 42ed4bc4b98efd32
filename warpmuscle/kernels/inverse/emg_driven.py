"""Moments that muscles make under measured EMG, for many sets of their parameters at once."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.curve.custom_curves import CustomCurves
from warpmuscle.kernels.curve.shaped_curves import Shaped
from warpmuscle.kernels.inverse.muscle_moments import curve_functions, has_cables
from warpmuscle.kernels.muscle.activation import activation_rate, activation_relaxed
from warpmuscle.kernels.muscle.cables import is_cable, ligament_force
from warpmuscle.kernels.muscle.muscle import pennation_cosine, rigid_fibre_speed
from warpmuscle.kernels.structs import Model, at


@wp.struct
class Candidates:
    """Parameters of C candidates."""

    delay: wp.array[float]  # (C,) s, from EMG to the excitation
    gain: wp.array2d[float]  # (C, M) of EMG
    shape: wp.array2d[float]  # (C, M) A of the activation, below 0
    f_max: wp.array2d[float]  # (C, M) factors of the model's own
    l_opt: wp.array2d[float]
    l_slack: wp.array2d[float]


@wp.struct
class Recordings:
    """What is known of n frames of several trials."""

    begin: wp.array[int]  # (trials + 1,) first frames, and the number of all
    time: wp.array[float]  # (n,) s, since the first sample of the trial's EMG
    emg: wp.array3d[float]  # (trials, G, M) envelopes, 0 to 1, from some time before the first frame on
    step: float  # s, between samples of EMG
    estimated: wp.array2d[float]  # (n, M) activations of muscles without EMG
    measured: wp.array[int]  # (M,) 1: has EMG
    rise_time: wp.array[float]  # (M,) s
    fall_time: wp.array[float]
    length: wp.array2d[float]  # (n, M) m, of paths
    speed: wp.array2d[float]  # (n, M) m/s
    moment_arm: wp.array2d[float]  # (n, levers) m


@wp.func
def shaped_activation(linear: float, shape: float) -> float:
    """The nonlinear activation (e^(A u) - 1)/(e^A - 1) of a linear one (Buchanan et al. 2004, eq. 6)."""
    return (wp.exp(shape * linear) - 1.0) / (wp.exp(shape) - 1.0)


@wp.kernel(module="unique", enable_backward=False, module_options={"enable_backward": False, "max_unroll": 1})
def emg_activations(
    # in
    known: Recordings, candidates: Candidates,
    # out
    activation: wp.array3d[float],
):  # fmt: skip
    """Activations (C, n, M); launch with (C, trials, M)."""
    c, trial, m = wp.tid()
    f = wp.int32(known.begin[trial])
    end = known.begin[trial + 1]
    if known.measured[m] == 0:
        for other in range(f, end):
            activation[c, other, m] = known.estimated[other, m]
        return
    late = candidates.delay[c] / known.step
    a = wp.float32(0.0)
    for g in range(known.emg.shape[1]):
        heard = wp.clamp(float(g) + 0.5 - late, 0.0, float(known.emg.shape[1] - 1))
        before = int(heard)
        after = wp.min(before + 1, known.emg.shape[1] - 1)
        e = wp.lerp(known.emg[trial, before, m], known.emg[trial, after, m], heard - float(before))
        u = wp.clamp(candidates.gain[c, m] * e, 0.0, 1.0)
        if g == 0:
            a = u
        rate = activation_rate(a, u, known.rise_time[m], known.fall_time[m])
        begin = float(g) * known.step
        while f < end and known.time[f] < begin + known.step:
            within = activation_relaxed(a, u, rate, wp.max(known.time[f] - begin, 0.0))
            activation[c, f, m] = shaped_activation(within, candidates.shape[c, m])
            f += 1
        a = activation_relaxed(a, u, rate, known.step)


@cache
def emg_forces_of(curves: int, own: CustomCurves | Shaped | None = None) -> Any:
    """The kernel (model, known, candidates, activation, force) of forces (C, n, M), N; launch with that size.

    Tendons are rigid, as of static optimisation. curves, own: as of `muscle_stage.MuscleKind`.
    """
    forces, bounded, rigid_length, curves_of = curve_functions(curves, own)
    shaped, cables = isinstance(own, Shaped), has_cables(own)

    @wp.kernel(module="unique", enable_backward=False, module_options={"enable_backward": False, "max_unroll": 1})
    def kernel(
        # in
        model: Model, known: Recordings, candidates: Candidates, activation: wp.array3d[float],
        # out
        force: wp.array3d[float],
    ):  # fmt: skip
        c, f, m = wp.tid()
        row = at(model.muscles.row, 0, m)
        if wp.static(cables):  # noqa: SIM102, with `and` it would be compiled in all the same
            if is_cable(0, m, model):
                force[c, f, m] = ligament_force(0, m, known.length[f, m], known.speed[f, m], row, model)
                return
        of_muscle = curves_of(0, m, model)
        l_opt = row.l_opt * candidates.l_opt[c, m]
        width = row.width * candidates.l_opt[c, m]
        slack = row.l_slack * candidates.l_slack[c, m]
        fibre = rigid_length(known.length[f, m], l_opt, slack, width)
        if wp.static(shaped):
            fibre = wp.max(fibre, bounded(of_muscle.row.shortest * l_opt, l_opt, width))
        v = rigid_fibre_speed(known.speed[f, m], fibre, width) / (row.v_max * l_opt)
        both = forces(of_muscle, fibre / l_opt, v, pennation_cosine(fibre, width))
        force[c, f, m] = row.f_max * candidates.f_max[c, m] * (activation[c, f, m] * both[0] + both[1])

    return kernel


@wp.kernel(module="unique", enable_backward=False, module_options={"enable_backward": False, "max_unroll": 1})
def emg_moments(
    # in
    known: Recordings, first: wp.array[int], lever: wp.array[int], muscle: wp.array[int], force: wp.array3d[float],
    # out
    moment: wp.array3d[float],
):  # fmt: skip
    """Generalised forces (C, n, K) of some speeds; launch with that size.

    Speed k has the entries first[k] to first[k + 1] of `lever` and `muscle`.
    """
    c, f, k = wp.tid()
    total = wp.float32(0.0)
    for entry in range(first[k], first[k + 1]):
        total += known.moment_arm[f, lever[entry]] * force[c, f, muscle[entry]]
    moment[c, f, k] = total


@wp.kernel(module="unique", enable_backward=False, module_options={"enable_backward": False, "max_unroll": 1})
def moment_errors(
    # in
    block: wp.array[int], wanted: wp.array2d[float], moment: wp.array3d[float],
    # out
    error: wp.array3d[float],
):  # fmt: skip
    """Sums of squared errors (C, blocks, K) over blocks of frames, block b from block[b] on; launch with that size."""
    c, b, k = wp.tid()
    total = wp.float32(0.0)
    for f in range(block[b], block[b + 1]):
        away = moment[c, f, k] - wanted[f, k]
        total += away * away
    error[c, b, k] = total
