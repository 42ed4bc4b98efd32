"""Tasks of the controller as weights and wanted accelerations of the speeds: W, and W times what is wanted."""

import warp as wp

from warpmuscle.kernels.algebra.angles import pd_error
from warpmuscle.kernels.body.speed_axes import unit
from warpmuscle.kernels.contact.ground_plane import above_ground
from warpmuscle.kernels.control.joint_values import joint_coordinate, joint_speed, joint_speeds
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.program.controller import BodyTask, JointTask, ProgramParameters
from warpmuscle.kernels.program.structs import Frames, TaskSums
from warpmuscle.kernels.structs import BALL, BodyPlan, ModelRef, StateRef, at

LEAST_WEIGHT = 1.0e-6  # of every speed, so that W has an inverse


@func
def point_row(
    instance: int, body: int, point: wp.vec3, along: wp.vec3, turn: float, plan: wp.array[BodyPlan], frames: Frames,
    row: wp.array[float],
):  # fmt: skip
    """How speeds move a point of a body along an axis; or, if `turn` is 1, turn the body about it."""
    for s in range(row.shape[0]):
        row[s] = 0.0
    above = int(body)
    while above >= 0:
        arm = point - frames.position[instance, above]
        for s in range(plan[above].speed_start, plan[above].speed_end):
            angular = frames.angular[instance, s]
            if turn == 1.0:
                row[s] = wp.dot(along, angular)
            else:
                row[s] = wp.dot(along, frames.linear[instance, s] + wp.cross(angular, arm))
        above = plan[above].parent


@func
def add_task(weight: float, wanted: float, sums: TaskSums):
    """Add a task whose row is in `sums.row`; `wanted` is what speeds have to give beside the drift."""
    n = sums.row.shape[0]
    for i in range(n):
        own = weight * sums.row[i]
        if own != 0.0:
            sums.pull[i] = sums.pull[i] + own * wanted
            for j in range(n):
                sums.weight[i * n + j] = sums.weight[i * n + j] + own * sums.row[j]


@func
def joint_task(
    instance: int, body: int, task: JointTask, start: wp.array[float], model: ModelRef, state: StateRef, sums: TaskSums
):
    """Where a joint is to be: where it was at the start, and `move` further."""
    n = sums.row.shape[0]
    first = model.skeleton.plan[body].speed_start
    place = model.skeleton.plan[body].coordinate_start
    count = joint_speeds(body, model)
    error = wp.vec3(0.0)
    if model.skeleton.plan[body].joint_type == BALL:
        now = wp.quat(
            joint_coordinate(instance, body, 0, model, state),
            joint_coordinate(instance, body, 1, model, state),
            joint_coordinate(instance, body, 2, model, state),
            joint_coordinate(instance, body, 3, model, state),
        )
        error = pd_error(now, wp.quat(start[place], start[place + 1], start[place + 2], start[place + 3]))
    else:
        for k in range(count):
            error[k] = start[place + k] - joint_coordinate(instance, body, k, model, state)
        error[0] = error[0] + task.move
    for k in range(count):
        wanted = task.kp * error[k] - task.kd * joint_speed(instance, body, k, model, state)
        s = first + k
        sums.weight[s * n + s] = sums.weight[s * n + s] + task.weight
        sums.pull[s] = sums.pull[s] + task.weight * wanted


@func
def body_point_acceleration(instance: int, body: int, arm: wp.vec3, frames: Frames) -> wp.vec3:
    """Acceleration of a point of a body, `arm` from its joint, where speeds do not change."""
    spin = frames.angular_velocity[instance, body]
    turning = wp.cross(frames.turning_drift[instance, body], arm)
    return frames.drift[instance, body] + turning + wp.cross(spin, wp.cross(spin, arm))


@func
def body_task(
    instance: int, body: int, task: BodyTask, start: wp.array[float], plan: wp.array[BodyPlan], frames: Frames,
    sums: TaskSums,
):  # fmt: skip
    """Where a point of a body is to be, and how the body is to be turned.

    Args:
        start: of the body, position and orientation at the start of the instance.
    """
    orientation = frames.orientation[instance, body]
    spin = frames.angular_velocity[instance, body]
    before = wp.quat(start[4], start[5], start[6], start[7])
    if task.weight > 0.0:
        local = wp.vec3(task.point_x, task.point_y, task.point_z)
        arm = wp.quat_rotate(orientation, local)
        point = frames.position[instance, body] + arm
        target = wp.vec3(start[1] + task.move_x, start[2] + task.move_y, start[3] + task.move_z)
        target += wp.quat_rotate(before, local)
        velocity = frames.velocity[instance, body] + wp.cross(spin, arm)
        wanted = (target - point) * task.kp - velocity * task.kd
        wanted -= body_point_acceleration(instance, body, arm, frames)
        for axis in range(3):
            point_row(instance, body, point, unit(axis), 0.0, plan, frames, sums.row)
            add_task(task.weight, wanted[axis], sums)
    if task.turn_weight > 0.0:
        error = wp.quat_rotate(orientation, pd_error(orientation, before))
        wanted = error * task.turn_kp - spin * task.turn_kd - frames.turning_drift[instance, body]
        for axis in range(3):
            point_row(instance, body, frames.position[instance, body], unit(axis), 1.0, plan, frames, sums.row)
            add_task(task.turn_weight, wanted[axis], sums)


@func
def center_wanted(instance: int, task: ProgramParameters, start: wp.vec3, frames: Frames) -> wp.vec3:
    """Wanted acceleration of the centre of mass that is to be where it was at the start, and so much further."""
    target = start + wp.vec3(task.com_x, task.com_y, task.com_z)
    return (target - frames.center[instance, 0]) * task.com_kp - frames.center[instance, 1] * task.com_kd


@func
def center_task(
    instance: int, weight: float, acceleration: wp.vec3, plan: wp.array[BodyPlan], frames: Frames, row: wp.array[float],
    sums: TaskSums,
):  # fmt: skip
    """How the centre of mass is to accelerate; `row` has room for how speeds move a part of it."""
    bodies = frames.mass.shape[1]
    total = wp.float32(0.0)
    drift = wp.vec3(0.0)
    for body in range(bodies):
        mass = frames.mass[instance, body]
        total += mass
        drift += body_point_acceleration(instance, body, frames.com[instance, body], frames) * mass
    wanted = acceleration - drift / total
    for axis in range(3):
        for s in range(sums.row.shape[0]):
            sums.row[s] = 0.0
        for body in range(bodies):
            share = frames.mass[instance, body] / total
            point = frames.position[instance, body] + frames.com[instance, body]
            point_row(instance, body, point, unit(axis), 0.0, plan, frames, row)
            for s in range(sums.row.shape[0]):
                sums.row[s] = sums.row[s] + share * row[s]
        add_task(weight, wanted[axis], sums)


@func
def contact_point(instance: int, body: int, k: int, model: ModelRef, frames: Frames) -> wp.vec3:
    """Where a contact point of a body would touch the ground, m from the body's joint, world axes."""
    point = at(model.contacts.point, instance, k)
    arm = wp.quat_rotate(frames.orientation[instance, body], point.place)
    return arm - at(model.contacts.normal, instance, 0) * point.radius


@func
def contact_task(
    instance: int, body: int, k: int, task: ProgramParameters, margin: float, model: ModelRef, frames: Frames,
    sums: TaskSums,
) -> float:  # fmt: skip
    """A point on the ground is to rest there; how much it may bear: 0 off the ground, farther than the margin, m."""
    arm = contact_point(instance, body, k, model, frames)
    point = frames.position[instance, body] + arm
    if above_ground(instance, point, model) > margin:
        return 0.0
    velocity = frames.velocity[instance, body] + wp.cross(frames.angular_velocity[instance, body], arm)
    wanted = -velocity * task.contact_damping - body_point_acceleration(instance, body, arm, frames)
    for axis in range(3):
        point_row(instance, body, point, unit(axis), 0.0, model.skeleton.plan, frames, sums.row)
        add_task(task.contact_weight, wanted[axis], sums)
    return float(wp.inf)
