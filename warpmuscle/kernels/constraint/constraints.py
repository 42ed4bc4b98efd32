"""Constraints between bodies that joints do not join: loops of bodies, closed by forces that do no work.

A constraint holds one to six numbers g(q) at 0. Row by row it is a push W on a body, a force at a point or a moment,
and the same backwards on another body, so that with their accelerations a the number's is g'' = W . a + c. The size
x of the push is one more unknown of the equations in `body.followed`, to which it gives

    U = -W on the one body and W on the other,    R = U . a = c - g'' wanted,

where D has -J M^-1 J^T between pushes, so that one recursion serves both; `solution.py` solves them. What is
wanted keeps g at 0 against rounding and the errors of steps of the length h (Baumgarte 1972, Comput. Methods Appl.
Mech. Eng. 1:1-16, here in units of a time t):

    g'' = -DAMPING (g' - h c'/2)/t - STIFFNESS g/t^2,    t = max(h, QUICKEST),

where g' = J v is of the speeds in the middle of the last step, which leapfrog moves coordinates by, and c' = g'' - J v'
is what speeds alone make of it: where all is well, J at the end of the step times these speeds is h c'/2.
"""

import warp as wp

from warpmuscle.kernels.body.joint_motion import has_motion
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at, nonnegative

WELD, POINT, POINT_ON_LINE, DISTANCE = 0, 1, 2, 3
DAMPING, STIFFNESS = 0.5, 0.2
QUICKEST = 5.0e-4  # s, in which errors go at most, since rounding of places counts by 1/s^2
SHORTEST = 1.0e-6  # m, distance whose direction is known


@wp.struct
class Between:
    """Where the points of a constraint are and how they move, world."""

    arm: wp.vec3  # m, from the body's joint
    other_arm: wp.vec3  # m, from the other body's joint
    offset: wp.vec3  # m, of the body's point from the other one's
    speed: wp.vec3  # m/s, of the body's point over the other one's
    lag: wp.vec3  # m/s, what that gained in the last half step
    drift: wp.vec3  # m/s^2, what speeds alone add to W . a in the acceleration of that
    total_drift: wp.vec3  # m/s^2, and what they make of W . a themselves


@wp.struct
class StepLength:
    """The step, and how long speeds have changed since the middle of the last one."""

    pace: float  # s, in which errors go: the step, or QUICKEST
    half: float  # s; 0 in the first step


@func
def wanted_acceleration(error: float, rate: float, drift: float, total_drift: float, step: StepLength) -> float:
    """What W . a should be of a number g = error, which accelerates by W . a + drift.

    Args:
        rate: of g, by speeds in the middle of the last step. total_drift: of g, where no speed changes.
    """
    astray = rate - step.half * total_drift
    return -drift - (DAMPING * astray + STIFFNESS * error / step.pace) / step.pace


@func
def store_row(row: int, force: wp.vec3, moment: wp.vec3, other_moment: wp.vec3, wanted: float, work: ScratchRef):
    """Keep a row: a force, and its moments about the joints of both bodies; and what W . a should be."""
    work.push_force[row] = force
    work.push_moment[row] = moment
    work.push_other_moment[row] = other_moment
    work.push_wanted[row] = wanted


@func
def push_along(row: int, axis: wp.vec3, error: float, more: float, step: StepLength, b: Between, work: ScratchRef):
    """The row of a force along an axis at both points.

    Args:
        more: m/s^2, drift besides that of the points along the axis.
    """
    drift = wp.dot(axis, b.drift) + more
    rate = wp.dot(axis, b.speed - b.lag)
    wanted = wanted_acceleration(error, rate, drift, wp.dot(axis, b.total_drift) + more, step)
    store_row(row, axis, wp.cross(b.arm, axis), wp.cross(b.other_arm, axis), wanted, work)


@func
def speeds_alone(body: int, place: wp.vec3, model: ModelRef, work: ScratchRef) -> wp.spatial_vector:
    """Angular acceleration of a body, and acceleration of its point at a place, where no speed changes."""
    turning = wp.vec3(0.0)
    moving = wp.vec3(0.0)
    i = nonnegative(body)
    while i > 0:
        parent = nonnegative(model.skeleton.plan[i].parent)
        v = work.angular_velocity[parent]
        turning += work.bias[i]
        moving += wp.cross(v, wp.cross(v, work.position[i] - work.position[parent]))
        moving += wp.cross(work.bias[i], place - work.position[i])
        if has_motion(model.skeleton.plan[i].joint_type):
            moving += work.coordinate_drift[i]
        i = parent
    w = work.angular_velocity[body]
    return wp.spatial_vector(turning, moving + wp.cross(w, wp.cross(w, place - work.position[body])))


@func
def between_points(
    body: int, other: int, arm: wp.vec3, other_arm: wp.vec3, model: ModelRef, work: ScratchRef
) -> Between:  # fmt: skip
    """How two points of two bodies lie and move."""
    w = work.angular_velocity[body]
    v = work.angular_velocity[other]
    place = work.position[body] + arm
    other_place = work.position[other] + other_arm
    b = Between()
    b.arm = arm
    b.other_arm = other_arm
    b.offset = place - other_place
    b.speed = work.velocity[body] + wp.cross(w, arm) - work.velocity[other] - wp.cross(v, other_arm)
    b.lag = work.lag_velocity[body] + wp.cross(work.lag_angular[body], arm)
    b.lag = b.lag - work.lag_velocity[other] - wp.cross(work.lag_angular[other], other_arm)
    b.drift = wp.cross(w, wp.cross(w, arm)) - wp.cross(v, wp.cross(v, other_arm))
    alone = speeds_alone(body, place, model, work) - speeds_alone(other, other_place, model, work)
    b.total_drift = wp.spatial_bottom(alone)
    return b


@func
def column(m: wp.mat33, k: int) -> wp.vec3:
    """A column of a matrix."""
    return wp.vec3(m[0, k], m[1, k], m[2, k])


@func
def turn_between(axes: wp.mat33, other_axes: wp.mat33) -> wp.vec3:
    """The turn from the other axes to these, rad, if it is small."""
    turn = wp.vec3(0.0)
    for k in range(3):
        turn += 0.5 * wp.cross(column(other_axes, k), column(axes, k))
    return turn


@func
def constraint_rows(instance: int, number: int, step: StepLength, model: ModelRef, work: ScratchRef):
    """The rows of one constraint."""
    plan = model.constraints.plan[number]
    given = at(model.constraints.row, instance, number)
    body = nonnegative(plan.body)
    other = nonnegative(plan.other)
    row = nonnegative(plan.first_row)
    arm = work.rotation[body] * given.place
    other_arm = work.rotation[other] * given.other_place
    b = between_points(body, other, arm, other_arm, model, work)
    other_axes = work.rotation[other] * given.other_axes
    if plan.kind == DISTANCE:
        length = wp.max(wp.length(b.offset), SHORTEST)
        axis = b.offset / length
        along = wp.dot(axis, b.speed)
        more = (wp.dot(b.speed, b.speed) - along * along) / length
        push_along(row, axis, length - given.distance, more, step, b, work)
    elif plan.kind == POINT_ON_LINE:  # forces meet the other body where the point is now
        c = between_points(body, other, arm, other_arm + b.offset, model, work)
        coriolis = wp.cross(-2.0 * work.angular_velocity[other], c.speed)
        for k in range(2):
            axis = column(other_axes, k + 1)
            push_along(row + k, axis, wp.dot(axis, b.offset), wp.dot(axis, coriolis), step, c, work)
    else:
        for k in range(3):
            axis = wp.vec3(0.0)
            axis[k] = 1.0
            push_along(row + k, axis, b.offset[k], 0.0, step, b, work)
    if plan.kind == WELD:
        turn = turn_between(work.rotation[body] * given.axes, other_axes)
        rate = work.angular_velocity[body] - work.lag_angular[body]
        rate = rate - work.angular_velocity[other] + work.lag_angular[other]
        place = work.position[body]
        alone = speeds_alone(body, place, model, work) - speeds_alone(other, place, model, work)
        for k in range(3):
            axis = wp.vec3(0.0)
            axis[k] = 1.0
            wanted = wanted_acceleration(turn[k], rate[k], 0.0, wp.spatial_top(alone)[k], step)
            store_row(row + 3 + k, wp.vec3(0.0), axis, axis, wanted, work)


@func
def constraint_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """The rows of all constraints, one a lane, before prescribed accelerations are known. Ends with a barrier."""
    step = StepLength()
    step.pace = wp.max(model.time_step, QUICKEST)
    step.half = wp.where(state.step[instance] == 0, 0.0, 0.5 * model.time_step)
    for number in range(lane, model.constraints.plan.shape[0], lanes):
        constraint_rows(instance, number, step, model, work)
    synchronize()


@func
def pushed(body: int, row: int, model: ModelRef, work: ScratchRef) -> wp.spatial_vector:
    """What a unit of a push adds to U of a body."""
    u = wp.spatial_vector(wp.vec3(0.0), wp.vec3(0.0))
    if row >= 0:
        if model.constraints.body[row] == body:
            u = -wp.spatial_vector(work.push_moment[row], work.push_force[row])
        if model.constraints.other[row] == body:
            u = wp.spatial_vector(work.push_other_moment[row], work.push_force[row])
    return u
