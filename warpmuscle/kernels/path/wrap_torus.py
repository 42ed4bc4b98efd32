"""Paths through a torus about z, with contact and side as OpenSim 4.6 has them (WrapTorus).

Where the segment is nearest to the circle in the middle of the ring, a cylinder along the circle stands for the ring,
and the path stays on the side of it that looks to the ring's centre. OpenSim looks for the nearest place from both
ends; the equation that it solves has twice the distance from the axis in it, and so have we.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.path.wrap_cylinder import cylinder_touch_of
from warpmuscle.kernels.path.wrap_touch import BESIDE, Touch, on_side

ENDLESS = 1.0e4  # m, length of the cylinder
STEPS = 20  # of the search for the nearest place, more than it needs
FIRST_REACH = 0.2  # of the search, times the slope at its start
TOLERANCE = 1.0e-4  # of the square of what is to be 0, and of the distance, to their values before
WORTHLESS = 1.0e-4  # share of the expected gain below which a step is not taken
AHEAD = 1.0e-5  # m, over which OpenSim's search takes differences
DAMPINGS = 10  # that are tried for a step
OPENSIM_STEPS = 100  # more than it needs
SMALLEST = 1.0e-12
STEEP = 0.25  # of a ring by the bend of the distance from the axis, up to which there is one place beyond doubt


@func
def circle_slope(u: float, along: float, flat: float, square: float, rest: float, ring: float) -> wp.vec2:
    """What is 0 where the search ends, and its derivative, at a distance u along the line; see `place_from`."""
    away = wp.sqrt(wp.max(u * u * square + 2.0 * flat * u + rest, SMALLEST))
    inward = square * u + flat
    bend = square / away - inward * inward / (away * away * away)
    return wp.vec2(2.0 * (along + u - 2.0 * ring * inward / away), 2.0 * (1.0 - 2.0 * ring * bend))


@func
def circle_slope_in_double(
    u: wp.float64, along: wp.float64, flat: wp.float64, square: wp.float64, rest: wp.float64, ring: wp.float64
) -> wp.vec2d:
    """The same in double precision."""
    one = wp.float64(1.0)
    two = wp.float64(2.0)
    away = wp.sqrt(wp.max(u * u * square + two * flat * u + rest, wp.float64(SMALLEST)))
    inward = square * u + flat
    bend = square / away - inward * inward / (away * away * away)
    return wp.vec2d(two * (along + u - two * ring * inward / away), two * (one - two * ring * bend))


@func
def narrowed(reach: float, size: float, gain: float, expected: float, after: float, before: float) -> float:
    """Reach of a search after a step that gained much less than expected."""
    share = wp.float32(0.5)
    if gain < 0.0:
        share = 0.5 * expected / (expected - 0.5 * gain)
    if 0.1 * after >= before or share < 0.1:
        share = 0.1
    return share * wp.min(reach, 10.0 * size)


@func(inline=False)
def place_from(a: wp.vec3, b: wp.vec3, ring: float) -> wp.vec3:
    """The place on the line from a to b that OpenSim's search for the one nearest to the circle finds, from a on.

    Levenberg's and Marquardt's method for one unknown with steps within a reach (MINPACK's lmdif; More 1978). Where
    there are several places, its first steps say which one is found.
    """
    n = wp.normalize(b - a)
    along = wp.dot(a, n)
    flat = a[0] * n[0] + a[1] * n[1]
    square = n[0] * n[0] + n[1] * n[1]
    rest = a[0] * a[0] + a[1] * a[1]
    u = wp.float32(0.0)
    f = circle_slope(u, along, flat, square, rest, ring)
    scale = wp.float32(0.0)  # the greatest slope so far
    reach = wp.float32(FIRST_REACH)
    moved = wp.bool(False)
    for _ in range(STEPS):
        if f[0] == 0.0 or f[1] == 0.0:
            break
        slope = wp.abs(f[1])
        before = wp.abs(f[0])
        scale = wp.max(scale, slope)
        size = scale * before / slope
        damping = wp.float32(0.0)
        if size > 1.1 * reach:
            size = reach
            damping = wp.max(slope * before / (scale * reach) - slope * slope / (scale * scale), 0.0)
        step = -wp.sign(f[0] * f[1]) * size / scale
        if not moved:
            reach = wp.min(reach, size)
        after = circle_slope(u + step, along, flat, square, rest, ring)
        left = wp.abs(after[0]) / before
        gain = wp.where(left < 10.0, 1.0 - left * left, -1.0)
        straight = slope * step / before
        held = damping * (size / before) * (size / before)
        expected = straight * straight + 2.0 * held
        if gain <= 0.25 * expected:
            reach = narrowed(reach, size, gain, straight * straight + held, left, 1.0)
        elif damping == 0.0 or gain >= 0.75 * expected:
            reach = 2.0 * size
        if gain >= WORTHLESS * expected:
            moved = True
            u += step
            f = after
        if wp.abs(gain) <= TOLERANCE and expected <= TOLERANCE and gain <= 2.0 * expected:
            break
        if reach <= TOLERANCE * scale * wp.abs(u):
            break
    return a + n * u


@func
def narrowed_in_double(
    reach: wp.float64, size: wp.float64, gain: wp.float64, expected: wp.float64, after: wp.float64
) -> wp.float64:
    """`narrowed` in double precision, with `after` over what was before."""
    half = wp.float64(0.5)
    share = wp.float64(0.5)
    tenth = wp.float64(0.1)
    if gain < wp.float64(0.0):
        share = half * expected / (expected - half * gain)
    if tenth * after >= wp.float64(1.0) or share < tenth:
        share = tenth
    return share * wp.min(reach, wp.float64(10.0) * size)


@func
def damped_step(
    f: wp.float64, slope: wp.float64, scale: wp.float64, reach: wp.float64, damping: wp.float64
) -> wp.vec2d:  # fmt: skip
    """A step's length and the damping with which, times the scale, it is within a tenth of the reach (lmpar).

    Args:
        f, slope: of the function, absolute values. damping: of the step before, with which the search begins.
    """
    one = wp.float64(1.0)
    tenth = wp.float64(0.1)
    step = f / slope
    size = scale * step
    if size <= (one + tenth) * reach:
        return wp.vec2d(step, wp.float64(0.0))
    part = slope / scale
    least = (size / reach - one) * part * part
    held = wp.min(wp.max(damping, least), part * f / reach)
    for _ in range(DAMPINGS):
        square = part * part + held
        step = part * f / (scale * square)
        over = scale * step / reach - one
        if wp.abs(over) <= tenth:
            break
        if over > wp.float64(0.0):
            least = wp.max(least, held)
        held = wp.max(least, held + over * square)
    return wp.vec2d(step, held)


@func(inline=False)
def place_as_opensim(a: wp.vec3, b: wp.vec3, circle: float) -> wp.vec3:
    """What `place_from` finds where slopes are those over AHEAD, in the middle of it, and steps are OpenSim's, too.

    In double precision: where the search ends depends on small differences.
    """
    start = wp.vec3d(a)
    n = wp.normalize(wp.vec3d(b) - start)
    ring = wp.float64(circle)
    flat = start[0] * n[0] + start[1] * n[1]
    along = flat + start[2] * n[2]
    square = n[0] * n[0] + n[1] * n[1]
    rest = start[0] * start[0] + start[1] * start[1]
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    two = wp.float64(2.0)
    half = wp.float64(0.5)
    small = wp.float64(TOLERANCE)
    middle = wp.float64(0.5 * AHEAD)
    u = wp.float64(0.0)
    f = circle_slope_in_double(u, along, flat, square, rest, ring)[0]
    slope = circle_slope_in_double(middle, along, flat, square, rest, ring)[1]
    scale = wp.float64(0.0)
    reach = wp.float64(FIRST_REACH)
    damping = wp.float64(0.0)
    moved = wp.bool(False)
    for _ in range(OPENSIM_STEPS):
        if f == zero or slope == zero:
            break
        scale = wp.max(scale, wp.abs(slope))
        damped = damped_step(wp.abs(f), wp.abs(slope), scale, reach, damping)
        damping = damped[1]
        size = scale * damped[0]
        step = -wp.sign(f * slope) * damped[0]
        if not moved:
            reach = wp.min(reach, size)
        after = circle_slope_in_double(u + step, along, flat, square, rest, ring)[0]
        left = wp.abs(after / f)
        gain = wp.where(left < wp.float64(10.0), one - left * left, -one)
        straight = (slope * step / f) * (slope * step / f)
        held = damping * (size / f) * (size / f)
        expected = straight + two * held
        if gain <= wp.float64(0.25) * expected:
            before = reach
            reach = narrowed_in_double(reach, size, gain, straight + held, left)
            damping = damping * wp.min(before, wp.float64(10.0) * size) / reach
        elif damping == zero or gain >= wp.float64(0.75) * expected:
            reach = two * size
            damping = half * damping
        if gain >= wp.float64(WORTHLESS) * expected:
            moved = True
            u += step
            f = after
            slope = circle_slope_in_double(u + middle, along, flat, square, rest, ring)[1]
        if wp.abs(gain) <= small and expected <= small and gain <= two * expected:
            break
        if reach <= small * scale * wp.abs(u):
            break
    return wp.vec3(start + n * u)


@func
def one_place(a: wp.vec3, b: wp.vec3, ring: float) -> bool:
    """Whether the search ends at the same place from a and from b, for what it makes 0 grows all along the line.

    Its slope is 2 (1 - 2 ring bend), with the bend greatest where the line is nearest to the axis.
    """
    n = wp.normalize(b - a)
    square = n[0] * n[0] + n[1] * n[1]
    beside = a[0] * n[1] - a[1] * n[0]  # the root of square times how near the line comes to the axis
    steepest = ring * square
    return steepest * steepest * square <= STEEP * STEEP * beside * beside


@func
def from_circle(p: wp.vec3, ring: float) -> float:
    """Squared distance of a place from the circle, m^2."""
    inward = wp.sqrt(p[0] * p[0] + p[1] * p[1]) - ring
    return inward * inward + p[2] * p[2]


@func
def least_detour(a: wp.vec3, b: wp.vec3, section: float) -> float:
    """What a segment from a to b, m, becomes longer by at least if it is led to a torus of this section.

    The cylinder that stands for the ring lies across z: so it is within the section of the torus's plane, as far as it
    reaches to the sides.
    """
    above = wp.max(wp.abs(a[2]) - section, 0.0)
    beyond = wp.max(wp.abs(b[2]) - section, 0.0)
    if a[2] * b[2] <= 0.0:
        return 0.0
    d = b - a
    there_and_back = above + beyond
    flat = d[0] * d[0] + d[1] * d[1]
    return wp.sqrt(flat + there_and_back * there_and_back) - wp.sqrt(flat + (above - beyond) * (above - beyond))


@cache
def torus_touch_of(as_opensim: bool) -> Any:
    """The Warp function `torus_touch`; `as_opensim`: whether its arc is OpenSim's, see `wrap_cylinder.py`."""
    cylinder_touch = cylinder_touch_of(False, as_opensim)
    search = place_as_opensim if as_opensim else place_from

    @func(inline=False)
    def torus_touch(a: wp.vec3, b: wp.vec3, section: float, ring: float, axis: int, side: int, where: int) -> Touch:
        """How a segment from a to b, m, goes through a torus.

        Args:
            section, ring: radii of the section and of the circle in the middle, m. where: see `wrap_cylinder.py`.
            axis, side: the half of the circle that a path must be near: the axis, and 1 or -1; side 0: both.
        """
        touch = Touch()
        place = search(a, b, ring)
        other = wp.vec3(place)
        if wp.static(as_opensim) or not one_place(a, b, ring):
            other = search(b, a, ring)
        if side == 0:
            if from_circle(other, ring) <= from_circle(place, ring):
                place = other
        else:
            on = on_side(place[axis], side)
            other_on = on_side(other[axis], side)
            if not on and not other_on:
                return touch
            if other_on and (not on or from_circle(other, ring) <= from_circle(place, ring)):
                place = other
        flat = wp.sqrt(place[0] * place[0] + place[1] * place[1])
        if flat < SMALLEST:
            return touch
        center = wp.vec3(place[0], place[1], 0.0) * (ring / flat)
        x = center / -ring
        y = wp.vec3(0.0, 0.0, -1.0)
        turn = wp.matrix_from_rows(x, y, wp.cross(x, y))
        touch = cylinder_touch(turn * (a - center), turn * (b - center), section, ENDLESS, 0, 1, where)
        if touch.kind >= BESIDE:
            touch.kind = BESIDE
            touch.first = center + wp.transpose(turn) * touch.first
            touch.second = center + wp.transpose(turn) * touch.second
        return touch

    return torus_touch


torus_touch = torus_touch_of(False)
