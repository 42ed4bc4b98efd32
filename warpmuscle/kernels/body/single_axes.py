"""The recursion of `followed.py` for bodies whose joints all have one axis, or none: vectors in place of matrices.

A joint's S, I S and d are then one column and one number, and so are S . U_k and d S . U_k, of which only the first
components are kept. Results are those of `followed_reduction.py`, which multiplies by columns of zeros.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import symmetric_times
from warpmuscle.kernels.body.dynamics import Articulated, leave_downdated, leave_for_parent, with_children
from warpmuscle.kernels.body.followed_reduction import followed_of, gather, gather_with_pushes
from warpmuscle.kernels.body.joint_motion import has_motion
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import FIXED, ModelRef, ScratchRef, at, component, nonnegative, set_component


@wp.struct
class SingleJoint:
    """A joint of one speed, or of none, whose axis is 0."""

    turning: wp.vec3  # S, angular half
    moving: wp.vec3  # S, linear half
    moment: wp.vec3  # I S
    force: wp.vec3
    d: float  # (S . I S + K)^-1; 0 if a followed coordinate moves the joint
    q: float  # acceleration where the parent has none


@cache
def leave_single_of(constrained: bool) -> Any:
    """The Warp function `leave_single`, where constraints may push."""
    collect = gather_with_pushes if constrained else gather

    @func
    def leave_single(
        body: int, helper: int, helpers: int, own: int, r: wp.vec3, drift: wp.vec3, x: Articulated, j: SingleJoint,
        model: ModelRef, work: ScratchRef,
    ):  # fmt: skip
        """`followed_reduction.leave_followed` of a joint of one axis."""
        bias = work.bias[body]
        first = nonnegative(model.couplings.entry_start[body])
        for entry in range(first + helper, model.couplings.entry_start[body + 1], helpers):
            k = nonnegative(model.couplings.entry_unknown[entry])
            u = collect(body, k, model, work)
            moment = wp.spatial_top(u)
            force = wp.spatial_bottom(u)
            along = wp.dot(j.turning, moment) + wp.dot(j.moving, force)
            response = j.d * along
            v = wp.dot(moment, bias) + wp.dot(force, drift)
            if own >= 0:
                if k == own:
                    along = 2.0 * along + wp.dot(j.turning, j.moment) + wp.dot(j.moving, j.force)
                    v += wp.dot(j.turning, x.n) + wp.dot(j.moving, x.f)
                    moment += j.moment
                    force += j.force
            else:
                v += along * j.q
                moment -= j.moment * response
                force -= j.force * response
            work.followed_moment[entry] = moment + wp.cross(r, force)
            work.followed_force[entry] = force
            set_component(work.followed_along, entry, 0, along)
            set_component(work.followed_response, entry, 0, response)
            work.followed_bias[entry] = v

    return leave_single


@cache
def reduce_single_of(hybrid: bool, constrained: bool = False, several_warps: bool = False) -> Any:
    """`followed_reduction.reduce_followed_of` where no joint has more than one axis.

    Of lanes in several warps, no more help than the body has unknowns.
    """
    followed, leave_single = followed_of(hybrid), leave_single_of(constrained)

    @func
    def reduce_single(
        instance: int, body: int, helper: int, helpers: int, model: ModelRef, work: ScratchRef
    ):  # fmt: skip
        skeleton = model.skeleton
        kind = skeleton.plan[body].joint_type
        coordinate = has_motion(kind)
        if wp.static(hybrid):
            kind = model.motion.remaining[body]
        own = followed(body, model)
        free = kind != FIXED and own < 0
        x = Articulated()
        j = SingleJoint()
        r = wp.vec3(0.0)
        drift = wp.vec3(0.0)
        leaver = wp.int32(0)
        last = helpers - 1
        if wp.static(several_warps):
            unknowns = model.couplings.entry_start[body + 1] - model.couplings.entry_start[body]
            leaver = wp.min(last, unknowns)
            last = leaver
        if helper <= last:
            x = with_children(body, skeleton, work)
            parent = nonnegative(skeleton.plan[body].parent)
            r = work.position[body] - work.position[parent]
            w = work.angular_velocity[parent]
            bias = work.bias[body]
            drift = wp.cross(w, wp.cross(w, r))
            if coordinate:
                drift += work.coordinate_drift[body]
            x.n += symmetric_times(x.a, bias) + x.b * drift
            x.f += wp.transpose(x.b) * bias + symmetric_times(x.c, drift)
            if kind != FIXED:
                axis = work.rotation[body] * at(skeleton.row, instance, body).axis_a
                j.turning = axis
                j.moment = symmetric_times(x.a, axis)
                j.force = wp.transpose(x.b) * axis
                if coordinate:
                    j.turning = work.coordinate_turning[body]
                    j.moving = work.coordinate_moving[body]
                    j.moment = symmetric_times(x.a, j.turning) + x.b * j.moving
                    j.force = wp.transpose(x.b) * j.turning + symmetric_times(x.c, j.moving)
                if free:
                    own_inertia = wp.dot(j.turning, j.moment) + wp.dot(j.moving, j.force)
                    j.d = 1.0 / (own_inertia + wp.dot(axis, symmetric_times(work.stiffness[body], axis)))
                    effort = -wp.dot(axis, work.torque[body])
                    j.q = (effort - wp.dot(j.turning, x.n) - wp.dot(j.moving, x.f)) * j.d
        synchronize()
        sharing = helpers
        if wp.static(several_warps):
            sharing = wp.max(leaver, 1)
        if helper < sharing:
            leave_single(body, helper, sharing, own, r, drift, x, j, model, work)
        if helper == leaver:
            if free:
                q = j.q
                if not coordinate:  # as `dynamics.reduce_hinge` rounds it
                    q = wp.dot(j.turning, -work.torque[body] - x.n) * j.d
                leave_downdated(body, r, x, j.moment, j.force, j.d, q, work)
            else:
                leave_for_parent(body, r, x.a, x.b, x.c, x.n, x.f, work)

    return reduce_single


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
