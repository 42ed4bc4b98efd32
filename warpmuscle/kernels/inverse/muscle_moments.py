"""What muscles can do to every coordinate: moment arms, and forces at full and at no activation with rigid tendons."""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.body.coordinate_joint import coordinate_axis
from warpmuscle.kernels.body.joint_motion import has_motion
from warpmuscle.kernels.body.speed_axes import angular_axis
from warpmuscle.kernels.curve.curve_sets import PATH_ACTUATOR
from warpmuscle.kernels.curve.curves import active_force_length, force_velocity, tendon_force_strain
from warpmuscle.kernels.curve.custom_curves import CustomCurves, with_curves
from warpmuscle.kernels.curve.shaped_curves import Shaped, ShapedCurves, shaped_curves
from warpmuscle.kernels.functions import build_options, func
from warpmuscle.kernels.muscle.cables import is_cable, ligament_force
from warpmuscle.kernels.muscle.muscle import (
    LARGEST_SPEED,
    bounded_fibre_length,
    bounded_passive,
    pennation_cosine,
    rigid_fibre_length,
    rigid_fibre_speed,
)
from warpmuscle.kernels.path.stretch import PathKind
from warpmuscle.kernels.stages import stretch_all_of, work_of
from warpmuscle.kernels.structs import Model, ModelRef, Muscles, ScratchRef, State, StateRef, at

wp.set_module_options({"enable_backward": False})

HALVINGS = 30  # of the strains between which a tendon's is looked for
LARGEST_STRAIN = 0.5


@wp.struct
class Lever:
    """A pair of a muscle and a speed that it acts on."""

    crossing: int  # of the muscle's path
    body: int  # whose joint has the speed
    axis: int  # which of the joint's


@func
def fibre_forces(model: int, length: float, speed: float, cosine: float) -> wp.vec2:
    """Active force at full activation, and passive force, along the tendon and over f_max.

    Args:
        length: over l_opt. speed: over v_max. cosine: of the pennation.
    """
    v = wp.clamp(speed, -LARGEST_SPEED, LARGEST_SPEED)
    active = wp.max(active_force_length(model, length) * force_velocity(model, v, 1.0), 0.0)
    return wp.vec2(active, bounded_passive(model, length)) * cosine


@func
def strain_of(model: int, force: float) -> float:
    """Strain of a tendon that bears a force over f_max, by halving; none at no force."""
    low = wp.float32(0.0)
    high = wp.float32(LARGEST_STRAIN)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if tendon_force_strain(model, middle) < force:
            low = middle
        else:
            high = middle
    return low


@func
def lever_axis(instance: int, lever: Lever, model: ModelRef, work: ScratchRef) -> wp.vec3:
    """World axis along which moment arms of a joint's speed are kept, see `coordinate_joint.py`."""
    if has_motion(model.skeleton.plan[lever.body].joint_type):
        return coordinate_axis(instance, lever.body, model, work)
    return angular_axis(instance, lever.body, lever.axis, model, work)


@cache
def put_moments_of(paths: PathKind) -> Any:
    """The Warp function (instance, model, state, work, levers, arm, length, speed, moment_arm) of `muscle_moments_of`.

    Kinematics of the instance are found first, in its working set.
    """
    stretch_all = stretch_all_of(paths)

    @wp.func
    def put_moments(
        instance: int, model: ModelRef, state: StateRef, work: ScratchRef, levers: wp.array[Lever],
        arm: wp.array2d[wp.vec3], length: wp.array2d[float], speed: wp.array2d[float], moment_arm: wp.array2d[float],
    ):  # fmt: skip
        stretch_all(instance, model, state, work, length[instance], speed[instance], arm[instance])
        for k in range(levers.shape[0]):
            lever = levers[k]
            axis = lever_axis(instance, lever, model, work)
            moment_arm[instance, k] = -wp.dot(arm[instance, lever.crossing], axis)

    return put_moments


@cache
def muscle_moments_of(paths: PathKind) -> Any:
    """The kernel (model, state, workspace, levers, arm, length, speed, moment_arm) of all muscles in every frame.

    Args:
        paths: what is compiled in, as of `muscle_stage.MuscleKind`.

    What it gives:
        arm: (frames, crossings) m, room for moment arm vectors. length, speed: (frames, muscles) m and m/s, of paths.
        moment_arm: (frames, levers) m, -dl/dq: a tension F makes the generalised force F times it.
    """
    put_moments = put_moments_of(paths)

    @wp.kernel(
        module="unique",
        enable_backward=False,
        module_options={"enable_backward": False, "max_unroll": 1, **build_options()},
    )
    def kernel(
        # in
        model: Model, state: State, workspace: wp.array2d[float], levers: wp.array[Lever],
        # out
        arm: wp.array2d[wp.vec3], length: wp.array2d[float], speed: wp.array2d[float], moment_arm: wp.array2d[float],
    ):  # fmt: skip
        i = wp.tid()
        work = work_of(i, model, workspace)
        put_moments(i, model, state, work, levers, arm, length, speed, moment_arm)

    return kernel


class CurveFunctions(NamedTuple):
    """Warp functions of fibres with the curves of a kind of muscles."""

    forces: Any  # at full activation and at any, over f_max
    bounded_length: Any
    rigid_length: Any  # where tendons are rigid
    of_muscle: Any  # (instance, muscle, model): which curves a muscle has


def curve_functions(curves: int, own: CustomCurves | Shaped | None) -> CurveFunctions:
    """The functions for curves of a set or of one's own, as of `muscle_stage.MuscleKind`."""

    @wp.func
    def of_all(instance: int, m: int, model: ModelRef) -> int:
        return curves

    functions = (fibre_forces, bounded_fibre_length, rigid_fibre_length)
    return CurveFunctions(
        *(with_curves(function, own, curves) for function in functions),
        of_muscle=shaped_curves if isinstance(own, Shaped) else of_all,
    )


def has_cables(own: CustomCurves | Shaped | None) -> bool:
    """Whether some of the muscles are actuators or ligaments, which have no fibres."""
    return isinstance(own, Shaped) and own.cables


@cache
def put_fibre_forces_of(curves: int, own: CustomCurves | Shaped | None = None) -> Any:
    """The Warp function (instance, muscle, model, tendon and so on, as of `fibre_forces_of`) of forces of a muscle."""
    forces, bounded, rigid_length, curves_of = curve_functions(curves, own)
    shaped, cables = isinstance(own, Shaped), has_cables(own)

    @wp.func
    def put_fibre_forces(
        i: int, m: int, model: ModelRef, tendon: wp.array3d[float], length: wp.array2d[float],
        speed: wp.array2d[float], fibre: wp.array3d[float], active: wp.array2d[float], passive: wp.array2d[float],
    ):  # fmt: skip
        row = at(model.muscles.row, i, m)
        if wp.static(cables):  # noqa: SIM102, with `and` it would be compiled in all the same
            if is_cable(i, m, model):
                fibre[0, i, m] = 1.0
                fibre[1, i, m] = 0.0
                active[i, m] = 0.0
                passive[i, m] = ligament_force(i, m, length[i, m], speed[i, m], row, model)
                return
        of_muscle = curves_of(i, m, model)
        slack = row.l_slack
        stretching = wp.float32(0.0)
        if tendon.shape[0] > 0:
            slack = tendon[0, i, m]
            stretching = tendon[1, i, m]
        fibre_length = rigid_length(length[i, m], row.l_opt, slack, row.width)
        if wp.static(shaped):
            fibre_length = wp.max(fibre_length, bounded(of_muscle.row.shortest * row.l_opt, row.l_opt, row.width))
        fibre_speed = rigid_fibre_speed(speed[i, m] - stretching, fibre_length, row.width)
        x = fibre_length / row.l_opt
        v = fibre_speed / (row.v_max * row.l_opt)
        force = forces(of_muscle, x, v, pennation_cosine(fibre_length, row.width)) * row.f_max
        fibre[0, i, m] = x
        fibre[1, i, m] = v
        active[i, m] = force[0]
        passive[i, m] = force[1]

    return put_fibre_forces


@cache
def fibre_forces_of(curves: int, own: CustomCurves | Shaped | None = None) -> Any:
    """The kernel (model, tendon, length, speed, fibre, active, passive) of forces of all muscles in every frame.

    Args:
        curves, own: what is compiled in, as of `muscle_stage.MuscleKind`.

    What it takes and gives, all (frames, muscles):
        tendon: (2, frames, muscles) length of the tendon, m, and its lengthening speed, m/s; rigid ones where it is
            empty. length, speed: of paths, m and m/s.
        fibre: (2, frames, muscles) length over l_opt and speed over v_max of fibres.
        active, passive: N, along the tendon, at full activation and at any. Of a ligament its tension, of an actuator
            none: their fibres are told as of optimal length.
    """
    put_fibre_forces = put_fibre_forces_of(curves, own)

    @wp.kernel(
        module="unique",
        enable_backward=False,
        module_options={"enable_backward": False, "max_unroll": 1, **build_options()},
    )
    def kernel(
        # in
        model: Model, tendon: wp.array3d[float], length: wp.array2d[float], speed: wp.array2d[float],
        # out
        fibre: wp.array3d[float], active: wp.array2d[float], passive: wp.array2d[float],
    ):  # fmt: skip
        i, m = wp.tid()
        put_fibre_forces(i, m, model, tendon, length, speed, fibre, active, passive)

    return kernel


@cache
def tendon_lengths_of(curves: int, own: CustomCurves | Shaped | None = None) -> Any:
    """The kernel (muscles, force, length) of tendons that bear forces (frames, muscles), N: their lengths, m.

    Args:
        curves, own: what is compiled in, as of `muscle_stage.MuscleKind`.
    """
    strain = with_curves(strain_of, own, curves)
    shaped, cables = isinstance(own, Shaped), has_cables(own)

    @wp.func
    def of_all(instance: int, m: int, muscles: Muscles) -> int:
        return curves

    @wp.func
    def of_one(instance: int, m: int, muscles: Muscles) -> ShapedCurves:
        own_curves = ShapedCurves()
        own_curves.row = at(muscles.shape, instance, m)
        own_curves.table = muscles.curve_table
        return own_curves

    curves_of = of_one if shaped else of_all

    @wp.kernel(
        module="unique",
        enable_backward=False,
        module_options={"enable_backward": False, "max_unroll": 1, **build_options()},
    )
    def kernel(
        # in
        muscles: Muscles, force: wp.array2d[float],
        # out
        length: wp.array2d[float],
    ):  # fmt: skip
        i, m = wp.tid()
        row = at(muscles.row, i, m)
        if wp.static(cables):  # noqa: SIM102, as above
            if at(muscles.shape, i, m).curves >= PATH_ACTUATOR:
                length[i, m] = row.l_slack
                return
        of_muscle = curves_of(i, m, muscles)
        length[i, m] = row.l_slack * (1.0 + strain(of_muscle, force[i, m] / row.f_max))

    return kernel
