"""Paths round an ellipsoid: in a plane through both ends of a segment and a point c of the ellipsoid, see below.

Contact, side and c are as OpenSim 4.6 has them (WrapEllipsoid). By MIDPOINT c is the point nearest to the middle of the
chord within the ellipsoid; by AXIAL the one nearest to where the chord crosses the plane across the axis that is most
along it, within that plane; by HYBRID, between the two, with the mean of the directions from the chord to the
ellipsoid in place of the middle's. OpenSim takes that mean over 298 places, and so do we if it shall be `as_opensim`
(where the direction turns at once, the places decide how much of it is on either side), else by Gauss's rule. OpenSim
iterates for the tangents and adds up the arc in pieces; we have both in closed form where the ellipsoid is a unit
sphere and the section a circle, the arc but for an integral by Gauss's rule, from which what pieces cut off is taken
if it shall be `as_opensim`.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.path.ellipsoid_arc import arc_as_opensim, arc_on_ellipsoid, gauss_place, most_along
from warpmuscle.kernels.path.ellipsoid_tangent import tangent_as_opensim
from warpmuscle.kernels.path.wrap_touch import INSIDE, THROUGH, Touch, kept_size, on_side

HYBRID, MIDPOINT, AXIAL = 0, 1, 2
FAN_COSINE, AXIAL_COSINE = 0.7073, 0.9  # of the greatest angle to an axis, between which the methods blend
FADED = 0.3  # share of the chord near its ends where the axial method counts less
FAN_PLACES = 5  # of Gauss's rule on each part of the chord
SAMPLES = 300  # parts of it between OpenSim's places, of which the first, the last and the last but one do not count
NEWTON_STEPS = 10
SETTLED = 1.0e-6  # share of the unit sphere's squared radius by which a place may miss it
TOUCHING = 1.0e-4  # squared distance from the middle of the unit sphere that still counts as outside it
SMALLEST = 1.0e-12
ENDLESS = 1.0e30
LEAST_SHARE = 1.0e-3  # of radii that something goes round
ENTERED = 0.12  # depth in the unit sphere, 1 less a squared distance, at which a smooth path is all on its side
NEARLY_ROUND = 6.0  # rad; an arc as long as that is one that has just begun the other way round


@func(inline=False)
def nearest_multiplier(p: wp.vec3, r: wp.vec3, across: int, guess: float) -> float:
    """The t with which r^2 p / (t + r^2) is the point of an ellipsoid with radii r that is nearest to p.

    Newton's method on 1 over the root of sum (r p / (t + r^2))^2, which is nearly linear in t and concave, so that it
    comes from the left, after the first step at the latest (Conn, Gould and Toint 2000, Trust-Region Methods, section
    7.3; for the ellipsoid Eberly 2013).

    Args:
        across: an axis that is left out; -1: none. guess: where it may begin; else where the first term alone is 1.
    """
    square = wp.cw_mul(r, r)
    lever = wp.cw_mul(r, wp.vec3(wp.abs(p[0]), wp.abs(p[1]), wp.abs(p[2])))
    least = wp.length(lever) - wp.max(square[0], wp.max(square[1], square[2]))
    if across >= 0:  # as if it were endless along this axis
        square = wp.vec3(
            wp.where(across == 0, ENDLESS, square[0]), wp.where(across == 1, ENDLESS, square[1]),
            wp.where(across == 2, ENDLESS, square[2]),
        )  # fmt: skip
        least = -ENDLESS
    apart = lever - square
    least = wp.max(least, wp.max(apart[0], wp.max(apart[1], apart[2])))
    t = wp.max(least, guess)
    for _ in range(NEWTON_STEPS):
        away = wp.vec3(
            1.0 / wp.max(t + square[0], SMALLEST), 1.0 / wp.max(t + square[1], SMALLEST),
            1.0 / wp.max(t + square[2], SMALLEST),
        )  # fmt: skip
        x = wp.cw_mul(lever, away)
        squares = wp.cw_mul(x, x)
        total = squares[0] + squares[1] + squares[2]
        if wp.abs(total - 1.0) <= SETTLED:
            break
        t = wp.max(least, t + (wp.sqrt(total) - 1.0) * total / wp.max(wp.dot(squares, away), SMALLEST))
    return t


@func
def nearest_on_ellipsoid(p: wp.vec3, r: wp.vec3, across: int) -> wp.vec3:
    """The point of an ellipsoid with radii r that is nearest to p, or if `across` is an axis of its section there."""
    t = nearest_multiplier(p, r, across, -ENDLESS)
    square = wp.cw_mul(r, r)
    found = wp.cw_mul(square, p)
    return wp.vec3(
        wp.where(across == 0, 0.0, found[0] / wp.max(t + square[0], SMALLEST)),
        wp.where(across == 1, 0.0, found[1] / wp.max(t + square[1], SMALLEST)),
        wp.where(across == 2, 0.0, found[2] / wp.max(t + square[2], SMALLEST)),
    )  # fmt: skip


@func
def outward_at_nearest(p: wp.vec3, r: wp.vec3, t: float) -> wp.vec3:
    """The unit normal of an ellipsoid at its point nearest to p, to which it leads from a p inside; t: see above."""
    square = wp.cw_mul(r, r)
    away = wp.vec3(
        wp.max(t + square[0], SMALLEST), wp.max(t + square[1], SMALLEST), wp.max(t + square[2], SMALLEST)
    )  # fmt: skip
    return wp.normalize(wp.cw_div(p, away))


@func
def turning_place(start: wp.vec3, chord: wp.vec3, r: wp.vec3) -> float:
    """Where along a chord the direction to the ellipsoid turns most, a share of it: nearest to its long axes.

    A flat ellipsoid's nearest point changes sides where the chord crosses the plane of its two longer axes, a long and
    thin one's goes round where the chord passes the longest axis. Which of these it is, weights of axes say.
    """
    longest = wp.max(r[0], wp.max(r[1], r[2]))
    crossed = wp.float32(0.0)
    length = wp.float32(0.0)
    for k in range(3):
        flat = 1.0 / (r[k] * r[k]) - 1.0 / (longest * longest)
        weight = flat * flat * flat * flat
        crossed -= weight * start[k] * chord[k]
        length += weight * chord[k] * chord[k]
    return wp.clamp(crossed / wp.max(length, SMALLEST), 0.0, 1.0)


@func
def fan_by_gauss(start: wp.vec3, chord: wp.vec3, r: wp.vec3) -> wp.vec3:
    """The sum of the directions from a chord within the ellipsoid to that, by Gauss's rule."""
    turns = turning_place(start, chord, r)
    total = wp.vec3(0.0)
    t = wp.float32(-ENDLESS)
    for k in range(2 * FAN_PLACES):
        before = k < FAN_PLACES
        own = gauss_place(wp.where(before, k, k - FAN_PLACES))
        share = wp.where(before, turns, 1.0 - turns)
        place = wp.where(before, 0.0, turns) + share * 0.5 * (1.0 + own[0])
        p = start + chord * place
        t = nearest_multiplier(p, r, -1, t)
        total += outward_at_nearest(p, r, t) * (share * own[1])
    return total


@func
def fan_of_samples(start: wp.vec3, chord: wp.vec3, r: wp.vec3) -> wp.vec3:
    """The same over OpenSim's places."""
    total = wp.vec3(0.0)
    t = wp.float32(-ENDLESS)
    for k in range(1, SAMPLES - 1):
        p = start + chord * (float(k) / float(SAMPLES))
        t = nearest_multiplier(p, r, -1, t)
        total += outward_at_nearest(p, r, t)
    return total


@wp.struct
class Guide:
    """What determines the plane of a path."""

    point: wp.vec3  # of the ellipsoid
    fan: float  # how much the mean direction from the chord counts, 0..1
    beside: int  # 1 where AXIAL has found the point by a place outside the ellipsoid


@cache
def guide_of(as_opensim: bool) -> Any:
    """The Warp function `guide`; `as_opensim`: with the mean of directions over OpenSim's places."""
    fan = fan_of_samples if as_opensim else fan_by_gauss

    @func
    def guide(start: wp.vec3, chord: wp.vec3, r: wp.vec3, method: int) -> Guide:
        """The point that a path's plane goes through, from the part of the segment within the ellipsoid."""
        along = most_along(chord)
        toward = wp.abs(chord[along]) / wp.length(chord)
        result = Guide()
        if method == MIDPOINT:
            result.point = nearest_on_ellipsoid(start + 0.5 * chord, r, -1)
            return result
        t = -start[along] / chord[along]
        if method == HYBRID:
            if toward > FAN_COSINE:
                toward = FAN_COSINE + wp.clamp(wp.min(t, 1.0 - t) / FADED, 0.0, 1.0) * (toward - FAN_COSINE)
            result.fan = wp.clamp(1.0 - (toward - FAN_COSINE) / (AXIAL_COSINE - FAN_COSINE), 0.0, 1.0)
        axial = wp.vec3(0.0)
        if wp.static(as_opensim):
            result.beside = wp.where(method == AXIAL and (t <= 0.0 or t >= 1.0), 1, 0)
        if method == AXIAL or result.fan < 1.0:
            axial = nearest_on_ellipsoid(start + t * chord, r, along)
            result.point = axial
        if method == HYBRID and result.fan > 0.0:
            total = fan(start, chord, r)
            result.point = nearest_on_ellipsoid(start + 0.5 * chord + wp.normalize(total), r, -1)
            if result.fan < 1.0:
                result.point = nearest_on_ellipsoid(axial + (result.point - axial) * result.fan, r, -1)
        return result

    return guide


@func
def circle_tangent(end: wp.vec3, middle: wp.vec3, normal: wp.vec3, square: float, outward: wp.vec3) -> wp.vec3:
    """Where the tangent from a point touches a circle, on the outward side; the point itself if it is on the circle."""
    v = end - middle
    far = wp.dot(v, v)
    across = wp.cross(normal, v)
    if wp.dot(across, outward) < 0.0:
        across = -across
    if far <= square:
        return end
    return middle + (v * square + across * wp.sqrt(square * (far - square))) / far


@func(inline=False)
def touch_as_opensim(
    p: wp.vec3, q: wp.vec3, c: wp.vec3, begin: wp.vec3, begin_of_other: wp.vec3, first: wp.vec3, second: wp.vec3,
    r: wp.vec3, radii: wp.vec3, side: int,
) -> Touch:  # fmt: skip
    """The touch whose places OpenSim's search finds from where it begins; the given ones where it finds none."""
    end = wp.cw_mul(p, r)
    other = wp.cw_mul(q, r)
    through = wp.cw_mul(c, r)
    normal = wp.normalize(wp.cross(other - end, through - end))
    reached = wp.cw_div(tangent_as_opensim(end, wp.cw_mul(begin, r), r, normal, through, wp.cw_mul(first, r)), r)
    start = wp.cw_mul(begin_of_other, r)
    left = wp.cw_div(tangent_as_opensim(other, start, r, normal, through, wp.cw_mul(second, r)), r)
    touch = Touch()
    touch.kind = THROUGH
    touch.first = wp.cw_mul(reached, radii)
    touch.second = wp.cw_mul(left, radii)
    touch.arc = arc_as_opensim(p, q, c, reached, left, radii, side)
    return touch


@cache
def ellipsoid_touch_of(smooth: bool, as_opensim: bool = False) -> Any:
    """The Warp function `ellipsoid_touch`; `smooth`: of one off which no path jumps; `as_opensim`: see `guide_of`."""
    guide_to = guide_of(as_opensim)

    @func(inline=False)
    def ellipsoid_touch(a: wp.vec3, b: wp.vec3, full: wp.vec3, axis: int, side: int, method: int) -> Touch:
        """How a segment from a to b, m, goes round an ellipsoid, which it only does where it would run through it.

        Args:
            full: radii, m. axis, side: the half that a path must stay on: the axis, and 1 or -1; side 0: both.
            method: HYBRID ...
        """
        touch = Touch()
        radii = full
        if wp.static(smooth):
            u = wp.cw_div(a, full)
            v = wp.cw_div(b, full)
            share = kept_size(wp.sqrt(wp.min(wp.dot(u, u), wp.dot(v, v))))
            if share < LEAST_SHARE:
                touch.kind = INSIDE
                return touch
            radii = full * share
        scale = 3.0 / (radii[0] + radii[1] + radii[2])
        r = radii * scale
        p = wp.cw_div(a, radii)  # in the axes where the ellipsoid is a unit sphere
        q = wp.cw_div(b, radii)
        if wp.min(wp.dot(p, p), wp.dot(q, q)) < 1.0 - TOUCHING:
            touch.kind = INSIDE
            return touch
        if wp.abs(wp.dot(a, b) / (wp.length(a) * wp.length(b)) - 1.0) < TOUCHING:
            return touch
        d = q - p
        square = wp.max(wp.dot(d, d), SMALLEST)
        half = wp.dot(p, d)
        near = p - d * (half / square)
        depth = 1.0 - wp.dot(near, near)
        if depth <= 0.0:  # one that only touches has no part within
            return touch
        reach = wp.sqrt(depth / square)
        into = -half / square - reach
        out = -half / square + reach
        if into <= 0.0 or out >= 1.0:
            return touch
        guide = guide_to(wp.cw_mul(r, p + d * into), wp.cw_mul(r, d * (out - into)), r, method)
        c = guide.point
        start = guide.point
        if side != 0 and not on_side(c[axis], side):
            guide.beside = 0
            start[axis] = -start[axis]
            c = start
            if guide.fan > 0.0:
                c[axis] = c[axis] * (1.0 - guide.fan)
                c = nearest_on_ellipsoid(c, r, -1)
            if wp.static(smooth):  # it comes over to its side as the segment goes in
                over = wp.clamp(depth / ENTERED, 0.0, 1.0)
                c = nearest_on_ellipsoid(wp.lerp(guide.point, c, over), r, -1)
                start = c
        c = wp.cw_div(c, r)
        start = wp.cw_div(start, r)
        normal = wp.normalize(wp.cross(d, c - p))
        outward = wp.cross(normal, d)
        if wp.dot(outward, start - p) < 0.0:
            outward = -outward
        middle = normal * wp.dot(normal, c)
        circle = wp.max(1.0 - wp.dot(middle, middle), 0.0)
        first = circle_tangent(p, middle, normal, circle, outward)
        second = circle_tangent(q, middle, normal, circle, outward)
        if wp.static(as_opensim):
            enters = wp.where(guide.beside != 0, p + d * into, start)
            leaves = wp.where(guide.beside != 0, p + d * out, start)
            return touch_as_opensim(p, q, c, enters, leaves, first, second, r, radii, side)
        u = first - middle
        w = second - middle
        # On from the first leg: the way that it reaches the circle.
        turn = wp.where(wp.dot(wp.cross(u, first - p), normal) < 0.0, -1.0, 1.0)
        v = wp.cross(normal, u) * turn
        angle = wp.atan2(wp.dot(w, v), wp.dot(w, u))
        angle = wp.where(angle < 0.0, angle + 2.0 * wp.pi, angle)
        if angle > wp.where(side == 0, wp.pi, NEARLY_ROUND):
            angle -= 2.0 * wp.pi
        touch.kind = THROUGH
        touch.first = wp.cw_mul(first, radii)
        touch.second = wp.cw_mul(second, radii)
        touch.arc = arc_on_ellipsoid(u, v, wp.abs(angle), radii)
        if angle < 0.0:
            touch.arc = arc_on_ellipsoid(u, -v, -angle, radii)
        return touch

    return ellipsoid_touch


ellipsoid_touch = ellipsoid_touch_of(False)
