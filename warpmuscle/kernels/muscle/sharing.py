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

from warpmuscle.kernels.algebra.spatial import symmetric, symmetric_outer
from warpmuscle.kernels.force.actuation import ball_projector, hinge_projector
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.muscle.sharing_rules import SMALLEST, newton_step, share_of, within_length
from warpmuscle.kernels.structs import (
    BALL,
    UNIVERSAL,
    ModelRef,
    ScratchRef,
    SharedMuscle,
    StateRef,
    at,
    nonnegative,
    not_unrolled,
)

SOFTNESS = 1.0e-3
DEAREST = 5.0  # of the price at which all muscles that pull one way would be fully active
AT_BOUND = 0.1  # weight of a muscle at a bound in Newton's method, so that prices do not jump when all are
SWEEPS = {1: 4, 2: 5}  # by the greatest number of driven joints that a muscle crosses
MANY_SWEEPS = 8  # if it is greater


class Places(NamedTuple):
    """Warp functions that read and write, of all muscles, what the joints gather of them."""

    arms: Any  # (instance, state, work) -> (crossings,) m, then scaled
    get: Any  # (instance, muscle, state, work) -> its share
    put: Any  # (instance, muscle, share, state, work)


@func
def arms_in_state(instance: int, state: StateRef, work: ScratchRef) -> wp.array[wp.vec3]:
    """Where the moment arms of an instance are kept: in the state."""
    return state.muscles.moment_arm[instance]


@func
def arms_in_scratch(instance: int, state: StateRef, work: ScratchRef) -> wp.array[wp.vec3]:
    """The same: in the working set."""
    return work.pull


@func
def share_in_state(instance: int, muscle: int, state: StateRef, work: ScratchRef) -> float:
    return state.muscles.sharing.share[instance, muscle]


@func
def put_in_state(instance: int, muscle: int, share: float, state: StateRef, work: ScratchRef):
    state.muscles.sharing.share[instance, muscle] = share


@func
def share_in_scratch(instance: int, muscle: int, state: StateRef, work: ScratchRef) -> float:
    return work.share[nonnegative(muscle)]


@func
def put_in_scratch(instance: int, muscle: int, share: float, state: StateRef, work: ScratchRef):
    work.share[nonnegative(muscle)] = share


IN_STATE = Places(arms_in_state, share_in_state, put_in_state)
IN_SCRATCH = Places(arms_in_scratch, share_in_scratch, put_in_scratch)


def places_of(in_scratch: bool) -> Places:
    """Where moment arms and shares are: in the working set, or in the state."""
    return IN_SCRATCH if in_scratch else IN_STATE


@func
def kept(instance: int, muscle: int, state: StateRef) -> SharedMuscle:
    """What the first pass over the muscles kept of one for the second."""
    return state.muscles.sharing.muscle[instance, muscle]


@func
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
        b = work.rotation[nonnegative(plan.parent)] * row.axis_b
        if weight[0] * weight[1] > 0.0:
            c = wp.normalize(wp.cross(a, b))
            return wp.identity(n=3, dtype=float) - wp.outer(c, c)
        return hinge_projector(a, weight[0]) + hinge_projector(b, weight[1])
    return hinge_projector(a, weight[0])


@func
def rescale(instance: int, muscle: int, factor: float, model: ModelRef, arm: wp.array[wp.vec3]):
    """Multiply all moment arms of a muscle."""
    span = model.paths.span[muscle]
    for k in range(span.first_crossing, span.end_crossing):
        not_unrolled()
        crossing = nonnegative(model.paths.of_muscle[nonnegative(k)].number)
        arm[crossing] = arm[crossing] * factor


@cache
def prepare_of(places: Places, stretch_stage: Any, strength_of: Any, straight: bool) -> Any:
    """The function (instance, muscle, model, state, work) that says what a muscle can do, before `sharing_stage_of`.

    Args:
        stretch_stage: of `path.stretch_of`. strength_of: of the muscles' law, see `muscle_kind.MuscleLaw`.
        straight: whether paths are straight.
    """
    arms, put = places.arms, places.put

    @wp.func
    def prepare(instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef):
        row = at(model.muscles.row, instance, muscle)
        arm = arms(instance, state, work)
        stretch = stretch_stage(instance, muscle, model, state, work, arm)
        if wp.static(straight):
            arm[stretch.crossing] = stretch.arm
        strength = strength_of(instance, muscle, stretch, row, model, state)
        shared = SharedMuscle()
        shared.moving = stretch.moving
        shared.speed = stretch.speed
        shared.scale = strength[1] / wp.sqrt(at(model.muscles.mass, instance, muscle))
        shared.idle = strength[2]
        rescale(instance, muscle, shared.scale, model, arm)
        state.muscles.sharing.muscle[instance, muscle] = shared
        put(instance, muscle, strength[0] / shared.scale, state, work)

    return prepare


@cache
def ask_of(places: Places, coupled: bool) -> Any:
    """The Warp function of what a joint wants beside passive forces, and what it pays at first: as a step ago.

    Args:
        coupled: whether some muscles cross several joints.
    """
    arms, get, put = places

    @wp.func
    def ask(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef):
        arm = arms(instance, state, work)
        part = driven_part(instance, body, model, work)
        lack = part * work.torque[body]
        square = wp.float32(0.0)
        mass = wp.float32(0.0)
        for c in range(model.paths.crossing_start[body], model.paths.crossing_start[body + 1]):
            not_unrolled()
            crossing = nonnegative(c)
            muscle = nonnegative(model.paths.crossing_muscle[crossing])
            g = part * arm[crossing]
            arm[crossing] = g
            lack -= g * get(instance, muscle, state, work)
            square += wp.length_sq(g)
            own_mass = at(model.muscles.mass, instance, muscle)
            mass += own_mass
            if wp.static(not coupled):
                put(instance, muscle, wp.sqrt(own_mass), state, work)
        work.lack[body] = lack
        work.softness[body] = SOFTNESS * square + SMALLEST
        work.dearest[body] = wp.where(square > 0.0, DEAREST * wp.sqrt(mass / (square + SMALLEST)), 0.0)
        before = part * state.muscles.sharing.price[instance, body]
        work.price[body] = within_length(before, work.dearest[body])

    return ask


@cache
def bid_of(places: Places) -> Any:
    """The Warp function that gives a muscle its share at the present prices."""
    arms, put = places.arms, places.put

    @wp.func
    def bid(instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef):
        arm = arms(instance, state, work)
        span = model.paths.span[muscle]
        total = wp.float32(0.0)
        for k in range(span.first_crossing, span.end_crossing):
            not_unrolled()
            crossing = model.paths.of_muscle[nonnegative(k)]
            total += wp.dot(arm[nonnegative(crossing.number)], work.price[nonnegative(crossing.joint)])
        share = share_of(total, wp.sqrt(at(model.muscles.mass, instance, muscle)))
        put(instance, muscle, share, state, work)

    return bid


@cache
def adjust_of(places: Places, coupled: bool, weighted: bool) -> Any:
    """The Warp function that changes the price of a joint for what it lacks.

    Args:
        coupled: whether some muscles cross several joints. weighted: whether some cross more than two.
    """
    arms, get = places.arms, places.get

    @wp.func
    def adjust(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef):
        arm = arms(instance, state, work)
        if work.dearest[body] > 0.0:  # muscles drive it
            soft = work.softness[body]
            price = work.price[body]
            residual = work.lack[body] - price * soft
            inertia = symmetric(0.0)
            for c in range(model.paths.crossing_start[body], model.paths.crossing_start[body + 1]):
                not_unrolled()
                crossing = nonnegative(c)
                muscle = nonnegative(model.paths.crossing_muscle[crossing])
                g = arm[crossing]
                share = get(instance, muscle, state, work)
                if wp.static(not coupled):
                    share = share_of(wp.dot(g, price), share)
                residual -= g * wp.abs(share)
                weight = wp.where(share > 0.0, 1.0, AT_BOUND)
                if wp.static(weighted):  # joints of one parity that a muscle crosses change their prices at once
                    span = model.paths.span[muscle]
                    weight *= float((span.end_crossing - span.first_crossing + 1) // 2)
                inertia += symmetric_outer(g, weight)
            work.price[body] = within_length(price + newton_step(inertia, residual, soft), work.dearest[body])

    return adjust


@cache
def sharing_stage_of(places: Places, joints: int) -> Any:
    """The stage that shares out what the joints want; before and after it `muscle_stage` passes over the muscles.

    It takes moment arms times the muscles' scales, and as shares passive forces over scales. It leaves the shares. It
    starts and ends with a barrier.

    Args:
        joints: driven joints that a muscle crosses at most.
    """
    coupled, sweeps = joints > 1, SWEEPS.get(joints, MANY_SWEEPS)
    ask, bid, adjust = ask_of(places, coupled), bid_of(places), adjust_of(places, coupled, joints > 2)

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
                not_unrolled()
                bids(instance, lane, lanes, model, state, work)
                if half < wp.static(2 * sweeps):
                    for level in range(1 + (half & 1), model.level_count, 2):
                        for body in range(
                            nonnegative(model.level_start[level] + lane), model.level_start[level + 1], lanes
                        ):
                            adjust(instance, body, model, state, work)
                    synchronize()
        else:
            for _ in range(wp.static(sweeps)):
                not_unrolled()
                for body in range(1 + lane, model.body_count, lanes):  # every joint by itself, without a barrier
                    adjust(instance, body, model, state, work)
            synchronize()
            bids(instance, lane, lanes, model, state, work)
        for body in range(1 + lane, model.body_count, lanes):
            state.muscles.sharing.price[instance, body] = work.price[body]

    return sharing_stage
