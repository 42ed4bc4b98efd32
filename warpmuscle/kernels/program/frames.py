"""Where bodies are, how they move, and along what each speed moves them: all that tasks need to know of them."""

import warp as wp

from warpmuscle.kernels.body.speed_axes import angular_axis, linear_axis, moving_speeds
from warpmuscle.kernels.inverse.inverse_dynamics import SpatialAcceleration, body_acceleration
from warpmuscle.kernels.program.structs import Frames
from warpmuscle.kernels.stages import kinematics_stage, work_of
from warpmuscle.kernels.structs import Model, State, at

wp.set_module_options({"enable_backward": False, "max_unroll": 1})


@wp.kernel
def body_frames(
    # in
    model: Model, state: State, workspace: wp.array2d[float], no_rate: wp.array2d[float],
    # out
    frames: Frames,
):  # fmt: skip
    """Put in the frames of all instances; `no_rate` (instances, speeds) are zeros."""
    i = wp.tid()
    work = work_of(i, model, workspace)
    kinematics_stage(i, 0, 1, model, state, work)
    for body in range(model.body_count):
        frames.position[i, body] = work.position[body]
        frames.orientation[i, body] = work.orientation[body]
        frames.velocity[i, body] = work.velocity[body]
        frames.angular_velocity[i, body] = work.angular_velocity[body]
        row = at(model.skeleton.row, i, body)
        frames.com[i, body] = work.rotation[body] * row.com
        frames.mass[i, body] = row.mass
        first = model.skeleton.plan[body].speed_start
        for k in range(moving_speeds(body, model)):
            frames.angular[i, first + k] = angular_axis(i, body, k, model, work)
            frames.linear[i, first + k] = linear_axis(body, k, model, work)
        above = SpatialAcceleration()
        if body > 0:
            parent = model.skeleton.plan[body].parent
            above.angular = frames.turning_drift[i, parent]
            above.linear = frames.drift[i, parent]
        own = body_acceleration(i, body, above, model, work, no_rate)
        frames.turning_drift[i, body] = own.angular
        frames.drift[i, body] = own.linear
    for k in range(2):
        frames.center[i, k] = work.center[k]
