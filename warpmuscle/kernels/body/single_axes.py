"""The recursion of `followed.py` for bodies whose joints all have one axis, or none: vectors in place of matrices.

A joint's S, I S and d are then one column and one number, and so are S . U_k and d S . U_k, of which only the first
components are kept. Results are those of `followed_reduction.py`, which multiplies by columns of zeros.

Bodies that are only children come one behind the other in a run (`body_structs.BodyRun`), in which lanes go from its
tip to its first body without waiting for others, and keep what each body leaves for the one before it to themselves.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import (
    cross_rows,
    shifted_angular,
    symmetric_outer,
    symmetric_times,
)
from warpmuscle.kernels.body.dynamics import Articulated
from warpmuscle.kernels.body.followed_reduction import entry_of, followed_of, gather, gather_with_pushes
from warpmuscle.kernels.body.joint_motion import has_motion
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.main_memory import ahead_of_reducing, rotation_of
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import FIXED, ModelRef, ScratchRef, at, component, nonnegative, set_component


@wp.struct
class SingleJoint:
    """A joint of one speed, or of none, whose axis is 0, and what moves it."""

    turning: wp.vec3  # S, angular half
    moving: wp.vec3  # S, linear half
    moment: wp.vec3  # I S
    force: wp.vec3
    d: float  # (S . I S + K)^-1; 0 if a followed coordinate moves the joint
    q: float  # acceleration where the parent has none
    row: int  # which followed coordinate moves it; -1: none
    free: int  # 1: forces move it
    r: wp.vec3  # m, from the parent's joint
    bias: wp.vec3  # rad/s^2, that its body turns by at constant speeds
    drift: wp.vec3  # m/s^2, that its place moves by


@wp.struct
class Task:
    """What a lane does in a run."""

    run: int
    helper: int  # of the lanes that go along it; none of them: as many as there are
    helpers: int
    leaver: int  # the one that leaves the inertia
    sharing: int  # how many share the unknowns


@func
def begin_run(first: int, width: int, lane: int, lanes: int, model: ModelRef) -> Task:
    """What a lane does with some runs of a level, as many as lanes or fewer: each has a lane, the others help.

    More of them help where more unknowns act.
    """
    runs = model.couplings.run
    t = Task()
    base = runs[nonnegative(first)].before
    t.run = first + wp.min(lane, width - 1)
    extra = lanes - width
    last = nonnegative(first + width - 1)
    unknowns = runs[last].before + runs[last].unknowns - base
    if extra == 0 or unknowns == 0:
        extra = 0
        unknowns = 1
    own = (lane - width) * unknowns
    if lane >= width and extra > 0:
        for k in range(first, first + width):
            if (runs[nonnegative(k)].before - base) * extra <= own:
                t.run = k
    run = runs[nonnegative(t.run)]
    before = ((run.before - base) * extra + unknowns - 1) // unknowns
    helping = ((run.before - base + run.unknowns) * extra + unknowns - 1) // unknowns - before
    t.helpers = 1 + helping
    t.helper = wp.where(lane < width, 0, wp.where(extra > 0, 1 + lane - width - before, t.helpers))
    t.sharing = t.helpers
    if t.helpers > run.unknowns:
        t.leaver = run.unknowns
        t.sharing = wp.max(run.unknowns, 1)
    return t


@func
def add_children(body: int, x: wp.ref[Articulated], model: ModelRef, work: ScratchRef):
    """Add what the children of the last body of a run have left."""
    first = model.skeleton.plan[body].first_child
    for child in range(first, first + model.skeleton.plan[body].child_count):
        x.a += work.block_a[child]
        x.b += work.block_b[child]
        x.c += work.block_c[child]
        x.n += work.bias_moment[child]
        x.f += work.bias_force[child]


@cache
def take_body_of(hybrid: bool) -> Any:
    """The Warp function that adds a body to what hangs on it, and finds its joint."""
    followed = followed_of(hybrid)

    @func
    def take_body(
        instance: int, body: int, x: wp.ref[Articulated], j: wp.ref[SingleJoint], model: ModelRef, work: ScratchRef
    ):
        skeleton = model.skeleton
        kind = skeleton.plan[body].joint_type
        coordinate = has_motion(kind)
        if wp.static(hybrid):
            kind = model.motion.remaining[body]
        parent = nonnegative(skeleton.plan[body].parent)
        # all of it is asked for at once, which takes as long as any one
        turning = work.coordinate_turning[body]
        moving = work.coordinate_moving[body]
        coordinate_drift = work.coordinate_drift[body]
        axis = rotation_of(body, work) * at(skeleton.row, instance, body).axis_a
        stiffness = work.stiffness[body]
        torque = work.torque[body]
        x.a = work.block_a[body] + x.a
        x.b = work.block_b[body] + x.b
        x.c = work.block_c[body] + x.c
        x.n = work.bias_moment[body] + x.n
        x.f = work.bias_force[body] + x.f
        j.row = followed(body, model)
        j.free = wp.where(kind != FIXED and j.row < 0, 1, 0)
        j.bias = work.bias[body]
        j.r = work.position[body] - work.position[parent]
        w = work.angular_velocity[parent]
        j.drift = wp.cross(w, wp.cross(w, j.r))
        j.turning = wp.vec3(0.0)
        j.moving = wp.vec3(0.0)
        j.moment = wp.vec3(0.0)
        j.force = wp.vec3(0.0)
        j.d = 0.0
        j.q = 0.0
        if coordinate:
            j.drift = j.drift + coordinate_drift
        x.n = x.n + symmetric_times(x.a, j.bias) + x.b * j.drift
        x.f = x.f + wp.transpose(x.b) * j.bias + symmetric_times(x.c, j.drift)
        if kind != FIXED:
            j.turning = axis
            if coordinate:
                j.turning = turning
                j.moving = moving
            j.moment = symmetric_times(x.a, j.turning) + x.b * j.moving
            j.force = wp.transpose(x.b) * j.turning + symmetric_times(x.c, j.moving)
            if j.free != 0:
                own_inertia = wp.dot(j.turning, j.moment) + wp.dot(j.moving, j.force)
                j.d = 1.0 / (own_inertia + wp.dot(axis, symmetric_times(stiffness, axis)))
                effort = -wp.dot(axis, torque)
                j.q = (effort - wp.dot(j.turning, x.n) - wp.dot(j.moving, x.f)) * j.d

    return take_body


@cache
def leave_single_of(constrained: bool) -> Any:
    """The Warp function of `followed_reduction.leave_followed` for a joint of one axis and one unknown."""
    collect = gather_with_pushes if constrained else gather

    @func
    def leave_single(
        body: int, k: int, entry: int, x: wp.ref[Articulated], j: wp.ref[SingleJoint], model: ModelRef, work: ScratchRef
    ):
        u = collect(body, k, model, work)
        moment = wp.spatial_top(u)
        force = wp.spatial_bottom(u)
        along = wp.dot(j.turning, moment) + wp.dot(j.moving, force)
        response = j.d * along
        v = wp.dot(moment, j.bias) + wp.dot(force, j.drift)
        if j.row >= 0:
            if k == j.row:
                along = 2.0 * along + wp.dot(j.turning, j.moment) + wp.dot(j.moving, j.force)
                v += wp.dot(j.turning, x.n) + wp.dot(j.moving, x.f)
                moment += j.moment
                force += j.force
        else:
            v += along * j.q
            moment -= j.moment * response
            force -= j.force * response
        work.followed_moment[entry] = moment + wp.cross(j.r, force)
        work.followed_force[entry] = force
        set_component(work.followed_along, entry, 0, along)
        set_component(work.followed_response, entry, 0, response)
        work.followed_bias[entry] = v

    return leave_single


@func
def pass_on(x: wp.ref[Articulated], j: wp.ref[SingleJoint]):
    """What a joint transmits, about the joint of its parent: `dynamics.leave_downdated`, left in x."""
    if j.free != 0:
        x.a = x.a + symmetric_outer(j.moment, -j.d)
        x.b = x.b - wp.outer(j.moment * j.d, j.force)
        x.c = x.c + symmetric_outer(j.force, -j.d)
        x.n = x.n + j.moment * j.q
        x.f = x.f + j.force * j.q
    shifted = x.b + cross_rows(j.r, x.c)
    x.a = x.a + shifted_angular(x.b, shifted, j.r)
    x.b = shifted
    x.n = x.n + wp.cross(j.r, x.f)


@cache
def reduce_run_of(hybrid: bool, constrained: bool) -> Any:
    """The Warp function that eliminates the joints of a run, from its last body to its first one.

    All lanes that go along it find the joints, and each takes some of the unknowns, the same ones all along. One leaves
    what is for the parent, when all have read what was there: there is a barrier in the middle.
    """
    take_body, leave_single = take_body_of(hybrid), leave_single_of(constrained)

    @func
    def reduce_run(instance: int, t: Task, model: ModelRef, work: ScratchRef):
        run = model.couplings.run[nonnegative(t.run)]
        first = nonnegative(run.first)
        unknowns = nonnegative(model.couplings.entry_start[first])
        x = Articulated()
        j = SingleJoint()
        if t.helper < t.helpers and t.helper <= wp.max(t.leaver, t.sharing - 1):
            body = nonnegative(run.last)
            add_children(body, x, model, work)
            for _ in range(run.count):
                above = model.skeleton.plan[body].parent  # asked for before anything is stored
                ahead_of_reducing(nonnegative(above), work)
                take_body(instance, body, x, j, model, work)
                if t.helper < t.sharing:
                    for rank in range(t.helper, run.unknowns, t.sharing):
                        k = nonnegative(model.couplings.entry_unknown[unknowns + rank])
                        entry = entry_of(body, k, model)
                        if entry >= 0:
                            leave_single(body, k, nonnegative(entry), x, j, model, work)
                if t.helper == t.leaver and j.free != 0:
                    work.factor_a[body] = wp.matrix_from_cols(j.moment * j.d, j.force * j.d, wp.vec3(j.q, 0.0, 0.0))
                pass_on(x, j)
                body = nonnegative(above)
        synchronize()
        if t.helper == t.leaver and t.helper < t.helpers:
            work.block_a[first] = x.a
            work.block_b[first] = x.b
            work.block_c[first] = x.c
            work.bias_moment[first] = x.n
            work.bias_force[first] = x.f

    return reduce_run


@cache
def single_pass_of(hybrid: bool, constrained: bool = False) -> Any:
    """`followed_reduction.followed_pass_of` where no joint has more than one axis, run by run."""
    reduce_run = reduce_run_of(hybrid, constrained)

    @func
    def backward_pass(instance: int, lane: int, lanes: int, model: ModelRef, work: ScratchRef):
        levels = model.couplings.run_levels
        for step in range(levels):
            start = int(model.couplings.run[nonnegative(levels - 1 - step)].start)
            end = model.couplings.run[nonnegative(levels - 1 - step)].end
            while start < end:
                width = wp.min(end - start, lanes)
                reduce_run(instance, begin_run(start, width, lane, lanes, model), model, work)
                start += width
            synchronize()

    return backward_pass


@wp.func_native(snippet="wp::address(factors, body)->data[0][2] -= less;")
def lessen_acceleration(factors: wp.array[wp.mat33], body: int, less: float): ...  # of a joint of one axis


@cache
def correct_single_of(hybrid: bool) -> Any:
    """`followed.correct_joint_of` where no joint has more than one axis."""
    followed = followed_of(hybrid)

    @func
    def correct_single(body: int, model: ModelRef, work: ScratchRef):
        kind = model.skeleton.plan[body].joint_type
        if wp.static(hybrid):
            kind = model.motion.remaining[body]
        if followed(body, model) < 0 and kind != FIXED:
            less = wp.float32(0.0)
            for entry in range(model.couplings.entry_start[body], model.couplings.entry_start[body + 1]):
                x = work.followed_acceleration[model.couplings.entry_unknown[entry]]
                less += component(work.followed_response, entry, 0) * x
            lessen_acceleration(work.factor_a, body, less)

    return correct_single
