"""Constraints between bodies that joints do not join: loops of bodies, closed by forces that do no work.

A constraint holds one to six numbers g(q) at 0. Row by row it is a push W on a body, a force at a point or a moment,
and the same backwards on another body, so that with their accelerations a the number's is g'' = W . a + c. The size
x of the push is one more unknown of the equations in `followed.py`, to which it gives

    U = -W on the one body and W on the other,    R = U . a = c - g'' wanted,

where D has -J M^-1 J^T between pushes, so that one recursion serves both. Rows that push as others together do share
what there is to push, since each gives way by a little, E x, and one along which nothing can move is left out. What
the pushes give way is taken back (iterated regularisation, Riley 1955, Math. Tables Aids Comput. 9:96-101),

    x = d_0 + d_1 + ...,    (J M^-1 J^T + E) d_0 = r,    (J M^-1 J^T + E) d_n = E d_(n-1),

until it is less than GIVING. Where nothing moves, all d_n are d_0, which is of rounding alone: where the sum ends at
its greatest length N, the last term counts 1 - N times, so that they add up to one d_0. What is wanted keeps g at 0
against rounding and the errors of steps of the length h (Baumgarte 1972, Comput. Methods Appl. Mech. Eng. 1:1-16, here
in units of a time t):

    g'' = -DAMPING (g' - h c'/2)/t - STIFFNESS g/t^2,    t = max(h, QUICKEST),

where g' = J v is of the speeds in the middle of the last step, which leapfrog moves coordinates by, and c' = g'' - J v'
is what speeds alone make of it: where all is well, J at the end of the step times these speeds is h c'/2.
"""

import warp as wp

from warpmuscle.kernels.body.joint_motion import has_motion
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import any_lane, synchronize
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at, nonnegative

WELD, POINT, POINT_ON_LINE, DISTANCE = 0, 1, 2, 3
DAMPING, STIFFNESS = 0.5, 0.2
YIELDING = 2.0e-5  # of the greatest mobility along rows that hold one point or one turn, by which each gives way
GIVING = 3.0e-7  # m or rad, that the last pushes may give way by, where more are not added
REFINEMENTS = 8  # times that pushes are added, at most
IMMOBILE = 1.0e-8  # of what bodies may move by, below which nothing can move along a row
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


@func
def free_mobility(instance: int, row: int, model: ModelRef, work: ScratchRef) -> float:
    """Along a row at the most, if no joint held its two bodies; of a force without what it turns."""
    one = at(model.skeleton.row, instance, nonnegative(model.constraints.body[row]))
    other = at(model.skeleton.row, instance, nonnegative(model.constraints.other[row]))
    if wp.length(work.push_force[row]) > 0.0:
        return 1.0 / one.mass + 1.0 / other.mass
    return 1.0 / wp.min(one.inertia) + 1.0 / wp.min(other.inertia)


@func
def mobilities(instance: int, count: int, first: int, model: ModelRef, work: ScratchRef):
    """The greatest one of the rows that hold one thing, such as a point, together with each row; 0: nothing moves.

    What is rounded off the way of a push to the root and back is a share of what moves most along any row, or of what
    moves if no joint holds the bodies, whichever is less: so light parts say nothing of heavy ones.
    """
    largest = wp.float32(0.0)
    for row in range(first, count):
        largest = wp.max(largest, wp.abs(work.followed_matrix[row * count + row]))
    for row in range(first, count):
        greatest = wp.float32(0.0)
        for beside in range(first, count):
            if model.constraints.held[beside - first] == model.constraints.held[row - first]:
                greatest = wp.max(greatest, wp.abs(work.followed_matrix[beside * count + beside]))
        least = IMMOBILE * wp.min(largest, free_mobility(instance, row - first, model, work))
        work.push_mobility[row - first] = wp.where(greatest > least, greatest, 0.0)


@func
def eliminate(lane: int, lanes: int, k: int, count: int, work: ScratchRef):
    """Take an unknown out of the equations behind it. What stands below the pivot stays there, for later right sides.

    Each lane takes other rows. Ends with a barrier.
    """
    pivot = work.followed_matrix[k * count + k]
    if pivot != 0.0:
        for i in range(k + 1 + lane, count, lanes):
            factor = work.followed_matrix[i * count + k] / pivot
            for l in range(k + 1, count):  # noqa: E741
                taken = factor * work.followed_matrix[k * count + l]
                work.followed_matrix[i * count + l] = work.followed_matrix[i * count + l] - taken
            work.followed_acceleration[i] = work.followed_acceleration[i] - factor * work.followed_acceleration[k]
    synchronize()


@func
def eliminate_right(lane: int, lanes: int, count: int, first: int, work: ScratchRef):
    """Do to a new right side of the pushes, in `push_wanted`, what has been done to the first one. With barriers."""
    for k in range(first, count):
        pivot = work.followed_matrix[k * count + k]
        if pivot != 0.0:
            share = work.push_wanted[k - first] / pivot
            for i in range(k + 1 + lane, count, lanes):
                taken = work.followed_matrix[i * count + k] * share
                work.push_wanted[i - first] = work.push_wanted[i - first] - taken
        synchronize()


@func
def add_pushes(weight: float, lane: int, lanes: int, count: int, first: int, work: ScratchRef):
    """Pushes of a right side in `push_wanted`, in its place; so many times they are added to those of before.

    With barriers.
    """
    for step in range(count - first):
        k = count - 1 - step
        pivot = work.followed_matrix[k * count + k]
        push = wp.float32(0.0)
        if pivot != 0.0:
            push = work.push_wanted[k - first] / pivot
        for i in range(first + lane, k, lanes):
            taken = work.followed_matrix[i * count + k] * push
            work.push_wanted[i - first] = work.push_wanted[i - first] - taken
        synchronize()
        if lane == 0:
            work.push_wanted[k - first] = push
            work.followed_acceleration[k] = work.followed_acceleration[k] + weight * push
    synchronize()


@func
def gives(count: int, first: int, model: ModelRef, work: ScratchRef) -> bool:
    """Whether constraints give way by more than they may by the pushes that were added last."""
    pace = wp.max(model.time_step, QUICKEST)
    largest = wp.float32(0.0)
    for row in range(count - first):
        largest = wp.max(largest, wp.abs(work.push_mobility[row] * work.push_wanted[row]))
    return YIELDING * largest * pace * pace > STIFFNESS * GIVING


@func
def refine(lane: int, lanes: int, count: int, first: int, model: ModelRef, work: ScratchRef):
    """Add pushes that take back what the last ones, in `push_wanted`, give way. With barriers.

    Instances of one block go on together; those that are done add 0.
    """
    turn = wp.int32(0)  # a variable, for the loop
    again = gives(count, first, model, work)
    while any_lane(again) and turn < REFINEMENTS:
        for k in range(first + lane, count, lanes):
            yielding = wp.where(again, YIELDING * work.push_mobility[k - first], 0.0)
            work.push_wanted[k - first] = -yielding * work.push_wanted[k - first]
        synchronize()
        eliminate_right(lane, lanes, count, first, work)
        turn += 1
        weight = wp.where(turn == REFINEMENTS, 1.0 - wp.float32(REFINEMENTS), 1.0)
        add_pushes(weight, lane, lanes, count, first, work)
        again = again and gives(count, first, model, work)


@func
def solve_constrained(instance: int, lane: int, lanes: int, model: ModelRef, work: ScratchRef):
    """`followed.solve_followed` where rows from the first on are of pushes: D is negative there."""
    count = nonnegative(model.couplings.followed)
    first = nonnegative(model.constraints.first)
    for k in range(first):
        eliminate(lane, lanes, k, count, work)
    if lane == 0:
        mobilities(instance, count, first, model, work)
        for k in range(first, count):
            work.followed_matrix[k * count + k] -= YIELDING * work.push_mobility[k - first]
    synchronize()
    for k in range(first, count):
        if lane == 0 and work.push_mobility[k - first] == 0.0:
            work.followed_matrix[k * count + k] = 0.0
        synchronize()
        eliminate(lane, lanes, k, count, work)
    for k in range(first + lane, count, lanes):
        work.push_wanted[k - first] = work.followed_acceleration[k]
        work.followed_acceleration[k] = 0.0
    synchronize()
    add_pushes(1.0, lane, lanes, count, first, work)
    refine(lane, lanes, count, first, model, work)
    if lane == 0:
        for step in range(first):
            k = first - 1 - step
            right = work.followed_acceleration[k]
            for l in range(k + 1, count):  # noqa: E741
                right -= work.followed_matrix[k * count + l] * work.followed_acceleration[l]
            work.followed_acceleration[k] = right / work.followed_matrix[k * count + k]
