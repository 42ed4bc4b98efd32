"""Where bodies are, how they move, and along what each speed moves them: all that tasks need to know of them."""

import warp as wp

from warpmuscle.kernels.body.composite_bodies import add_mass_matrix
from warpmuscle.kernels.body.speed_axes import angular_axis, linear_axis, moving_speeds
from warpmuscle.kernels.inverse.inverse_dynamics import BodyLoads, SpatialAcceleration, body_acceleration, put_efforts
from warpmuscle.kernels.program.structs import Frames
from warpmuscle.kernels.stages import kinematics_stage, work_of
from warpmuscle.kernels.structs import Model, ModelRef, ScratchRef, State, at

wp.set_module_options({"enable_backward": False, "max_unroll": 1})


@wp.func
def put_frames(instance: int, model: ModelRef, work: ScratchRef, no_rate: wp.array2d[float], frames: Frames):
    """Put in the frames of an instance whose kinematics are known."""
    for body in range(model.body_count):
        frames.position[instance, body] = work.position[body]
        frames.orientation[instance, body] = work.orientation[body]
        frames.velocity[instance, body] = work.velocity[body]
        frames.angular_velocity[instance, body] = work.angular_velocity[body]
        row = at(model.skeleton.row, instance, body)
        frames.com[instance, body] = work.rotation[body] * row.com
        frames.mass[instance, body] = row.mass
        first = model.skeleton.plan[body].speed_start
        for k in range(moving_speeds(body, model)):
            frames.angular[instance, first + k] = angular_axis(instance, body, k, model, work)
            frames.linear[instance, first + k] = linear_axis(body, k, model, work)
        above = SpatialAcceleration()
        if body > 0:
            parent = model.skeleton.plan[body].parent
            above.angular = frames.turning_drift[instance, parent]
            above.linear = frames.drift[instance, parent]
        own = body_acceleration(instance, body, above, model, work, no_rate)
        frames.turning_drift[instance, body] = own.angular
        frames.drift[instance, body] = own.linear
    for k in range(2):
        frames.center[instance, k] = work.center[k]


@wp.kernel
def look_at_bodies(
    # in
    chosen: wp.array[int], model: Model, state: State, workspace: wp.array2d[float], no_rate: wp.array2d[float],
    no_loads: BodyLoads,
    # out
    frames: Frames, mass: wp.array3d[float], needed: wp.array2d[float], followed: wp.array2d[float],
    moment: wp.array2d[wp.vec3], force: wp.array2d[wp.vec3], position: wp.array2d[wp.vec3],
    orientation: wp.array2d[wp.quat],
):  # fmt: skip
    """Frames, mass matrices, and forces that hold speeds as they are, of the instances that are chosen.

    Args:
        no_rate: (instances, speeds) zeros. no_loads: none.

    Returns:
        mass: (instances, speeds, speeds). The others are as of `inverse_dynamics`.
    """
    i = chosen[wp.tid()]
    work = work_of(i, model, workspace)
    kinematics_stage(i, 0, 1, model, state, work)
    put_frames(i, model, work, no_rate, frames)
    put_efforts(i, model, work, no_rate, no_loads, needed, followed, moment, force, position, orientation)
    for s in range(mass.shape[1]):
        for q in range(mass.shape[2]):
            mass[i, s, q] = 0.0
    add_mass_matrix(i, model, state, work, mass)
