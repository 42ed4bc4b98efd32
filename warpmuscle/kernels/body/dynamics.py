"""Forward dynamics by the articulated-body algorithm (Featherstone 2008, ch. 7).

World axes about each body's joint. An articulated inertia is three 3x3 blocks, angular A, coupling B, linear C:
moment = A alpha + B a + p_n, force = B^T alpha + C a + p_f, with alpha the body's angular acceleration and a the
acceleration of its joint. So a ball joint needs one symmetric inverse, hinges and universal joints rank-1 and rank-2
downdates. A joint may carry an implicit inertia K (spring-dampers linearised over the step) in its own coordinates.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import (
    cross_rows,
    full,
    shifted_angular,
    symmetric,
    symmetric_inverse,
    symmetric_outer,
    symmetric_part,
    symmetric_product,
    symmetric_times,
)
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import (
    BALL,
    FIXED,
    HINGE,
    ROOT_FREE,
    ROOT_PLANAR,
    UNIVERSAL,
    ModelRef,
    ScratchRef,
    Skeleton,
    at,
    nonnegative,
    not_unrolled,
)


@wp.struct
class Articulated:
    """An articulated inertia and its bias: moment = A alpha + B a + n, force = B^T alpha + C a + f."""

    a: symmetric  # kg m^2
    b: wp.mat33  # kg m
    c: symmetric  # kg
    n: wp.vec3  # N m
    f: wp.vec3  # N


@func
def with_children(body: int, skeleton: Skeleton, work: ScratchRef) -> Articulated:
    """A body's own articulated inertia and bias, and what its children have left for it."""
    x = Articulated()
    x.a = work.block_a[body]
    x.b = work.block_b[body]
    x.c = work.block_c[body]
    x.n = work.bias_moment[body]
    x.f = work.bias_force[body]
    first = skeleton.plan[body].first_child
    for child in range(first, first + skeleton.plan[body].child_count):
        not_unrolled()
        x.a += work.block_a[child]
        x.b += work.block_b[child]
        x.c += work.block_c[child]
        x.n += work.bias_moment[child]
        x.f += work.bias_force[child]
    return x


@func
def leave_for_parent(
    body: int, r: wp.vec3, a: symmetric, b: wp.mat33, c: symmetric, n: wp.vec3, f: wp.vec3, work: ScratchRef
):
    """Express a reduced articulated inertia about the parent's joint, r away, and leave it for the parent."""
    shifted = b + cross_rows(r, c)
    work.block_a[body] = a + shifted_angular(b, shifted, r)
    work.block_b[body] = shifted
    work.block_c[body] = c
    work.bias_moment[body] = n + wp.cross(r, f)
    work.bias_force[body] = f


@func
def reduce_ball(body: int, r: wp.vec3, torque: wp.vec3, x: Articulated, work: ScratchRef):
    """Eliminate a ball joint. D = (A + K)^-1; relative acceleration D (t - n) - D A alpha - D B a.

    Without K the blocks A and B vanish (Featherstone 2008, eq. 7.43 with S = 1 in the angular block).
    """
    k = work.stiffness[body]
    d = symmetric_inverse(x.a + k)
    u = torque - x.n
    g = symmetric_times(d, u)
    db = full(d) * x.b
    bt = wp.transpose(x.b)
    c = x.c - symmetric_product(bt, db)
    f = x.f + bt * g
    work.factor_b[body] = db
    work.factor_c[body] = g
    if k[0] + k[3] + k[5] == 0.0:
        work.factor_a[body] = wp.identity(n=3, dtype=float)
        shifted = cross_rows(r, c)
        work.block_a[body] = shifted_angular(wp.mat33(0.0), shifted, r)
        work.block_b[body] = shifted
        work.block_c[body] = c
        work.bias_moment[body] = torque + wp.cross(r, f)
        work.bias_force[body] = f
    else:
        da = full(d) * full(x.a)
        work.factor_a[body] = da
        kept = full(k) * da
        n = torque - symmetric_times(k, g)
        leave_for_parent(body, r, symmetric_part(kept), full(k) * db, c, n, f, work)


@func
def leave_downdated(
    body: int, r: wp.vec3, x: Articulated, ua: wp.vec3, ub: wp.vec3, d: float, q: float, work: ScratchRef
):  # fmt: skip
    """Leave for the parent what a joint of one speed transmits: rank-1 downdate (Featherstone 2008, eq. 7.43).

    Args:
        ua, ub: angular and linear part of U = I S. d: 1/(S^T U). q: d times the force that is left along S.
    """
    work.factor_a[body] = wp.matrix_from_cols(ua * d, ub * d, wp.vec3(q, 0.0, 0.0))
    leave_for_parent(
        body,
        r,
        x.a + symmetric_outer(ua, -d),
        x.b - wp.outer(ua * d, ub),
        x.c + symmetric_outer(ub, -d),
        x.n + ua * q,
        x.f + ub * q,
        work,
    )


@func
def reduce_hinge(body: int, r: wp.vec3, torque: wp.vec3, x: Articulated, axis: wp.vec3, work: ScratchRef):
    """Eliminate a hinge: rank-1 downdate (Featherstone 2008, eq. 7.43)."""
    ua = symmetric_times(x.a, axis)
    ub = wp.transpose(x.b) * axis
    d = 1.0 / (wp.dot(axis, ua) + wp.dot(axis, symmetric_times(work.stiffness[body], axis)))
    q = wp.dot(axis, torque - x.n) * d
    leave_downdated(body, r, x, ua, ub, d, q, work)


@func
def reduce_universal(
    body: int, r: wp.vec3, torque: wp.vec3, x: Articulated, axis_a: wp.vec3, axis_b: wp.vec3, work: ScratchRef
):  # fmt: skip
    """Eliminate a universal joint: rank-2 downdate (Featherstone 2008, eq. 7.43)."""
    k = work.stiffness[body]
    bt = wp.transpose(x.b)
    ua = symmetric_times(x.a, axis_a)
    ub = symmetric_times(x.a, axis_b)
    la = bt * axis_a
    lb = bt * axis_b
    kb = symmetric_times(k, axis_b)
    m11 = wp.dot(axis_a, ua) + wp.dot(axis_a, symmetric_times(k, axis_a))
    m12 = wp.dot(axis_a, ub) + wp.dot(axis_a, kb)
    m22 = wp.dot(axis_b, ub) + wp.dot(axis_b, kb)
    d = 1.0 / (m11 * m22 - m12 * m12)
    pa = (ua * m22 - ub * m12) * d
    pb = (ub * m11 - ua * m12) * d
    qa = (la * m22 - lb * m12) * d
    qb = (lb * m11 - la * m12) * d
    u = torque - x.n
    xa = (m22 * wp.dot(axis_a, u) - m12 * wp.dot(axis_b, u)) * d
    xb = (m11 * wp.dot(axis_b, u) - m12 * wp.dot(axis_a, u)) * d
    work.factor_a[body] = wp.matrix_from_cols(pa, qa, pb)
    work.factor_b[body] = wp.matrix_from_cols(qb, wp.vec3(xa, xb, 0.0), wp.vec3(0.0))
    leave_for_parent(
        body,
        r,
        symmetric_part(full(x.a) - wp.outer(pa, ua) - wp.outer(pb, ub)),
        x.b - wp.outer(pa, la) - wp.outer(pb, lb),
        symmetric_part(full(x.c) - wp.outer(qa, la) - wp.outer(qb, lb)),
        x.n + ua * xa + ub * xb,
        x.f + la * xa + lb * xb,
        work,
    )


@func
def reduce_body(instance: int, body: int, model: ModelRef, work: ScratchRef):
    """Eliminate the joint of one body and leave the rest for its parent."""
    skeleton = model.skeleton
    x = with_children(body, skeleton, work)
    parent = nonnegative(skeleton.plan[body].parent)
    r = work.position[body] - work.position[parent]
    bias = work.bias[body]
    parent_angular = work.angular_velocity[parent]
    drift = wp.cross(parent_angular, wp.cross(parent_angular, r))
    x.n += symmetric_times(x.a, bias) + x.b * drift
    x.f += wp.transpose(x.b) * bias + symmetric_times(x.c, drift)
    torque = -work.torque[body]
    kind = skeleton.plan[body].joint_type
    if kind == BALL:
        reduce_ball(body, r, torque, x, work)
    elif kind == FIXED:
        leave_for_parent(body, r, x.a, x.b, x.c, x.n, x.f, work)
    else:
        axis_a = work.rotation[body] * at(skeleton.row, instance, body).axis_a
        if kind == HINGE:
            reduce_hinge(body, r, torque, x, axis_a, work)
        else:
            axis_b = work.rotation[parent] * at(skeleton.row, instance, body).axis_b
            reduce_universal(body, r, torque, x, axis_a, axis_b, work)


@func
def accelerate_root(kind: int, skeleton: Skeleton, work: ScratchRef):
    """Acceleration of the root from its articulated inertia: none if fixed, three of six components if planar."""
    x = with_children(0, skeleton, work)
    alpha = wp.vec3(0.0)
    a = wp.vec3(0.0)
    if kind == ROOT_FREE:
        c = symmetric_inverse(x.c)
        bc = x.b * full(c)
        s = symmetric_inverse(x.a - symmetric_product(bc, wp.transpose(x.b)))
        alpha = symmetric_times(s, bc * x.f - x.n)
        a = symmetric_times(c, -x.f - wp.transpose(x.b) * alpha)
    elif kind == ROOT_PLANAR:
        m = symmetric(x.a[0], x.b[0, 1], x.b[0, 2], x.c[3], x.c[4], x.c[5])
        y = symmetric_times(symmetric_inverse(m), wp.vec3(-x.n[0], -x.f[1], -x.f[2]))
        alpha = wp.vec3(y[0], 0.0, 0.0)
        a = wp.vec3(0.0, y[1], y[2])
    work.angular_acceleration[0] = alpha
    work.acceleration[0] = a


@func
def along_one(fa: wp.mat33, alpha: wp.vec3, a: wp.vec3) -> float:
    """Acceleration of a joint of one speed, see `joint_acceleration`, by the factor that `leave_downdated` has left."""
    p = wp.vec3(fa[0, 0], fa[1, 0], fa[2, 0])
    q = wp.vec3(fa[0, 1], fa[1, 1], fa[2, 1])
    return fa[0, 2] - wp.dot(p, alpha) - wp.dot(q, a)


@func
def joint_acceleration(kind: int, body: int, alpha: wp.vec3, a: wp.vec3, work: ScratchRef) -> wp.vec3:
    """Joint acceleration: about child axes for a ball, else by coordinate, rad/s^2.

    Args:
        alpha: angular acceleration of the parent, world. a: acceleration that the parent gives the joint, world.
    """
    fa = work.factor_a[body]
    if kind == BALL:
        x = work.factor_c[body] - fa * alpha - work.factor_b[body] * a
        return wp.transpose(work.rotation[body]) * x
    if kind == HINGE:
        return wp.vec3(along_one(fa, alpha, a), 0.0, 0.0)
    if kind == UNIVERSAL:
        fb = work.factor_b[body]
        p = wp.vec3(fa[0, 0], fa[1, 0], fa[2, 0])
        q = wp.vec3(fa[0, 1], fa[1, 1], fa[2, 1])
        pb = wp.vec3(fa[0, 2], fa[1, 2], fa[2, 2])
        qb = wp.vec3(fb[0, 0], fb[1, 0], fb[2, 0])
        return wp.vec3(fb[0, 1] - wp.dot(p, alpha) - wp.dot(q, a), fb[1, 1] - wp.dot(pb, alpha) - wp.dot(qb, a), 0.0)
    return wp.vec3(0.0)


@func
def accelerate_body(instance: int, body: int, model: ModelRef, work: ScratchRef):
    """Acceleration of a body and of its joint (left in factor_c) from its parent's; the foot force of the step."""
    skeleton = model.skeleton
    parent = nonnegative(skeleton.plan[body].parent)
    kind = skeleton.plan[body].joint_type
    alpha = work.angular_acceleration[parent]
    a = work.acceleration[parent] + wp.cross(alpha, work.position[body] - work.position[parent])
    x = joint_acceleration(kind, body, alpha, a, work)
    relative = wp.vec3(0.0)
    if kind == BALL:
        relative = work.rotation[body] * x
    elif kind != FIXED:
        relative = work.rotation[body] * at(skeleton.row, instance, body).axis_a * x[0]
        if kind == UNIVERSAL:
            relative += work.rotation[parent] * at(skeleton.row, instance, body).axis_b * x[1]
    move_body(body, alpha, a, x, relative, skeleton, work)


@func
def give_way(slot: int, alpha: wp.vec3, a: wp.vec3, work: ScratchRef):
    """Take from the force on a foot what it gives way as its body accelerates; no foot: a slot below 0."""
    if slot >= 0:
        given_way = symmetric_times(work.contact_c[slot], a) + wp.transpose(work.contact_b[slot]) * alpha
        work.contact_force[slot] = work.contact_force[slot] - given_way


@func
def move_body(
    body: int, parent_alpha: wp.vec3, parent_a: wp.vec3, x: wp.vec3, relative: wp.vec3, skeleton: Skeleton,
    work: ScratchRef,
):  # fmt: skip
    """Acceleration of a body whose joint accelerates by x, which turns it by `relative`, rad/s^2, world.

    Args:
        parent_alpha: angular acceleration of the parent. parent_a: acceleration that it gives the joint.
    """
    parent = nonnegative(skeleton.plan[body].parent)
    r = work.position[body] - work.position[parent]
    parent_angular = work.angular_velocity[parent]
    alpha = parent_alpha + work.bias[body] + relative
    a = parent_a + wp.cross(parent_angular, wp.cross(parent_angular, r))
    work.angular_acceleration[body] = alpha
    work.acceleration[body] = a
    work.factor_c[body] = x
    give_way(skeleton.plan[body].foot_slot, alpha, a, work)


@cache
def backward_pass_of(reduce: Any) -> Any:
    """The Warp function that eliminates all joints, level by level from the tips to the root. It ends with a barrier.

    Args:
        reduce: a Warp function (instance, body, model, work), such as `reduce_body`.
    """

    @func
    def backward_pass(instance: int, lane: int, lanes: int, model: ModelRef, work: ScratchRef):
        for step in range(1, model.level_count):
            level = model.level_count - step
            for body in range(nonnegative(model.level_start[level] + lane), model.level_start[level + 1], lanes):
                reduce(instance, body, model, work)
            synchronize()

    return backward_pass


@cache
def forward_pass_of(visit: Any) -> Any:
    """The Warp function that visits all bodies but the root, level by level from there. It ends with a barrier.

    Args:
        visit: a Warp function (instance, body, model, work), such as `accelerate_body`.
    """

    @func
    def forward_pass(instance: int, lane: int, lanes: int, model: ModelRef, work: ScratchRef):
        for level in range(1, model.level_count):
            for body in range(nonnegative(model.level_start[level] + lane), model.level_start[level + 1], lanes):
                visit(instance, body, model, work)
            synchronize()

    return forward_pass


@cache
def acceleration_stage_of(backward_pass: Any, forward_pass: Any) -> Any:
    """The Warp function of accelerations of all bodies and joints; see the passes. It ends with a barrier."""

    @func
    def acceleration_stage(instance: int, lane: int, lanes: int, model: ModelRef, work: ScratchRef):
        backward_pass(instance, lane, lanes, model, work)
        if lane == 0:
            accelerate_root(model.skeleton.plan[0].joint_type, model.skeleton, work)
        synchronize()
        forward_pass(instance, lane, lanes, model, work)

    return acceleration_stage


acceleration_stage = acceleration_stage_of(backward_pass_of(reduce_body), forward_pass_of(accelerate_body))
