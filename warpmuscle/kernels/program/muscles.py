"""What muscles can do for the instances that decide, see `kernels.inverse.muscle_moments`."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.curve.custom_curves import CustomCurves
from warpmuscle.kernels.curve.shaped_curves import Shaped
from warpmuscle.kernels.inverse.muscle_moments import Lever, put_fibre_forces_of, put_moments_of
from warpmuscle.kernels.path.stretch import PathKind
from warpmuscle.kernels.stages import work_of
from warpmuscle.kernels.structs import Model, State


@cache
def chosen_moments_of(paths: PathKind) -> Any:
    """The kernel of `muscle_moments_of` for chosen instances, whose numbers come first."""
    put_moments = put_moments_of(paths)

    @wp.kernel(module="unique", enable_backward=False, module_options={"enable_backward": False, "max_unroll": 1})
    def kernel(
        # in
        chosen: wp.array[int], model: Model, state: State, workspace: wp.array2d[float], levers: wp.array[Lever],
        # out
        arm: wp.array2d[wp.vec3], length: wp.array2d[float], speed: wp.array2d[float], moment_arm: wp.array2d[float],
    ):  # fmt: skip
        i = chosen[wp.tid()]
        work = work_of(i, model, workspace)
        put_moments(i, model, state, work, levers, arm, length, speed, moment_arm)

    return kernel


@cache
def chosen_forces_of(curves: int, own: CustomCurves | Shaped | None = None) -> Any:
    """The kernel of `fibre_forces_of` for all muscles of chosen instances, whose numbers come first."""
    put_fibre_forces = put_fibre_forces_of(curves, own)

    @wp.kernel(module="unique", enable_backward=False, module_options={"enable_backward": False, "max_unroll": 1})
    def kernel(
        # in
        chosen: wp.array[int], model: Model, tendon: wp.array3d[float], length: wp.array2d[float],
        speed: wp.array2d[float],
        # out
        fibre: wp.array3d[float], active: wp.array2d[float], passive: wp.array2d[float],
    ):  # fmt: skip
        one, m = wp.tid()
        put_fibre_forces(chosen[one], m, model, tendon, length, speed, fibre, active, passive)

    return kernel
