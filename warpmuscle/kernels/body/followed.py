"""Coordinates that joints anywhere in the tree follow, in the articulated-body algorithm: exact, in one recursion.

`follower.py` eliminates a coordinate at the joint that drives it, so that those that follow it must be its neighbours.
Here the coordinates that are followed stay open all the way to the root. Their joints hold their bodies as if their
accelerations x_k were known, and each body leaves for its parent, besides its articulated inertia I and bias p, what a
unit of each x_k adds. With a parent's acceleration a, the force on it and the generalised force on x_k are

    f = I a + p + sum_k U_k x_k,    R_k = U_k . a + sum_l D_kl x_l + v_k.

Through a joint with the motion subspace S and the bias acceleration c these become (Featherstone 2008, eq. 7.43, for
any right-hand side; Jain 2011, Robot and Multibody Dynamics, ch. 15, for aggregated bodies)

    of a free joint, with d = (S . I S + K)^-1, w_k = S . U_k, and q its acceleration where a and all x_k are 0:
        U_k -= I S d w_k,    D_kl -= w_k d w_l,    v_k += U_k . c + w_k q;
    of one that x_k moves:
        U_k += I S,    D_kl += S . U_l,  D_kk += S . (I S + U_k),    v_k += U_k . c + S . p,

where U_k on the right is the sum of those of the children. At the root a is known, or is eliminated as a free joint is,
and D x = forces - v gives x; then free joints know their accelerations: q - d sum_k w_k x_k. Pushes of constraints
are more such unknowns, see `constraints.py`.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import full, symmetric, symmetric_inverse, symmetric_product, symmetric_times
from warpmuscle.kernels.body.coordinate_joint import accelerate_any, accelerate_any_remaining, coordinate_axis
from warpmuscle.kernels.body.dynamics import Articulated, move_body, with_children
from warpmuscle.kernels.body.followed_reduction import entry_of, followed_of, gather, gather_with_pushes
from warpmuscle.kernels.body.motion import prescribed_root
from warpmuscle.kernels.body.single_axes import correct_single_of
from warpmuscle.kernels.constraint.solution import solve_constrained, substitute_back
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import (
    BALL,
    FIXED,
    ROOT_FREE,
    ROOT_PLANAR,
    ROOT_PRESCRIBED,
    UNIVERSAL,
    ModelRef,
    ScratchRef,
    StateRef,
    component,
    nonnegative,
)


@func
def root_motion(kind: int, x: Articulated, n: wp.vec3, f: wp.vec3) -> wp.spatial_vector:
    """The acceleration of a root that forces n and f hold back: `dynamics.accelerate_root` for any of them."""
    alpha = wp.vec3(0.0)
    a = wp.vec3(0.0)
    if kind == ROOT_FREE:
        c = symmetric_inverse(x.c)
        bc = x.b * full(c)
        s = symmetric_inverse(x.a - symmetric_product(bc, wp.transpose(x.b)))
        alpha = symmetric_times(s, bc * f - n)
        a = symmetric_times(c, -f - wp.transpose(x.b) * alpha)
    elif kind == ROOT_PLANAR:
        m = symmetric(x.a[0], x.b[0, 1], x.b[0, 2], x.c[3], x.c[4], x.c[5])
        y = symmetric_times(symmetric_inverse(m), wp.vec3(-n[0], -f[1], -f[2]))
        alpha = wp.vec3(y[0], 0.0, 0.0)
        a = wp.vec3(0.0, y[1], y[2])
    return wp.spatial_vector(alpha, a)


@cache
def close_root_of(constrained: bool) -> Any:
    """The Warp function `close_root`, where constraints may push."""
    collect = gather_with_pushes if constrained else gather

    @func
    def close_root(
        lane: int, lanes: int, kind: int, given: wp.spatial_vector, model: ModelRef, work: ScratchRef
    ) -> wp.spatial_vector:  # fmt: skip
        """U_k, responses and v at the root, as of a body of which nothing is left for a parent.

        Returns its acceleration but for what followed coordinates give it. Each lane takes other unknowns.

        Args:
            given: its acceleration, if that is prescribed; else 0.
        """
        x = with_children(0, model.skeleton, work)
        rest = root_motion(kind, x, x.n, x.f) + given
        for k in range(lane, model.couplings.followed, lanes):
            u = collect(0, k, model, work)
            response = root_motion(kind, x, wp.spatial_top(u), wp.spatial_bottom(u))
            work.followed_moment[k] = wp.spatial_top(u)
            work.followed_force[k] = wp.spatial_bottom(u)
            work.followed_along[k] = wp.spatial_top(response)
            work.followed_response[k] = wp.spatial_bottom(response)
            work.followed_bias[k] = wp.dot(u, rest)
        return rest

    return close_root


close_root = close_root_of(False)


@cache
def element_of(hybrid: bool, single: bool) -> Any:
    """The Warp function of an element of D. single: whether no joint has more than one axis."""
    followed = followed_of(hybrid)

    @func
    def through_joint(mine: int, other: int, work: ScratchRef) -> float:
        if wp.static(single):
            return component(work.followed_along, mine, 0) * component(work.followed_response, other, 0)
        else:
            return wp.dot(work.followed_along[mine], work.followed_response[other])

    @func
    def element(k: int, l: int, model: ModelRef, work: ScratchRef) -> float:  # noqa: E741
        couplings = model.couplings
        d = wp.dot(work.followed_moment[k], work.followed_along[l])
        d += wp.dot(work.followed_force[k], work.followed_response[l])
        for place in range(couplings.acted_start[k], couplings.acted_start[k + 1]):
            body = nonnegative(couplings.acted[place])
            other = entry_of(body, l, model)
            if other >= 0:
                mine = entry_of(body, k, model)
                own = followed(body, model)
                if own < 0:
                    d -= through_joint(mine, other, work)
                elif own == k:
                    d += component(work.followed_along, other, 0)
                elif own == l:
                    d += component(work.followed_along, mine, 0)
        return d

    return element


@cache
def equations_of(hybrid: bool, constrained: bool = False, single: bool = False) -> Any:
    """The Warp function that sums up D and forces - v, an element a lane, in the order of bodies.

    Args:
        constrained: whether there are constraints, whose rows come last and have what is wanted in place of forces.
        single: whether no joint has more than one axis.
    """
    followed, element = followed_of(hybrid), element_of(hybrid, single)

    @func
    def free_unknown(k: int, driver: int, model: ModelRef) -> bool:
        free = followed(driver, model) >= 0
        if wp.static(constrained):
            free = free or k >= model.constraints.first
        return free

    @func
    def right_side(instance: int, k: int, driver: int, model: ModelRef, work: ScratchRef) -> float:
        right = -work.followed_bias[k]
        couplings = model.couplings
        for place in range(couplings.acted_start[k], couplings.acted_start[k + 1]):
            right -= work.followed_bias[entry_of(couplings.acted[place], k, model)]
        if wp.static(constrained):  # noqa: SIM102, with `and` it would be compiled in all the same
            if k >= model.constraints.first:
                return right - work.push_wanted[k - model.constraints.first]
        return right - wp.dot(coordinate_axis(instance, driver, model, work), work.torque[driver])

    @func
    def equations(instance: int, lane: int, lanes: int, model: ModelRef, work: ScratchRef):
        count = nonnegative(model.couplings.followed)
        for place in range(lane, count * (count + 1) // 2, lanes):
            k = count - 1 - place // (count + 1)  # the longest row below the diagonal and the shortest, and so on
            l = place % (count + 1)  # noqa: E741
            if l > k:
                l -= k + 1  # noqa: E741
                k = count - 1 - k
            driver = nonnegative(model.couplings.unknown_driver[k])
            free = free_unknown(k, driver, model)
            both = free
            if k != l:
                both = free and free_unknown(l, nonnegative(model.couplings.unknown_driver[l]), model)
            d = wp.where(k == l, 1.0, 0.0)
            if both:
                d = element(k, l, model, work)
                if k == l and driver > 0:
                    axis = coordinate_axis(instance, driver, model, work)
                    d += wp.dot(axis, symmetric_times(work.stiffness[driver], axis))
            work.followed_matrix[k * count + l] = d
            if k == l:
                right = wp.float32(0.0)
                if free:
                    right = right_side(instance, k, driver, model, work)
                work.followed_acceleration[k] = right
            else:
                work.followed_matrix[l * count + k] = d

    return equations


@func
def solve_followed(lane: int, lanes: int, count: int, work: ScratchRef):
    """x of D x = right-hand side, in the place of that, by elimination; D is symmetric and positive definite.

    Each lane takes other rows below the pivot. The first one ends with x, and there is no barrier behind that.
    """
    for k in range(count):
        pivot = 1.0 / work.followed_matrix[k * count + k]
        for i in range(k + 1 + lane, count, lanes):
            factor = work.followed_matrix[i * count + k] * pivot
            for l in range(k + 1, count):  # noqa: E741
                taken = factor * work.followed_matrix[k * count + l]
                work.followed_matrix[i * count + l] = work.followed_matrix[i * count + l] - taken
            work.followed_acceleration[i] = work.followed_acceleration[i] - factor * work.followed_acceleration[k]
        synchronize()
    if lane == 0:
        substitute_back(count, count, work)


@func
def move_root(model: ModelRef, work: ScratchRef):
    """Add to the root's acceleration what those of followed coordinates give it."""
    for k in range(model.couplings.followed):
        x = work.followed_acceleration[k]
        work.angular_acceleration[0] = work.angular_acceleration[0] + work.followed_along[k] * x
        work.acceleration[0] = work.acceleration[0] + work.followed_response[k] * x


@cache
def correct_joint_of(hybrid: bool) -> Any:
    """The Warp function that lets the factors of a free joint know the accelerations of followed coordinates."""
    followed = followed_of(hybrid)

    @func
    def correct_joint(body: int, model: ModelRef, work: ScratchRef):
        kind = model.skeleton.plan[body].joint_type
        if wp.static(hybrid):
            kind = model.motion.remaining[body]
        if followed(body, model) < 0 and kind != FIXED:
            less = wp.vec3(0.0)
            for entry in range(model.couplings.entry_start[body], model.couplings.entry_start[body + 1]):
                x = work.followed_acceleration[model.couplings.entry_unknown[entry]]
                less += work.followed_response[entry] * x
            if kind == BALL:
                work.factor_c[body] = work.factor_c[body] - less
            elif kind == UNIVERSAL:
                work.factor_b[body] = work.factor_b[body] - wp.mat33(
                    0.0, less[0], 0.0, 0.0, less[1], 0.0, 0.0, 0.0, 0.0
                )
            else:
                work.factor_a[body] = work.factor_a[body] - wp.mat33(0.0, 0.0, less[0], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    return correct_joint


@cache
def accelerate_followed_of(hybrid: bool) -> Any:
    """The Warp function of the acceleration of a body, whose joint a followed coordinate may move."""
    followed = followed_of(hybrid)
    accelerate_free = accelerate_any_remaining if hybrid else accelerate_any

    @func
    def accelerate_followed(instance: int, body: int, model: ModelRef, work: ScratchRef):
        own = followed(body, model)
        if own < 0:
            accelerate_free(instance, body, model, work)
        else:
            parent = nonnegative(model.skeleton.plan[body].parent)
            alpha = work.angular_acceleration[parent]
            a = work.acceleration[parent] + wp.cross(alpha, work.position[body] - work.position[parent])
            x = work.followed_acceleration[own]
            along = a + work.coordinate_drift[body] + work.coordinate_moving[body] * x
            relative = work.coordinate_turning[body] * x
            move_body(body, alpha, along, wp.vec3(x, 0.0, 0.0), relative, model.skeleton, work)

    return accelerate_followed


@cache
def solution_of(hybrid: bool, constrained: bool = False, single: bool = False) -> Any:
    """The Warp function between the backward and the forward pass. It ends with a barrier."""
    equations = equations_of(hybrid, constrained, single)
    correct_joint = correct_single_of(hybrid) if single else correct_joint_of(hybrid)
    close_root = close_root_of(constrained)

    @func
    def solution(
        instance: int, lane: int, lanes: int, kind: int, given: wp.spatial_vector, model: ModelRef, work: ScratchRef
    ):
        rest = wp.spatial_vector(wp.vec3(0.0), wp.vec3(0.0))
        if lane < wp.max(model.couplings.followed, 1):
            rest = close_root(lane, lanes, kind, given, model, work)
        synchronize()
        if lane == 0:  # in the places of what all lanes have read before
            work.angular_acceleration[0] = wp.spatial_top(rest)
            work.acceleration[0] = wp.spatial_bottom(rest)
        equations(instance, lane, lanes, model, work)
        synchronize()
        if wp.static(constrained):
            solve_constrained(instance, lane, lanes, model, work)
        else:
            solve_followed(lane, lanes, model.couplings.followed, work)
        if lane == 0:
            move_root(model, work)
        synchronize()
        for body in range(1 + lane, model.body_count, lanes):
            correct_joint(body, model, work)
        synchronize()

    return solution


@cache
def followed_acceleration_stage_of(
    backward_pass: Any, forward_pass: Any, constrained: bool = False, single: bool = False
) -> Any:
    """`dynamics.acceleration_stage_of` where followed coordinates, or pushes of constraints, stay open to the root."""
    solution = solution_of(False, constrained, single)

    @func
    def acceleration_stage(instance: int, lane: int, lanes: int, model: ModelRef, work: ScratchRef):
        backward_pass(instance, lane, lanes, model, work)
        still = wp.spatial_vector(wp.vec3(0.0), wp.vec3(0.0))
        solution(instance, lane, lanes, model.skeleton.plan[0].joint_type, still, model, work)
        forward_pass(instance, lane, lanes, model, work)

    return acceleration_stage


@cache
def followed_hybrid_stage_of(
    backward_pass: Any, forward_pass: Any, constrained: bool = False, single: bool = False
) -> Any:
    """`hybrid.hybrid_acceleration_stage_of` where followed coordinates, or pushes, stay open to the root."""
    solution = solution_of(True, constrained, single)

    @func
    def hybrid_acceleration_stage(
        instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef
    ):
        backward_pass(instance, lane, lanes, model, work)
        kind = model.skeleton.plan[0].joint_type
        given = wp.spatial_vector(wp.vec3(0.0), wp.vec3(0.0))
        if model.motion.remaining[0] == ROOT_PRESCRIBED:
            given = prescribed_root(instance, kind == ROOT_PLANAR, state)
            kind = ROOT_PRESCRIBED
        solution(instance, lane, lanes, kind, given, model, work)
        forward_pass(instance, lane, lanes, model, work)

    return hybrid_acceleration_stage
