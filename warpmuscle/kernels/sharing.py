"""The wanted torques of joints shared out among all muscles that cross them, by least effort.

A muscle can have the forces passive_i + a_i active_i, 0 <= a_i <= 1, at the length and speed that its fibre has now.
Wanted are the activations of least

    sum_i m_i a_i^2 + sum_j |T_j - sum_i r_ij (passive_i + a_i active_i)|^2 / s_j

with the muscles' masses m_i, their moment arms r_ij, and the torques T_j, all along those degrees of freedom of the
joints that muscles drive. Torque that is missing costs 1/SOFTNESS times the effort of making it, roughly: s_j is that
part of sum_i |g_ij|^2, with g_ij = r_ij active_i / sqrt(m_i). In x_i = sqrt(m_i) a_i the solution is

    x_i = clamp(sum_j g_ij . v_j, 0, sqrt(m_i)),    s_j v_j = T_j - sum_i r_ij passive_i - sum_i g_ij x_i

so that all that is to be found is a vector v_j for each joint, what it pays for torque. One sweep is one step of
Newton's method for each joint (as muscles change between bounds, a semismooth one; Qi 1993), first for joints of odd
depth in the tree, then for even ones, so that neighbours, whom muscles over two joints couple, know of each other. As
a price is not to grow without end for torque that no muscle gives, it has a bound.

A joint's sums run over its muscles in one lane, in their order, so that the bits do not depend on the lanes.
"""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.actuation import ball_projector, hinge_projector
from warpmuscle.kernels.muscle import SMALLEST_COSINE, along_tendon, pennation_cosine
from warpmuscle.kernels.path import PathState
from warpmuscle.kernels.scratch import synchronize
from warpmuscle.kernels.spatial import symmetric, symmetric_outer
from warpmuscle.kernels.structs import BALL, UNIVERSAL, ModelRef, MuscleRow, ScratchRef, StateRef, at, rolled, whole

SOFTNESS = 1.0e-3
DEAREST = 5.0  # of the price at which all muscles that pull one way would be fully active
RELAXATION = 1.2  # of a step of Newton's method
AT_BOUND = 0.1  # weight of a muscle at a bound in that method, so that prices do not jump when all are
MARGIN = 0.05  # of full activation, within which a muscle at a bound counts as if it were not
WEAKEST = 1.0e-3  # active force over f_max, so that nothing is divided by zero
NEAR = 0.02  # activation up to which a muscle that shortens fast is activated before it pulls
SMALLEST = 1.0e-12  # share of a muscle that is free to change
SWEEPS = {1: 4, 2: 5}  # by the greatest number of driven joints that a muscle crosses
MANY_SWEEPS = 8  # if it is greater
ROWS_A_MUSCLE = 2  # of the state, see `kept_rows`


class Places(NamedTuple):
    """Warp functions that read and write, of all muscles, what the joints gather of them."""

    arms: Any  # (instance, state, work) -> (crossings,) m, then scaled
    get: Any  # (instance, muscle, model, state, work) -> its share
    put: Any  # (instance, muscle, share, model, state, work)


@wp.struct
class Shared:
    """What the first pass over the muscles keeps of one for the second."""

    moving: float  # m, see `path.PathState`
    speed: float  # m/s
    scale: float  # active force over the square root of the mass, of the moment arms
    idle: float  # activation from which on there is active force


# Shares. A share is x, and carries its sign: positive while the muscle is free to do more or less.


@wp.func
def share_of(bid: float, most: float) -> float:
    """Share of a muscle to which its joints bid sum g . v, at most sqrt(m); negative where it is at a bound."""
    share = wp.clamp(bid, 0.0, most)
    beyond = wp.abs(bid - share) - MARGIN * most  # no branch, which the CPU would not foresee
    return wp.where(beyond < 0.0, wp.max(share, SMALLEST), -share)


@wp.func
def strength_of(half: float, full: float, least: float, f_max: float) -> wp.vec3:
    """What a muscle has of its forces at activations of 1/2 and 1, which lie on a line.

    Returns:
        Passive force, N, which it has at the least activation; active force, N; and the activation from which on there
        is any of that: a fibre that shortens fast takes some before damping leaves any force.
    """
    slope = 2.0 * (full - half)
    at_none = full - slope
    passive = wp.max(at_none + least * slope, 0.0)
    start = wp.max(-at_none, 0.0) / wp.max(slope, WEAKEST * f_max)
    return wp.vec3(passive, wp.max(full - passive, WEAKEST * f_max), wp.max(start, least))


@wp.func
def activation_of(part: float, idle: float) -> float:
    """Activation with which a muscle has so much of its active force, 0..1; none for none."""
    return (1.0 - idle) * part + idle * wp.min(part * wp.static(1.0 / NEAR), 1.0)


@wp.func
def symmetric_solution(s: symmetric, v: wp.vec3) -> wp.vec3:
    """S^-1 v by elimination, exact enough also where S is nearly singular, as of hinges, which cofactors are not."""
    p = 1.0 / s[0]
    a = s[1] * p
    b = s[2] * p
    q = 1.0 / (s[3] - a * s[1])
    below = s[4] - a * s[2]
    c = below * q
    y = v[1] - a * v[0]
    z = (v[2] - b * v[0] - c * y) / (s[5] - b * s[2] - c * below)
    y = y * q - c * z
    return wp.vec3(v[0] * p - a * y - b * z, y, z)


@wp.func
def newton_step(inertia: symmetric, residual: wp.vec3, soft: float) -> wp.vec3:
    """Change of a price: (sum of w g g^T + s 1)^-1 residual, relaxed."""
    return symmetric_solution(inertia + symmetric(soft, 0.0, 0.0, soft, 0.0, soft), residual) * RELAXATION


@wp.func
def within_length(v: wp.vec3, most: float) -> wp.vec3:
    """The vector, shortened to a length if it is longer."""
    length = wp.length(v)
    return v * wp.where(length > most, most / wp.max(length, SMALLEST), 1.0)


# Where things are.


@wp.func
def kept_rows(model: ModelRef) -> int:
    """First row of `MuscleState.moment_arm` behind the moment arms; two for each muscle and one for each body follow.

    Of a muscle: length and speed of the path and scale; activation before the pull, and share. Of a body: its price.
    """
    return whole(model.paths.crossing_start[model.body_count])


@wp.func
def arms_in_state(instance: int, state: StateRef, work: ScratchRef) -> wp.array[wp.vec3]:
    """Where the moment arms of an instance are kept: in the state."""
    return state.muscles.moment_arm[instance]


@wp.func
def arms_at_hand(instance: int, state: StateRef, work: ScratchRef) -> wp.array[wp.vec3]:
    """The same: in the working set."""
    return work.pull


@wp.func
def share_in_state(instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    return state.muscles.moment_arm[instance, kept_rows(model) + 2 * muscle + 1][1]


@wp.func
def put_in_state(instance: int, muscle: int, share: float, model: ModelRef, state: StateRef, work: ScratchRef):
    row = kept_rows(model) + 2 * muscle + 1
    state.muscles.moment_arm[instance, row] = wp.vec3(state.muscles.moment_arm[instance, row][0], share, 0.0)


@wp.func
def share_at_hand(instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    return work.share[whole(muscle)]


@wp.func
def put_at_hand(instance: int, muscle: int, share: float, model: ModelRef, state: StateRef, work: ScratchRef):
    work.share[whole(muscle)] = share


IN_STATE = Places(arms_in_state, share_in_state, put_in_state)
AT_HAND = Places(arms_at_hand, share_at_hand, put_at_hand)


@wp.func
def keep(instance: int, muscle: int, shared: Shared, model: ModelRef, state: StateRef):
    """Keep of a muscle what the second pass needs."""
    row = kept_rows(model) + 2 * muscle
    state.muscles.moment_arm[instance, row] = wp.vec3(shared.moving, shared.speed, shared.scale)
    state.muscles.moment_arm[instance, row + 1] = wp.vec3(shared.idle, 0.0, 0.0)


@wp.func
def kept(instance: int, muscle: int, model: ModelRef, state: StateRef) -> Shared:
    """What was kept."""
    row = kept_rows(model) + 2 * muscle
    first = state.muscles.moment_arm[instance, row]
    s = Shared()
    s.moving = first[0]
    s.speed = first[1]
    s.scale = first[2]
    s.idle = state.muscles.moment_arm[instance, row + 1][0]
    return s


@wp.func
def driven_part(instance: int, body: int, model: ModelRef, work: ScratchRef) -> wp.mat33:
    """Projects a torque on what acts along those degrees of freedom of a joint that muscles drive, world axes."""
    plan = model.skeleton.plan[body]
    row = at(model.skeleton.row, instance, body)
    weight = model.actuation.by_muscles[body]
    rotation = work.rotation[body]
    if plan.joint_type == BALL:
        return ball_projector(rotation, weight)
    a = rotation * row.axis_a
    if plan.joint_type == UNIVERSAL:
        b = work.rotation[whole(plan.parent)] * row.axis_b
        if weight[0] * weight[1] > 0.0:
            c = wp.normalize(wp.cross(a, b))
            return wp.identity(n=3, dtype=float) - wp.outer(c, c)
        return hinge_projector(a, weight[0]) + hinge_projector(b, weight[1])
    return hinge_projector(a, weight[0])


@wp.func
def rescale(instance: int, muscle: int, factor: float, model: ModelRef, arm: wp.array[wp.vec3]):
    """Multiply all moment arms of a muscle."""
    span = model.paths.span[muscle]
    for k in range(span.first_crossing, span.end_crossing):
        rolled()
        crossing = whole(model.paths.of_muscle[whole(k)].number)
        arm[crossing] = arm[crossing] * factor


@wp.func
def as_stretched(instance: int, muscle: int, stretch: PathState, row: MuscleRow, model: ModelRef, state: StateRef):
    """The stretch with which a rigid tendon would give a fibre the length and speed that it has on a compliant one.

    Before the first step, and of a muscle without such a tendon, it is the one that is given.
    """
    length = state.muscles.fibre_length[instance, muscle]
    if length > 0.0:
        speed = (length - state.muscles.previous_fibre_length[instance, muscle]) / model.time_step
        stretch.moving = along_tendon(length, row.width) + row.l_slack - stretch.fixed
        stretch.speed = speed / wp.max(pennation_cosine(length, row.width), SMALLEST_COSINE)
    return stretch


@cache
def prepare_of(
    places: Places, stretch_stage: Any, contraction: Any, straight: bool, ideal: bool, elastic: bool, floored: bool
) -> Any:
    """The function (instance, muscle, model, state, work) that says what a muscle can do, before `sharing_stage_of`.

    Args:
        stretch_stage: of `path.stretch_of`. contraction: with rigid tendons, of `contraction.contraction_of`.
        straight: whether paths are straight. ideal: whether force needs no contraction. elastic: whether some tendons
            are compliant. floored: whether activations have a minimum.
    """
    arms, _, put = places

    @wp.func
    def prepare(instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef):
        row = at(model.muscles.row, instance, muscle)
        arm = arms(instance, state, work)
        stretch = stretch_stage(instance, muscle, model, state, work, arm)
        if wp.static(straight):
            arm[stretch.crossing] = stretch.arm
        strength = wp.vec3(0.0, row.f_max, 0.0)
        shared = Shared()
        shared.moving = stretch.moving
        shared.speed = stretch.speed
        if wp.static(not ideal):
            if wp.static(elastic):
                stretch = as_stretched(instance, muscle, stretch, row, model, state)
            half = contraction(instance, muscle, 0.5, stretch, row, model, state)
            most = contraction(instance, muscle, 1.0, stretch, row, model, state)
            least = wp.float32(0.0)
            if wp.static(floored):
                least = at(model.muscles.shape, instance, muscle).minimum_activation
            strength = strength_of(half.force, most.force, least, row.f_max)
        shared.scale = strength[1] / wp.sqrt(at(model.muscles.mass, instance, muscle))
        shared.idle = strength[2]
        rescale(instance, muscle, shared.scale, model, arm)
        keep(instance, muscle, shared, model, state)
        put(instance, muscle, strength[0] / shared.scale, model, state, work)

    return prepare


@cache
def sharing_stage_of(places: Places, joints: int) -> Any:
    """The stage that shares out what the joints want; before and after it `muscle_stage` passes over the muscles.

    It takes moment arms times the muscles' scales, and as shares passive forces over scales. It leaves the shares. It
    starts and ends with a barrier.

    Args:
        joints: driven joints that a muscle crosses at most.
    """
    arms, get, put = places
    coupled, weighted, sweeps = joints > 1, joints > 2, SWEEPS.get(joints, MANY_SWEEPS)

    @wp.func
    def ask(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef):
        """What a joint wants of its muscles beside their passive forces, and what it pays at first: as a step ago."""
        arm = arms(instance, state, work)
        part = driven_part(instance, body, model, work)
        lack = part * work.torque[body]
        square = wp.float32(0.0)
        mass = wp.float32(0.0)
        for c in range(model.paths.crossing_start[body], model.paths.crossing_start[body + 1]):
            rolled()
            crossing = whole(c)
            muscle = whole(model.paths.crossing_muscle[crossing])
            g = part * arm[crossing]
            arm[crossing] = g
            lack -= g * get(instance, muscle, model, state, work)
            square += wp.length_sq(g)
            own_mass = at(model.muscles.mass, instance, muscle)
            mass += own_mass
            if wp.static(not coupled):
                put(instance, muscle, wp.sqrt(own_mass), model, state, work)
        work.lack[body] = lack
        work.softness[body] = SOFTNESS * square + SMALLEST
        work.dearest[body] = wp.where(square > 0.0, DEAREST * wp.sqrt(mass / (square + SMALLEST)), 0.0)
        before = part * state.muscles.moment_arm[instance, kept_rows(model) + 2 * model.muscles.count + body]
        work.price[body] = within_length(before, work.dearest[body])

    @wp.func
    def bid(instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef):
        """Share of a muscle at the present prices."""
        arm = arms(instance, state, work)
        span = model.paths.span[muscle]
        total = wp.float32(0.0)
        for k in range(span.first_crossing, span.end_crossing):
            rolled()
            crossing = model.paths.of_muscle[whole(k)]
            total += wp.dot(arm[whole(crossing.number)], work.price[whole(crossing.joint)])
        share = share_of(total, wp.sqrt(at(model.muscles.mass, instance, muscle)))
        put(instance, muscle, share, model, state, work)

    @wp.func
    def adjust(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef):
        """Change the price of a joint for what it lacks."""
        arm = arms(instance, state, work)
        if work.dearest[body] > 0.0:  # muscles drive it
            soft = work.softness[body]
            price = work.price[body]
            residual = work.lack[body] - price * soft
            inertia = symmetric(0.0)
            for c in range(model.paths.crossing_start[body], model.paths.crossing_start[body + 1]):
                rolled()
                crossing = whole(c)
                muscle = whole(model.paths.crossing_muscle[crossing])
                g = arm[crossing]
                share = get(instance, muscle, model, state, work)
                if wp.static(not coupled):
                    share = share_of(wp.dot(g, price), share)
                residual -= g * wp.abs(share)
                weight = wp.where(share > 0.0, 1.0, AT_BOUND)
                if wp.static(weighted):  # joints of one parity that a muscle crosses change their prices at once
                    span = model.paths.span[muscle]
                    weight *= float((span.end_crossing - span.first_crossing + 1) // 2)
                inertia += symmetric_outer(g, weight)
            work.price[body] = within_length(price + newton_step(inertia, residual, soft), work.dearest[body])

    @wp.func
    def bids(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
        for m in range(lane, model.muscles.count, lanes):
            bid(instance, m, model, state, work)
        synchronize()

    @wp.func
    def sharing_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
        synchronize()
        for body in range(1 + lane, model.body_count, lanes):
            ask(instance, body, model, state, work)
        synchronize()
        if wp.static(coupled):  # each function at one place only, else the GPU's compiler does not put it in there
            for half in range(wp.static(2 * sweeps + 1)):
                rolled()
                bids(instance, lane, lanes, model, state, work)
                if half < wp.static(2 * sweeps):
                    for level in range(1 + (half & 1), model.level_count, 2):
                        for body in range(whole(model.level_start[level] + lane), model.level_start[level + 1], lanes):
                            adjust(instance, body, model, state, work)
                    synchronize()
        else:
            for _ in range(wp.static(sweeps)):
                rolled()
                for body in range(1 + lane, model.body_count, lanes):  # every joint by itself, without a barrier
                    adjust(instance, body, model, state, work)
            synchronize()
            bids(instance, lane, lanes, model, state, work)
        for body in range(1 + lane, model.body_count, lanes):
            row = kept_rows(model) + 2 * model.muscles.count + body
            state.muscles.moment_arm[instance, row] = work.price[body]

    return sharing_stage
