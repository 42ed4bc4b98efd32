"""Followers that depend on two coordinates q and p: the place and motion subspace that the second one changes.

Two of them in a row share a function f(q, p): the child of the first is where f says and moves by df/dq q', that of the
second one, whose own coordinate is p, moves by df/dp p' besides. So each has one driver, as all followers have, and the
recursions of `followed.py` need not know; only what a joint's subspace is, and how it changes, takes the second
coordinate. The functions are those of `scene.joints.two_coordinates`.
"""

import warp as wp

from warpmuscle.kernels.algebra.bending import DEGREE, SERIES, STRAIGHT
from warpmuscle.kernels.body.joint import hinge_rotation
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at, nonnegative

RATE_ONLY, ROD = 1, 2  # bits of `Coupling.kind`
Series = wp.types.vector(length=DEGREE + 1, dtype=wp.float32)
COEFFICIENTS = wp.constant(Series(*SERIES))


@func
def power(x: float, n: int) -> float:
    """x^n, and 0 where n is negative, as a derivative has it."""
    if n < 0:
        return 0.0
    found = wp.float32(1.0)
    for _ in range(n):
        found *= x
    return found


@func
def term_rates(term: wp.vec4, q: float, p: float) -> wp.vec4:
    """a q^m p^n, and its derivatives by q, q twice, q and p."""
    m = int(term[1])
    n = int(term[2])
    a = term[0]
    by_q = a * term[1] * power(q, m - 1)
    along = power(p, n)
    return wp.vec4(
        a * power(q, m) * along,
        by_q * along,
        a * term[1] * (term[1] - 1.0) * power(q, m - 2) * along,
        by_q * term[2] * power(p, n - 1),
    )


@func
def bend_rates(e: float) -> wp.vec3:
    """sin(theta)/theta where cos(theta) = 1 - e, and its first and second derivatives by cos(theta)."""
    if e <= STRAIGHT:
        f = wp.float32(0.0)
        f1 = wp.float32(0.0)
        f2 = wp.float32(0.0)
        for k in range(DEGREE + 1):
            f2 = f2 * e + 2.0 * f1
            f1 = f1 * e + f
            f = f * e + COEFFICIENTS[DEGREE - k]
        return wp.vec3(f, -f1, f2)
    c = 1.0 - e
    theta = wp.acos(c)
    s = wp.sqrt(wp.max(1.0 - c * c, 1.0e-12))
    return wp.vec3(
        s / theta,
        (s - theta * c) / (theta * theta * s),
        (2.0 / (theta * theta * theta) - (theta + c * s) / (theta * theta * s * s)) / s,
    )


@func
def rod_rates(rod: wp.vec4, component: int, second: bool, q: float, p: float) -> wp.vec4:
    """Where a rod's end is along an axis, and its derivatives by q, q twice, q and p; q is its first or second turn."""
    x = wp.where(second, p, q) + rod[1]
    z = wp.where(second, q, p) + rod[2]
    sx = wp.sin(x)
    cx = wp.cos(x)
    sz = wp.sin(z)
    cz = wp.cos(z)
    c = cx * cz
    c_q = wp.where(second, -cx * sz, -sx * cz)
    c_p = wp.where(second, -sx * cz, -cx * sz)
    c_qp = sx * sz
    h = bend_rates(1.0 - c)
    u = wp.float32(1.0)
    u_q = wp.float32(0.0)
    u_p = wp.float32(0.0)
    u_qq = wp.float32(0.0)
    u_qp = wp.float32(0.0)
    if component != 1:
        part = 1.0 / wp.max(1.0 + c, 1.0e-6)
        g1 = (h[1] - h[0] * part) * part
        h = wp.vec3(h[0] * part, g1, (h[2] - 2.0 * g1) * part)
        u = -sz
        if component == 0:
            if second:
                u_q = -cz
                u_qq = sz
            else:
                u_p = -cz
        else:
            u = sx * cz
            u_q = wp.where(second, -sx * sz, c)
            u_p = wp.where(second, c, -sx * sz)
            u_qq = -u
            u_qp = -cx * sz
    length = rod[0]
    return wp.vec4(
        length * h[0] * u,
        length * (h[1] * c_q * u + h[0] * u_q),
        length * (h[2] * c_q * c_q * u + h[1] * (2.0 * c_q * u_q - c * u) + h[0] * u_qq),
        length * (h[2] * c_q * c_p * u + h[1] * (c_qp * u + c_q * u_p + c_p * u_q) + h[0] * u_qp),
    )


@func
def rates_of_two(
    instance: int, function: int, component: int, kind: int, q: float, p: float, model: ModelRef
) -> wp.vec4:
    """One of the functions of a joint of two coordinates, and its derivatives by q, q twice, q and p."""
    own = at(model.couplings.function, instance, function)
    if kind >= ROD:
        rod = at(model.couplings.piece, instance, own.first_piece).c
        return rod_rates(rod, component, kind - ROD == RATE_ONLY, q, p)
    total = wp.vec4(0.0)
    for k in range(own.first_piece, own.end_piece):
        total += term_rates(at(model.couplings.piece, instance, k).c, q, p)
    return total


@func
def move_by_two(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """In place of what `coordinate_joint.move_any_of` has left of a follower, if it depends on two coordinates."""
    coupling = model.couplings.joint[body]
    if coupling.beside < 0:
        return
    other = model.skeleton.plan[coupling.beside]
    p = state.coordinates[instance, nonnegative(other.coordinate_start)]
    p_rate = state.speeds[instance, nonnegative(other.speed_start)]
    now = work.coordinate_state[body]
    v = now[1]
    turning = wp.vec3(0.0)
    moving = wp.vec3(0.0)
    turning_drift = wp.vec3(0.0)
    drift = wp.vec3(0.0)
    place = wp.vec3(0.0)
    orientation = wp.quat(0.0, 0.0, 0.0, 1.0)
    for k in range(6):
        own = at(model.couplings.function, instance, coupling.first + k).axis
        f = rates_of_two(instance, coupling.first + k, k - 3, coupling.kind, now[0], p, model)
        along = own * f[1]
        bent = own * ((f[2] * v + f[3] * p_rate) * v)
        if k < 3:
            turning += along
            turning_drift += bent
            orientation = orientation * hinge_rotation(own, f[0])
        else:
            moving += along
            drift += bent
            place += own * f[0]
    if coupling.kind == RATE_ONLY or coupling.kind == RATE_ONLY + ROD:
        place = wp.vec3(0.0)
        orientation = wp.quat(0.0, 0.0, 0.0, 1.0)
    work.anchor[body] = at(model.skeleton.row, instance, body).anchor + place
    work.turned[body] = orientation
    work.parent_rate[body] = turning * v
    work.parent_gain[body] = turning * now[2]
    work.coordinate_turning[body] = turning
    work.coordinate_moving[body] = moving
    work.coordinate_turning_drift[body] = turning_drift
    work.coordinate_drift[body] = drift
