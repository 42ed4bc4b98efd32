"""What muscles put on the bodies beyond every joint: forces along their lines of action, and moments about joints."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.body.coordinate_joint import coordinate_velocities
from warpmuscle.kernels.functions import build_options
from warpmuscle.kernels.path.path import joint_velocities
from warpmuscle.kernels.path.stretch import PathKind, any_stretch_of
from warpmuscle.kernels.stages import kinematics_stage, work_of
from warpmuscle.kernels.structs import Model, State


@cache
def muscle_wrenches_of(paths: PathKind) -> Any:
    """The kernel (model, state, workspace, tension, line, moment, force) of all muscles in every frame.

    Args:
        paths: what is compiled in, as of `muscle_stage.MuscleKind`; without polynomials.

    What it takes and gives, world axes:
        tension: (frames, muscles) N. line: (frames, 2 bodies) room for lines of action.
        moment, force: (frames, bodies) N m about the joint of a body, and N, upon that body and all that it carries.
    """
    any_stretch = any_stretch_of(paths, pulleys=False, coordinate_joints=True, followers=True, wrench=True)

    @wp.kernel(
        module="unique",
        enable_backward=False,
        module_options={"enable_backward": False, "max_unroll": 1, **build_options()},
    )
    def kernel(
        # in
        model: Model, state: State, workspace: wp.array2d[float], tension: wp.array2d[float],
        # out
        line: wp.array2d[wp.vec3], moment: wp.array2d[wp.vec3], force: wp.array2d[wp.vec3],
    ):  # fmt: skip
        i = wp.tid()
        work = work_of(i, model, workspace)
        kinematics_stage(i, 0, 1, model, state, work)
        joint_velocities(0, 1, model, work)
        coordinate_velocities(i, 0, 1, model, work)
        for muscle in range(model.muscles.count):
            for k in range(2 * model.body_count):
                line[i, k] = wp.vec3(0.0)
            any_stretch(i, muscle, model, state, work, line[i])
            for body in range(1, model.body_count):
                moment[i, body] = moment[i, body] - line[i, body] * tension[i, muscle]
                force[i, body] = force[i, body] - line[i, model.body_count + body] * tension[i, muscle]

    return kernel
