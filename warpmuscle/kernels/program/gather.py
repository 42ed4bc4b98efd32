"""What a decision of the controller is made from: the tasks, and what can be done for them."""

import warp as wp

from warpmuscle.kernels.contact.contact import body_weight
from warpmuscle.kernels.muscle.activation import activation_rate
from warpmuscle.kernels.object_structs import ObjectExtension
from warpmuscle.kernels.program.controller import BODY_FLOATS, REPORTED, BodyTask, JointTask, ProgramParameters
from warpmuscle.kernels.program.reduction import factorize, solve_weights
from warpmuscle.kernels.program.stepping import STEP_FLOATS, pendulum_wanted, plan_step, swing_task
from warpmuscle.kernels.program.structs import Columns, Frames, Layout, Programs, ProgramWork, TaskSums
from warpmuscle.kernels.program.supports import support_of
from warpmuscle.kernels.program.tasks import (
    LEAST_WEIGHT,
    body_task,
    center_task,
    center_wanted,
    contact_point,
    contact_task,
    joint_task,
    point_row,
)
from warpmuscle.kernels.structs import BALL, Model, ModelRef, MuscleRow, State, at

wp.set_module_options({"enable_backward": False, "max_unroll": 1})

STANDS_WITHIN = wp.constant(0.03)  # m, above the ground, where points of a foot that stands count as touching it
LEAVES_WITH = wp.constant(0.25)  # body weights along an edge under a foot that is about to be lifted


@wp.func
def remember_start(instance: int, layout: Layout, state: State, frames: Frames, memory: wp.array[float]):
    """Keep where an instance is at its start."""
    for k in range(state.coordinates.shape[1]):
        memory[layout.coordinates + k] = state.coordinates[instance, k]
    for body in range(frames.mass.shape[1]):
        own = layout.bodies + body * BODY_FLOATS
        memory[own] = 1.0
        for k in range(3):
            memory[own + 1 + k] = frames.position[instance, body][k]
        for k in range(4):
            memory[own + 4 + k] = frames.orientation[instance, body][k]
    for k in range(3):
        memory[layout.center + k] = frames.center[instance, 0][k]


@wp.kernel
def gather_tasks(
    # in
    chosen: wp.array[int], model: Model, state: State, frames: Frames, layout: Layout,
    parameters: wp.array2d[ProgramParameters], by_joint: wp.array2d[JointTask], by_body: wp.array2d[BodyTask],
    objects: ObjectExtension,
    # in and out
    memory: wp.array3d[float], programs: Programs, work: ProgramWork, pull: wp.array2d[float], row: wp.array3d[float],
    # out
    bound: wp.array2d[float],
):  # fmt: skip
    """Weights and wanted accelerations of the instances that are chosen, and how much their points of contact may bear.

    Returns:
        bound: (instances, points and supports) N along an edge; 0 where nothing is touched, or the foot swings.
    """
    i = chosen[wp.tid()]
    own = memory[i, 0]
    if own[layout.bodies] == 0.0:
        remember_start(i, layout, state, frames, own)
    p = at(parameters, i, 0)
    sums = TaskSums()
    sums.weight = programs.weight[i]
    sums.pull = pull[i]
    sums.row = row[i, 0]
    n = sums.row.shape[0]
    for s in range(n):
        sums.pull[s] = 0.0
        for q in range(n):
            sums.weight[s * n + q] = 0.0
        sums.weight[s * n + s] = LEAST_WEIGHT
    for body in range(model.body_count):
        if body > 0:
            task = at(by_joint, i, body)
            if task.weight > 0.0:
                joint_task(i, body, task, own[layout.coordinates : layout.bodies], model, state, sums)
        first = layout.bodies + body * BODY_FLOATS
        start = own[first : first + BODY_FLOATS]
        body_task(i, body, at(by_body, i, body), start, model.skeleton.plan, frames, sums)
    steps = plan_step(i, p, layout, model, state, frames, own[layout.steps : layout.steps + STEP_FLOATS])
    if steps.active == 1:
        wanted = pendulum_wanted(i, p, steps, frames)
        center_task(i, p.com_weight, wanted, model.skeleton.plan, frames, row[i, 1], sums)
        swing_task(i, p, steps, layout, model, frames, own, sums)
    elif p.com_weight > 0.0:
        c = layout.center
        wanted = center_wanted(i, p, wp.vec3(own[c], own[c + 1], own[c + 2]), frames)
        center_task(i, p.com_weight, wanted, model.skeleton.plan, frames, row[i, 1], sums)
    for k in range(layout.point.shape[0]):
        body = layout.point[k, 1]
        bound[i, k] = 0.0
        if body != steps.swing:
            margin = wp.where(body == steps.stands, STANDS_WITHIN, layout.margin)
            bound[i, k] = contact_task(i, body, layout.point[k, 0], p, margin, model, frames, sums)
        if body == steps.leaves:
            bound[i, k] = wp.min(bound[i, k], steps.share * LEAVES_WITH * body_weight(i, model))
    for k in range(layout.support.shape[0]):
        gap = support_of(i, k, layout, frames, objects).gap
        bears = p.support * body_weight(i, model)
        bound[i, layout.point.shape[0] + k] = wp.where(gap > layout.margin, 0.0, bears)
    factorize(n, sums.weight, work.factor[i])
    solve_weights(n, sums.pull, work.factor[i], work.vector[i, 0], programs.wanted[i])


@wp.func
def rest_of(activation: float, excitation: float, time: float, row: MuscleRow, scaled: int) -> float:
    """What part of its way to an excitation an activation has left after a time, s."""
    if scaled == 1:
        return wp.exp(-time * activation_rate(activation, excitation, row.rise_time, row.fall_time))
    return wp.exp(-time / wp.where(excitation > activation, row.rise_time, row.fall_time))


@wp.func
def spring_force(instance: int, body: int, k: int, model: ModelRef, state: State) -> float:
    """What the spring-damper of a joint of one coordinate asks for, N m; none of others."""
    plan = model.skeleton.plan[body]
    if plan.joint_type == BALL or plan.speed_end - plan.speed_start != 1:
        return 0.0
    q = state.coordinates[instance, plan.coordinate_start]
    speed = state.speeds[instance, plan.speed_start]
    return at(model.actuation.stiffness, instance, body) * q + at(model.actuation.damping, instance, body) * speed


@wp.func
def put_cone(
    instance: int, first: int, body: int, point: wp.vec3, normal: wp.vec3, friction: float, gain: float, most: float,
    model: ModelRef, frames: Frames, columns: Columns, row: wp.array[float], programs: Programs,
):  # fmt: skip
    """Let a point of a body be pushed along the four edges of a cone about a normal.

    Args:
        first: number of the first edge among the controls. point: world, m. most: N, along an edge.
    """
    front = wp.vec3(0.0, 0.0, 1.0)
    if wp.abs(normal[2]) > 0.9:
        front = wp.vec3(0.0, 1.0, 0.0)
    side = wp.normalize(wp.cross(normal, front))
    front = wp.cross(side, normal)
    for e in range(4):
        across = wp.where(e < 2, side, front) * wp.where(e % 2 == 0, friction, -friction)
        point_row(instance, body, point, normal + across, 0.0, model.skeleton.plan, frames, row)
        j = first + e
        for entry in range(columns.first[j], columns.first[j + 1]):
            programs.entry[instance, entry] = row[columns.row[entry]]
        programs.gain[instance, j] = gain
        programs.low[instance, j] = 0.0
        programs.high[instance, j] = most


@wp.kernel
def gather_forces(
    # in
    chosen: wp.array[int], model: Model, state: State, frames: Frames, layout: Layout,
    parameters: wp.array2d[ProgramParameters], by_joint: wp.array2d[JointTask], objects: ObjectExtension,
    columns: Columns,
    moment_arm: wp.array2d[float], active: wp.array2d[float], passive: wp.array2d[float], needed: wp.array2d[float],
    bearing: wp.array2d[float], row: wp.array3d[float],
    # out
    programs: Programs,
):  # fmt: skip
    """What muscles, torques and contacts can do for the instances that are chosen, and what acts whatever they do."""
    i = chosen[wp.tid()]
    p = at(parameters, i, 0)
    time = float(layout.every) * model.time_step
    for s in range(programs.bias.shape[1]):
        programs.bias[i, s] = needed[i, s]
    for body in range(1, model.body_count):
        first = model.skeleton.plan[body].speed_start
        programs.bias[i, first] = programs.bias[i, first] + spring_force(i, body, 0, model, state)
    muscles = model.muscles.count
    for m in range(muscles):
        for e in range(columns.first[m], columns.first[m + 1]):
            arm = moment_arm[i, layout.lever[e]]
            programs.entry[i, e] = arm * active[i, m]
            s = columns.row[e]
            programs.bias[i, s] = programs.bias[i, s] - arm * passive[i, m]
        muscle = at(model.muscles.row, i, m)
        a = state.muscles.activation[i, m]
        scaled = model.muscles.scaled_rates
        programs.gain[i, m] = 1.0 / p.effort
        programs.low[i, m] = a * rest_of(a, 0.0, time, muscle, scaled)
        programs.high[i, m] = 1.0 - (1.0 - a) * rest_of(a, 1.0, time, muscle, scaled)
    j = int(muscles)
    for k in range(layout.torque.shape[0]):
        bound = at(by_joint, i, layout.torque[k, 1]).torque
        programs.entry[i, columns.first[j]] = 1.0
        programs.gain[i, j] = wp.max(bound * bound, 1.0e-6) / p.torque_effort
        programs.low[i, j] = -bound
        programs.high[i, j] = bound
        j += 1
    weight = at(model.skeleton.total_mass, i, 0) * at(model.gravity, i, 0)
    gain = weight * weight / p.contact_effort
    for k in range(layout.point.shape[0]):
        body = layout.point[k, 1]
        point = frames.position[i, body] + contact_point(i, body, layout.point[k, 0], model, frames)
        up = at(model.contacts.normal, i, 0)
        put_cone(i, j, body, point, up, p.friction, gain, bearing[i, k], model, frames, columns, row[i, 0], programs)
        j += 4
    for k in range(layout.support.shape[0]):
        leant = support_of(i, k, layout, frames, objects)
        body = layout.support[k, 2]
        most = bearing[i, layout.point.shape[0] + k]
        rough = wp.min(p.friction, leant.friction)
        put_cone(i, j, body, leant.point, leant.normal, rough, gain, most, model, frames, columns, row[i, 0], programs)
        j += 4


@wp.kernel
def tell_muscles(
    # in
    chosen: wp.array[int], model: Model, state: State, layout: Layout, programs: Programs,
    control: wp.array2d[float], acceleration: wp.array2d[float], iterations: wp.array[int],
    # out
    memory: wp.array3d[float],
):  # fmt: skip
    """Excitations and efforts with which the instances that are chosen come to the controls that were found."""
    i = chosen[wp.tid()]
    time = float(layout.every) * model.time_step
    muscles = model.muscles.count
    for m in range(muscles):
        muscle = at(model.muscles.row, i, m)
        a = state.muscles.activation[i, m]
        aim = control[i, m]
        rest = rest_of(a, wp.where(aim > a, 1.0, 0.0), time, muscle, model.muscles.scaled_rates)
        memory[i, 0, REPORTED + m] = wp.clamp((aim - a * rest) / (1.0 - rest), 0.0, 1.0)
    for k in range(layout.torque.shape[0]):
        memory[i, 0, REPORTED + muscles + layout.torque[k, 0]] = control[i, muscles + k]
    n = acceleration.shape[1]
    unmet = wp.float32(0.0)
    for s in range(n):
        for q in range(n):
            away = programs.wanted[i, q] - acceleration[i, q]
            unmet += (programs.wanted[i, s] - acceleration[i, s]) * programs.weight[i, s * n + q] * away
    load = wp.float32(0.0)
    for j in range(muscles + layout.torque.shape[0], control.shape[1]):
        load += control[i, j]
    memory[i, 0, 0] = wp.sqrt(wp.max(unmet, 0.0))
    memory[i, 0, 1] = float(iterations[i])
    memory[i, 0, 2] = load
