"""Inverse dynamics: the generalised forces that a given motion needs, and what every joint transmits.

Recursive Newton-Euler (Featherstone 2008, ch. 5), world axes about each body's joint: accelerations go outwards, forces
come back inwards. Muscles, springs and contacts play no part; loads on bodies are given. A state is a frame here.
"""

import warp as wp

from warpmuscle.kernels.algebra.spatial import symmetric_times
from warpmuscle.kernels.body.joint_motion import has_motion
from warpmuscle.kernels.body.speed_axes import angular_axis, linear_axis, moving_speeds
from warpmuscle.kernels.stages import body_inertia, kinematics_stage, work_of
from warpmuscle.kernels.structs import FOLLOWER, Model, ModelRef, ScratchRef, State, nonnegative

wp.set_module_options({"enable_backward": False, "max_unroll": 1})


@wp.struct
class BodyLoads:
    """Forces on bodies in every frame, world axes."""

    body: wp.array[int]  # (loads,)
    force: wp.array2d[wp.vec3]  # (frames, loads) N
    point: wp.array2d[wp.vec3]  # (frames, loads) m
    moment: wp.array2d[wp.vec3]  # (frames, loads) N m, about the point


@wp.struct
class SpatialAcceleration:
    """How a body accelerates."""

    angular: wp.vec3  # rad/s^2
    linear: wp.vec3  # m/s^2, of its joint


@wp.struct
class Wrench:
    """A force and its moment about a joint, world axes."""

    moment: wp.vec3  # N m
    force: wp.vec3  # N


@wp.func
def body_acceleration(
    instance: int, body: int, parent: SpatialAcceleration, model: ModelRef, work: ScratchRef, rate: wp.array2d[float]
) -> SpatialAcceleration:
    """Acceleration of a body from its parent's and the rates of its joint's speeds (Featherstone 2008, eq. 5.6)."""
    found = SpatialAcceleration()
    if body > 0:
        above = nonnegative(model.skeleton.plan[body].parent)
        r = work.position[body] - work.position[above]
        w = work.angular_velocity[above]
        found.angular = parent.angular + work.bias[body]
        found.linear = parent.linear + wp.cross(parent.angular, r) + wp.cross(w, wp.cross(w, r))
        if has_motion(model.skeleton.plan[body].joint_type):
            found.linear += work.coordinate_drift[body]
    first = model.skeleton.plan[body].speed_start
    for k in range(moving_speeds(body, model)):
        found.angular += angular_axis(instance, body, k, model, work) * rate[instance, first + k]
        found.linear += linear_axis(body, k, model, work) * rate[instance, first + k]
    return found


@wp.func
def wrench_of_body(
    instance: int, body: int, acceleration: SpatialAcceleration, loads: BodyLoads, model: ModelRef, work: ScratchRef
) -> Wrench:
    """What a body alone needs from its joint: for its acceleration, against gravity and against its loads."""
    body_inertia(instance, body, model, work)
    a, b, c = work.block_a[body], work.block_b[body], work.block_c[body]
    found = Wrench()
    found.moment = symmetric_times(a, acceleration.angular) + b * acceleration.linear + work.bias_moment[body]
    found.force = wp.transpose(b) * acceleration.angular + symmetric_times(c, acceleration.linear)
    found.force += work.bias_force[body]
    for k in range(loads.body.shape[0]):
        if loads.body[k] == body:
            arm = loads.point[instance, k] - work.position[body]
            found.force -= loads.force[instance, k]
            found.moment -= loads.moment[instance, k] + wp.cross(arm, loads.force[instance, k])
    return found


@wp.func
def put_efforts(
    instance: int, model: ModelRef, work: ScratchRef, rate: wp.array2d[float], loads: BodyLoads,
    effort: wp.array2d[float], followed: wp.array2d[float], moment: wp.array2d[wp.vec3], force: wp.array2d[wp.vec3],
    position: wp.array2d[wp.vec3], orientation: wp.array2d[wp.quat],
):  # fmt: skip
    """Generalised forces and wrenches of an instance whose kinematics are known; see `inverse_dynamics`."""
    for body in range(model.body_count):  # accelerations wait in the places of wrenches
        above = SpatialAcceleration()
        if body > 0:
            parent = model.skeleton.plan[body].parent
            above.angular = moment[instance, parent]
            above.linear = force[instance, parent]
        own = body_acceleration(instance, body, above, model, work, rate)
        moment[instance, body] = own.angular
        force[instance, body] = own.linear
        position[instance, body] = work.position[body]
        orientation[instance, body] = work.orientation[body]
    for body in range(model.body_count):
        found = SpatialAcceleration()
        found.angular = moment[instance, body]
        found.linear = force[instance, body]
        needed = wrench_of_body(instance, body, found, loads, model, work)
        moment[instance, body] = needed.moment
        force[instance, body] = needed.force
    for s in range(effort.shape[1]):
        effort[instance, s] = 0.0
        followed[instance, s] = 0.0
    for back in range(model.body_count):
        body = model.body_count - 1 - back
        n = moment[instance, body]
        f = force[instance, body]
        first = model.skeleton.plan[body].speed_start
        for k in range(moving_speeds(body, model)):
            along = wp.dot(angular_axis(instance, body, k, model, work), n) + wp.dot(
                linear_axis(body, k, model, work), f
            )
            if model.skeleton.plan[body].joint_type == FOLLOWER:
                followed[instance, first + k] = followed[instance, first + k] + along
            else:
                effort[instance, first + k] = along
        if body > 0:
            parent = model.skeleton.plan[body].parent
            r = work.position[body] - work.position[parent]
            moment[instance, parent] = moment[instance, parent] + n + wp.cross(r, f)
            force[instance, parent] = force[instance, parent] + f


@wp.kernel
def inverse_dynamics(
    # in
    model: Model, state: State, workspace: wp.array2d[float], rate: wp.array2d[float], loads: BodyLoads,
    # out
    effort: wp.array2d[float], followed: wp.array2d[float], moment: wp.array2d[wp.vec3], force: wp.array2d[wp.vec3],
    position: wp.array2d[wp.vec3], orientation: wp.array2d[wp.quat],
):  # fmt: skip
    """Generalised forces of all speeds, and the wrench that every joint puts on its child, without muscles.

    Args:
        rate: (frames, speeds) of the speeds, m/s^2 and rad/s^2.

    Returns:
        effort: (frames, speeds) N and N m, without those of joints that follow others, which `followed` has.
        moment, force: (frames, bodies) N m about the joint of the body, and N; world axes.
        position, orientation: (frames, bodies) of the joint, m, and of the body; world axes.
    """
    i = wp.tid()
    work = work_of(i, model, workspace)
    kinematics_stage(i, 0, 1, model, state, work)
    put_efforts(i, model, work, rate, loads, effort, followed, moment, force, position, orientation)
