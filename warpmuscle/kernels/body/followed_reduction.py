"""What a body leaves for its parent where coordinates that joints follow stay open to the root, see `followed.py`."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import full, symmetric, symmetric_inverse, symmetric_times
from warpmuscle.kernels.body.coordinate_joint import coordinate_axis, joint_drift
from warpmuscle.kernels.body.dynamics import (
    Articulated,
    leave_downdated,
    leave_for_parent,
    reduce_ball,
    reduce_hinge,
    reduce_universal,
    with_children,
)
from warpmuscle.kernels.body.hybrid import second_axis
from warpmuscle.kernels.body.joint_motion import has_motion
from warpmuscle.kernels.constraint.constraints import pushed
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import BALL, FIXED, SECOND_HINGE, UNIVERSAL, ModelRef, ScratchRef, at, nonnegative


@wp.struct
class FreeJoint:
    """A joint of up to three speeds, whose axes are columns; unused ones are 0."""

    turning: wp.mat33  # S, angular half
    moving: wp.mat33  # S, linear half
    moment: wp.mat33  # I S
    force: wp.mat33
    d: wp.mat33  # (S . I S + K)^-1
    q: wp.vec3  # accelerations where the parent has none


@func
def entry_of(body: int, k: int, model: ModelRef) -> int:
    """Where what a body leaves of a followed coordinate is; -1: nothing that hangs on the body has to do with it."""
    return model.couplings.entry[nonnegative(body) * model.couplings.followed + k]


@func
def subspace(turning: wp.mat33, moving: wp.mat33, x: Articulated) -> FreeJoint:
    """A joint's axes and what they take."""
    j = FreeJoint()
    j.turning = turning
    j.moving = moving
    j.moment = full(x.a) * turning + x.b * moving
    j.force = wp.transpose(x.b) * turning + full(x.c) * moving
    return j


@func
def first_column(v: wp.vec3) -> wp.mat33:
    """A matrix with one column."""
    return wp.matrix_from_cols(v, wp.vec3(0.0), wp.vec3(0.0))


@func
def one_axis(turning: wp.vec3, moving: wp.vec3, stiffness: float, effort: float, x: Articulated) -> FreeJoint:
    """A joint of one speed; effort is the generalised force on it."""
    j = subspace(first_column(turning), first_column(moving), x)
    own = wp.dot(turning, wp.vec3(j.moment[0, 0], j.moment[1, 0], j.moment[2, 0]))
    own += wp.dot(moving, wp.vec3(j.force[0, 0], j.force[1, 0], j.force[2, 0]))
    d = 1.0 / (own + stiffness)
    j.d = wp.mat33(d, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    j.q = wp.vec3((effort - wp.dot(turning, x.n) - wp.dot(moving, x.f)) * d, 0.0, 0.0)
    return j


@func
def two_axes(a: wp.vec3, b: wp.vec3, k: symmetric, torque: wp.vec3, x: Articulated) -> FreeJoint:
    """A universal joint."""
    j = subspace(wp.matrix_from_cols(a, b, wp.vec3(0.0)), wp.mat33(0.0), x)
    ka = symmetric_times(x.a, a) + symmetric_times(k, a)
    kb = symmetric_times(x.a, b) + symmetric_times(k, b)
    m11 = wp.dot(a, ka)
    m12 = wp.dot(a, kb)
    m22 = wp.dot(b, kb)
    d = 1.0 / (m11 * m22 - m12 * m12)
    j.d = wp.mat33(m22 * d, -m12 * d, 0.0, -m12 * d, m11 * d, 0.0, 0.0, 0.0, 0.0)
    u = torque - x.n
    j.q = j.d * wp.vec3(wp.dot(a, u), wp.dot(b, u), 0.0)
    return j


@func
def three_axes(k: symmetric, torque: wp.vec3, x: Articulated) -> FreeJoint:
    """A ball joint, along world axes."""
    j = subspace(wp.identity(n=3, dtype=float), wp.mat33(0.0), x)
    j.d = full(symmetric_inverse(x.a + k))
    j.q = j.d * (torque - x.n)
    return j


@func
def gather(body: int, k: int, model: ModelRef, work: ScratchRef) -> wp.spatial_vector:
    """U_k of all that hangs on a body, about its joint."""
    moment = wp.vec3(0.0)
    force = wp.vec3(0.0)
    first = model.skeleton.plan[body].first_child
    for child in range(first, first + model.skeleton.plan[body].child_count):
        entry = entry_of(child, k, model)
        if entry >= 0:
            moment += work.followed_moment[entry]
            force += work.followed_force[entry]
    return wp.spatial_vector(moment, force)


@func
def gather_with_pushes(body: int, k: int, model: ModelRef, work: ScratchRef) -> wp.spatial_vector:
    """The same with what constraints push on the body itself."""
    return gather(body, k, model, work) + pushed(body, k - model.constraints.first, model, work)


@cache
def leave_followed_of(constrained: bool) -> Any:
    """The Warp function `leave_followed`, where constraints may push."""
    collect = gather_with_pushes if constrained else gather

    @func
    def leave_followed(
        body: int, helper: int, helpers: int, own: int, r: wp.vec3, drift: wp.vec3, x: Articulated, j: FreeJoint,
        model: ModelRef, work: ScratchRef,
    ):  # fmt: skip
        """Leave U_k for the parent, and what the joint adds to D and v, see the head of this file.

        Args:
            helper, helpers: every so many of the unknowns, from the first on.
            own: which followed coordinate moves the joint, whose S is then the first axis of j; -1: none.
        """
        bias = work.bias[body]
        first = nonnegative(model.couplings.entry_start[body])
        for entry in range(first + helper, model.couplings.entry_start[body + 1], helpers):
            k = nonnegative(model.couplings.entry_unknown[entry])
            u = collect(body, k, model, work)
            moment = wp.spatial_top(u)
            force = wp.spatial_bottom(u)
            along = wp.transpose(j.turning) * moment + wp.transpose(j.moving) * force
            response = wp.vec3(0.0)
            v = wp.dot(moment, bias) + wp.dot(force, drift)
            if own >= 0:
                if k == own:
                    s = wp.vec3(j.turning[0, 0], j.turning[1, 0], j.turning[2, 0])
                    t = wp.vec3(j.moving[0, 0], j.moving[1, 0], j.moving[2, 0])
                    ua = wp.vec3(j.moment[0, 0], j.moment[1, 0], j.moment[2, 0])
                    ub = wp.vec3(j.force[0, 0], j.force[1, 0], j.force[2, 0])
                    along = wp.vec3(2.0 * along[0] + wp.dot(s, ua) + wp.dot(t, ub), 0.0, 0.0)
                    v += wp.dot(s, x.n) + wp.dot(t, x.f)
                    moment += ua
                    force += ub
            else:
                response = j.d * along
                v += wp.dot(along, j.q)
                moment -= j.moment * response
                force -= j.force * response
            work.followed_moment[entry] = moment + wp.cross(r, force)
            work.followed_force[entry] = force
            work.followed_along[entry] = along
            work.followed_response[entry] = response
            work.followed_bias[entry] = v

    return leave_followed


@func
def row_of(body: int, model: ModelRef) -> int:
    """Which followed coordinate moves a body's joint; -1: none."""
    return model.couplings.joint[body].row


@cache
def followed_of(hybrid: bool) -> Any:
    """The Warp function (body, model) -> which followed coordinate moves a body's joint; -1: none that forces move."""

    if not hybrid:
        return row_of

    @func
    def followed(body: int, model: ModelRef) -> int:
        own = row_of(body, model)
        if own >= 0 and model.motion.remaining[nonnegative(model.couplings.joint[body].driver)] == FIXED:
            own = -1
        return own

    return followed


@cache
def reduce_followed_of(hybrid: bool, constrained: bool = False, several_warps: bool = False) -> Any:
    """The Warp function that eliminates the joint of one body, unless a followed coordinate moves it.

    Several lanes do so together: each finds the joint, and then takes some of the unknowns; one leaves all else.
    What they read is left as it is up to the barrier in its middle, where lanes without a body wait, too.

    Args:
        constrained: whether there are constraints.
        several_warps: whether that one does nothing else, if there are others: they are in other warps then.
    """
    followed, leave_followed = followed_of(hybrid), leave_followed_of(constrained)

    @func
    def reduce_followed(
        instance: int, body: int, helper: int, helpers: int, model: ModelRef, work: ScratchRef
    ):  # fmt: skip
        skeleton = model.skeleton
        kind = skeleton.plan[body].joint_type
        coordinate = has_motion(kind)
        if wp.static(hybrid):
            kind = model.motion.remaining[body]
        fixed = kind == FIXED
        x = Articulated()
        j = FreeJoint()
        r = wp.vec3(0.0)
        drift = wp.vec3(0.0)
        axis_a = wp.vec3(0.0)
        axis_b = wp.vec3(0.0)
        own = followed(body, model)
        torque = -work.torque[body]
        if helper < helpers:
            x = with_children(body, skeleton, work)
            parent = nonnegative(skeleton.plan[body].parent)
            r = work.position[body] - work.position[parent]
            w = work.angular_velocity[parent]
            bias = work.bias[body]
            drift = wp.cross(w, wp.cross(w, r))
            if coordinate:
                drift = joint_drift(body, skeleton, work)
            x.n += symmetric_times(x.a, bias) + x.b * drift
            x.f += wp.transpose(x.b) * bias + symmetric_times(x.c, drift)
            k = work.stiffness[body]
            if coordinate:
                s = work.coordinate_turning[body]
                t = work.coordinate_moving[body]
                if own >= 0:
                    j = subspace(first_column(s), first_column(t), x)
                elif not fixed:
                    axis_a = coordinate_axis(instance, body, model, work)
                    j = one_axis(s, t, wp.dot(axis_a, symmetric_times(k, axis_a)), wp.dot(axis_a, torque), x)
            elif kind == BALL:
                j = three_axes(k, torque, x)
            elif not fixed:
                axis_a = work.rotation[body] * at(skeleton.row, instance, body).axis_a
                axis_b = second_axis(instance, body, model, work)
                if kind == UNIVERSAL:
                    j = two_axes(axis_a, axis_b, k, torque, x)
                else:
                    if kind == SECOND_HINGE:
                        axis_a = axis_b
                    stiffness = wp.dot(axis_a, symmetric_times(k, axis_a))
                    j = one_axis(axis_a, wp.vec3(0.0), stiffness, wp.dot(axis_a, torque), x)
        synchronize()
        sharing = helpers
        leaver = wp.int32(0)
        if wp.static(several_warps):
            sharing = wp.max(helpers - 1, 1)
            leaver = helpers - 1
        if helper < sharing:
            leave_followed(body, helper, sharing, own, r, drift, x, j, model, work)
        if helper == leaver:
            if own >= 0 or fixed:
                leave_for_parent(body, r, x.a, x.b, x.c, x.n, x.f, work)
            elif coordinate:
                ua = wp.vec3(j.moment[0, 0], j.moment[1, 0], j.moment[2, 0])
                ub = wp.vec3(j.force[0, 0], j.force[1, 0], j.force[2, 0])
                leave_downdated(body, r, x, ua, ub, j.d[0, 0], j.q[0], work)
            elif kind == BALL:
                reduce_ball(body, r, torque, x, work)
            elif kind == UNIVERSAL:
                reduce_universal(body, r, torque, x, axis_a, axis_b, work)
            else:
                reduce_hinge(body, r, torque, x, axis_a, work)

    return reduce_followed


@cache
def followed_pass_of(reduce: Any, several_warps: bool = False) -> Any:
    """`dynamics.backward_pass_of` where lanes that find no body of a level share those that others have.

    Args:
        reduce: `reduce_followed_of` some kind. several_warps: see there.
    """
    more = int(several_warps)

    @func
    def backward_pass(instance: int, lane: int, lanes: int, model: ModelRef, work: ScratchRef):
        for step in range(1, model.level_count):
            level = model.level_count - step
            first = nonnegative(model.level_start[level])
            end = nonnegative(model.level_start[level + 1])
            width = wp.min(end - first, lanes)
            helpers = wp.min(lanes // width, model.couplings.followed + more)
            start = int(first)
            while start < end:
                body = start + lane % width
                helper = wp.where(body < end, lane // width, helpers)
                reduce(instance, wp.min(body, end - 1), helper, helpers, model, work)
                start += width
            synchronize()

    return backward_pass
