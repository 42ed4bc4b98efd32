"""Paths round a cylinder about z.

Side, contact and ends are as OpenSim 4.6 has them (WrapCylinder): a segment with an end inside stays straight, and so
does one that touches beyond both ends of the cylinder; else it has no end. Round one surface, OpenSim's path lies in
the plane through both ends and the bisector of their directions from the axis (IN_PLANE). Round several (AMONG_OTHERS)
it slides along the axis until it is nearly tangent, and so does ours if it shall be `as_opensim`; else, unless it is
short, it is the shortest one, straight on the unrolled cylinder, and so is an EXACT one. For a long way round OpenSim
turns anticlockwise about the axis, and where that is clockwise it goes the short way and one turn more.
"""

import math
from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.path.wrap_touch import FREE, INSIDE, THROUGH, Touch, allowed, kept_size, larger, on_side

LEVEL = 5.0e-7  # share of a plane's normal along z below which the plane counts as upright
SMALLEST = 1.0e-12  # m^2
IN_PLANE, AMONG_OTHERS, EXACT = 0, 1, 2
LEAST_SHARE = 1.0e-4  # of a radius that something goes round
SHORT = 0.004  # m, of an arc that OpenSim does not bend so that it is tangent to both legs
SLIDES = 100  # of places of touch, at most
PIECE = 0.002  # m, of an arc, whose slope is compared with that of the leg
TANGENT = math.radians(0.1)  # between the two
OVERSHOT = 1.5  # how much farther OpenSim slides than would make them equal


@func
def coordinate_of_point(p: wp.vec2, z: float, axis: int) -> float:
    """A coordinate of the point p at the height z."""
    return wp.where(axis == 0, p[0], wp.where(axis == 1, p[1], z))


@func
def tangent(p: wp.vec2, radius: float, way: float) -> wp.vec2:
    """Where the tangent from a point outside touches the circle; way 1: on counter-clockwise, -1: back."""
    square = wp.dot(p, p)
    leg = way * wp.sqrt(wp.max(square - radius * radius, 0.0))
    return wp.vec2(radius * p[0] - leg * p[1], radius * p[1] + leg * p[0]) * (radius / square)


@func
def plane_height(za: float, zb: float, z: float) -> float:
    """Height of a tangent point of the end at za; that of the end itself where it would be beyond the other one."""
    return wp.where(wp.abs(z - zb) < wp.abs(zb - za), z, za)


@func
def heights_in_plane(a: wp.vec3, b: wp.vec3, first: wp.vec2, second: wp.vec2) -> wp.vec2:
    """Heights of both tangent points in the plane through a, b and the bisector of their directions from the axis."""
    pa = wp.vec2(a[0], a[1])
    pb = wp.vec2(b[0], b[1])
    da = wp.length(pa)
    db = wp.length(pb)
    rise = b[2] - a[2]
    bisector = pa / da + pb / db
    across_it = wp.vec2(-bisector[1], bisector[0])
    span = wp.dot(across_it, pb - pa)
    if wp.abs(span) <= LEVEL * (wp.abs(rise) * wp.length(bisector) + wp.abs(span)):
        return wp.vec2(a[2], b[2])
    slope = rise / span
    middle = a[2] + da / (da + db) * rise
    return wp.vec2(
        plane_height(a[2], b[2], middle + wp.dot(across_it, first) * slope),
        plane_height(b[2], a[2], middle + wp.dot(across_it, second) * slope),
    )


@func
def heights_unrolled(a: wp.vec3, b: wp.vec3, first: wp.vec2, second: wp.vec2, arc: float) -> wp.vec2:
    """Heights of both tangent points on the shortest path, whose slope is the same all the way."""
    before = wp.length(first - wp.vec2(a[0], a[1]))
    after = wp.length(second - wp.vec2(b[0], b[1]))
    slope = (b[2] - a[2]) / wp.max(before + arc + after, SMALLEST)
    return wp.vec2(a[2] + before * slope, b[2] - after * slope)


@func
def slide(leg: float, flat: float, ahead: float, arc: float, chord: float, cosine: float) -> float:
    """How far OpenSim slides a place of touch along the axis, m.

    Args:
        leg, flat: how far the leg to the place goes up, and how far along the tangent. arc, chord: the same of a piece
            of the arc that follows. ahead: 1: it goes on from the leg; -1: back. cosine: of the angle between the two.
    """
    off = wp.atan2(flat, leg) - wp.atan2(wp.abs(chord), arc)
    if wp.abs(off) <= wp.static(TANGENT):
        return 0.0
    along = ahead * flat * chord * cosine
    share = (flat * flat + along) / wp.max(flat * flat + 2.0 * along + chord * chord, SMALLEST)
    return OVERSHOT * (share * (leg + arc) - leg)


@func(inline=False)
def slid_heights(
    a: wp.vec3, b: wp.vec3, first: wp.vec2, second: wp.vec2, heights: wp.vec2, radius: float, turn: float
) -> wp.vec2:
    """Heights of both tangent points where OpenSim has slid them; a turn, rad, leads from the first to the second."""
    to_first = first - wp.vec2(a[0], a[1])
    to_second = second - wp.vec2(b[0], b[1])
    first_ahead = wp.where(wp.dot(to_first, wp.vec2(-first[1], first[0])) * turn < 0.0, -1.0, 1.0)
    second_ahead = wp.where(wp.dot(to_second, wp.vec2(second[1], -second[0])) * turn < 0.0, -1.0, 1.0)
    low = wp.float32(heights[0])
    high = wp.float32(heights[1])
    for _ in range(SLIDES):
        rise = high - low
        count = wp.floor(wp.sqrt(radius * turn * radius * turn + rise * rise) / PIECE)
        if count < 2.0:
            break
        share = 1.0 / count
        half = 0.5 * wp.abs(turn) * share
        chord = 2.0 * radius * wp.sin(half)
        cosine = wp.cos(half)
        up = slide(low - a[2], wp.length(to_first), first_ahead, rise * share, chord, cosine)
        # The last piece goes up with the first point, as OpenSim has it.
        piece = up - rise * share
        down = slide(high - b[2], wp.length(to_second), second_ahead, piece, chord, cosine)
        if up == 0.0 and down == 0.0:
            break
        low += up
        high += down
    return wp.vec2(low, high)


@cache
def meeting_of(smooth: bool) -> Any:
    """The Warp function (a, b, full, radius, axis, side) -> how a segment with both ends outside meets a cylinder.

    `full` and `radius`: of the cylinder, and what is left of it; others as of `cylinder_touch_of`.
    """

    @func
    def meeting(a: wp.vec3, b: wp.vec3, full: float, radius: float, axis: int, side: int) -> int:
        pa = wp.vec2(a[0], a[1])
        pb = wp.vec2(b[0], b[1])
        d = pb - pa
        t = -wp.dot(pa, d) / wp.max(wp.dot(d, d), SMALLEST)
        near = pa + d * t
        through = wp.dot(near, near) < radius * radius and t > 0.0 and t < 1.0
        kind = wp.where(through, THROUGH, FREE)
        if side != 0:
            za = coordinate_of_point(pa, a[2], axis)
            zb = coordinate_of_point(pb, b[2], axis)
            kind = allowed(za, zb, coordinate_of_point(near, a[2] + t * (b[2] - a[2]), axis), side, through)
            if wp.static(smooth) and radius < full and not on_side(za, side) and not on_side(zb, side):
                kind = FREE  # an end inside does not take what is on the wrong side round
        return kind

    return meeting


@cache
def goes_forward_of(smooth: bool) -> Any:
    """The Warp function that chooses between the two ways round a cylinder with a side; True: counter-clockwise first.

    The ways lead from `a_on` to `b_back`, and from `a_back` to `b_on`, see `tangent`.
    """

    @func
    def goes_forward(
        a_on: wp.vec2, a_back: wp.vec2, za: float, b_on: wp.vec2, b_back: wp.vec2, zb: float, on_back: float,
        back_on: float, axis: int, side: int,
    ) -> bool:  # fmt: skip
        on_a = on_side(coordinate_of_point(a_on, za, axis), side)
        back_a = on_side(coordinate_of_point(a_back, za, axis), side)
        on_b = on_side(coordinate_of_point(b_on, zb, axis), side)
        back_b = on_side(coordinate_of_point(b_back, zb, axis), side)
        forward = wp.where(on_a != back_a, on_a, not on_b)
        if not on_a and not back_a and not on_b and not back_b:
            forward = on_back < back_on
        if wp.static(smooth) and on_a and back_a and on_b and back_b:
            forward = on_back > back_on  # the short way, where OpenSim may go the long one
        return forward

    return goes_forward


@cache
def cylinder_touch_of(smooth: bool, as_opensim: bool = False) -> Any:
    """The Warp function `cylinder_touch`; `smooth`: of one off which no path jumps; `as_opensim`: see above."""
    meeting, goes_forward = meeting_of(smooth), goes_forward_of(smooth)

    @func
    def cylinder_touch(a: wp.vec3, b: wp.vec3, full: float, length: float, axis: int, side: int, where: int) -> Touch:
        """How a segment from a to b, m, goes round a cylinder.

        Args:
            full: radius, m. length: between the ends. where: IN_PLANE, AMONG_OTHERS or EXACT, see above.
            axis, side: the half that a path must stay on: the axis, and 1 or -1; side 0: both.
        """
        touch = Touch()
        pa = wp.vec2(a[0], a[1])
        pb = wp.vec2(b[0], b[1])
        radius = full
        if wp.static(smooth):
            radius = full * kept_size(wp.sqrt(wp.min(wp.dot(pa, pa), wp.dot(pb, pb))) / full)
            if radius < LEAST_SHARE * full:
                touch.kind = INSIDE
                return touch
        square = radius * radius
        if wp.dot(pa, pa) < square or wp.dot(pb, pb) < square:
            touch.kind = INSIDE
            return touch
        kind = meeting(a, b, full, radius, axis, side)
        if kind == FREE:
            return touch
        a_on = tangent(pa, radius, 1.0)
        a_back = tangent(pa, radius, -1.0)
        b_on = tangent(pb, radius, 1.0)
        b_back = tangent(pb, radius, -1.0)
        on_back = wp.dot(a_on, b_back)  # cosines of the angles between them, times the square of the radius
        back_on = wp.dot(a_back, b_on)
        first = a_on
        second = b_back
        around = wp.bool(False)
        if side == 0:
            pair = larger(wp.dot(a_on, b_on), on_back, back_on, wp.dot(a_back, b_back))
            first = wp.where(pair < 2, a_on, a_back)
            second = wp.where(pair == 0 or pair == 2, b_on, b_back)
        else:
            if not goes_forward(a_on, a_back, a[2], b_on, b_back, b[2], on_back, back_on, axis, side):
                first = a_back
                second = b_on
            around = wp.dot(first + second, first - pa + second - pb) < 0.0
        angle = wp.atan2(wp.abs(first[0] * second[1] - first[1] * second[0]), wp.dot(first, second))
        anticlockwise = wp.static(not as_opensim) or first[0] * second[1] >= first[1] * second[0]
        if around:
            angle = 2.0 * wp.pi + wp.where(anticlockwise, -angle, angle)
        arc = radius * angle
        heights = heights_in_plane(a, b, first, second)
        rise = heights[1] - heights[0]
        if wp.static(not as_opensim):  # noqa: SIM102, with `and` it would be compiled in all the same
            if where == EXACT or (where == AMONG_OTHERS and arc * arc + rise * rise >= SHORT * SHORT):
                heights = heights_unrolled(a, b, first, second, arc)
        if wp.abs(heights[0]) > 0.5 * length and wp.abs(heights[1]) > 0.5 * length:
            return touch
        if wp.static(as_opensim):  # noqa: SIM102, as above
            if where == AMONG_OTHERS:
                way = wp.where(anticlockwise and not around, 1.0, -1.0)
                heights = slid_heights(a, b, first, second, heights, radius, way * angle)
        rise = heights[1] - heights[0]
        touch.kind = kind
        touch.first = wp.vec3(first[0], first[1], heights[0])
        touch.second = wp.vec3(second[0], second[1], heights[1])
        touch.arc = wp.sqrt(arc * arc + rise * rise)
        return touch

    return cylinder_touch
