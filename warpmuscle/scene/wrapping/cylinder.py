"""Segments of a path round a cylinder about z, as OpenSim 4.6 takes them (WrapCylinder)."""

from __future__ import annotations

import math

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene.wrapping.touch import BESIDE, FREE, INSIDE, THROUGH, Touch, kept_size, sign, untouched

IN_PLANE, AMONG_OTHERS, EXACT = 0, 1, 2  # where the tangent points are along the axis
LEAST_SHARE = 1.0e-4  # of a radius that something goes round
SHORT = 0.004  # m, of an arc that OpenSim does not bend so that it is tangent to both legs
SLIDES = 100  # of places of touch, at most
PIECE = 0.002  # m, of an arc
TANGENT = math.radians(0.1)  # between leg and arc


def cylinder_touch(
    a: Floats,
    b: Floats,
    full: float,
    length: float,
    axis: int,
    side: int,
    where: int,
    smooth: bool = False,
    as_opensim: bool = False,
) -> Touch:
    """How a segment from a to b goes round a cylinder.

    Args:
        a, b: (3,) m. full: radius. length: between the ends, beyond both of which nothing touches.
        axis, side: the half of the cylinder that a path must stay on: the axis, and 1 or -1; 0: both halves.
        where: `EXACT`: the path is the shortest one. `IN_PLANE`: it lies in OpenSim's plane, as those round one surface
            do. `AMONG_OTHERS`: as those round several do there, in that plane if the arc is short, else the shortest.
        smooth: the cylinder shrinks as an end of the segment goes inside, and of two ways on the side the path takes
            the short one.
    """
    da, db = math.hypot(a[0], a[1]), math.hypot(b[0], b[1])
    share = kept_size(min(da, db) / full) if smooth else 1.0
    radius = share * full
    beyond = share < 1.0 and side != 0 and side not in (sign(a[axis]), sign(b[axis]))
    if share < LEAST_SHARE or min(da, db) < radius or beyond:
        return untouched(INSIDE)
    kind = _meeting(a, b, radius, axis, side)
    if kind == FREE:
        return untouched()
    ways = _tangents(a, da, radius), _tangents(b, db, radius)
    if side == 0:
        first, second = max(((p, q) for p in ways[0] for q in ways[1]), key=lambda pair: float(pair[0] @ pair[1]))
    else:
        first, second = _on_side(ways, a, b, axis, side, smooth)
    out = (first - a[:2]) + (second - b[:2])
    round_behind = side != 0 and float((first + second) @ out) < 0.0
    angle = math.acos(min(max(float(first @ second) / radius**2, -1.0), 1.0))
    anticlockwise = float(first[0] * second[1]) >= float(first[1] * second[0])
    if round_behind:
        angle = 2.0 * math.pi + (angle if as_opensim and not anticlockwise else -angle)
    za, zb = _in_plane(a, b, da, db, first, second)
    long = math.hypot(radius * angle, zb - za) >= SHORT
    if not as_opensim and (where == EXACT or (where == AMONG_OTHERS and long)):
        za, zb = _unrolled(a, b, first, second, radius * angle)
    if min(abs(za), abs(zb)) > 0.5 * length:
        return untouched(FREE)
    if as_opensim and where == AMONG_OTHERS:
        way = 1.0 if anticlockwise and not round_behind else -1.0
        za, zb = _slid(np.append(first, za), np.append(second, zb), a, b, radius, way * angle)
    return Touch(kind, np.append(first, za), np.append(second, zb), math.hypot(radius * angle, zb - za))


def _meeting(a: Floats, b: Floats, radius: float, axis: int, side: int) -> int:
    """How a segment with both ends outside meets an endless cylinder: FREE, BESIDE or THROUGH."""
    through, near = _nearest(a, b, radius)
    if side == 0:
        return THROUGH if through else FREE
    sides = sign(a[axis]), sign(b[axis])
    if side not in sides:
        return BESIDE
    if through:
        return THROUGH
    return FREE if sides[0] == sides[1] or sign(near[axis]) == side else BESIDE


def _slid(first: Floats, second: Floats, a: Floats, b: Floats, radius: float, angle: float) -> tuple[float, float]:
    """Heights of both tangent points where OpenSim has slid them until the path is nearly tangent there.

    A turn about the axis, rad, leads from the first to the second one. OpenSim compares the slope of each leg with that
    of the first or last piece of the arc, of 2 mm, and moves the point by half as much again as would make them equal;
    the last piece goes up with the first point, if that has just been moved.
    """
    for _ in range(SLIDES):
        rise = second[2] - first[2]
        count = int(math.hypot(radius * angle, rise) / PIECE)
        if count < 2:
            break
        before = first[2], second[2]
        share = 1.0 / count
        first = _slide(first, a, first, angle * share, rise * share)
        second = _slide(second, b, first, angle * (1.0 - share), rise * (1.0 - share))
        if (first[2], second[2]) == before:
            break
    return float(first[2]), float(second[2])


def _slide(place: Floats, end: Floats, first: Floats, turn: float, rise: float) -> Floats:
    """A tangent point after a slide, between the end of its leg and a place on the arc."""
    c, s = math.cos(turn), math.sin(turn)
    on_arc = np.array([c * first[0] - s * first[1], s * first[0] + c * first[1], first[2] + rise])
    leg, arc = place - end, on_arc - place
    if abs(math.atan2(math.hypot(*leg[:2]), leg[2]) - math.atan2(math.hypot(*arc[:2]), arc[2])) <= TANGENT:
        return place
    way = on_arc - end
    share = float(leg[:2] @ way[:2]) / float(way[:2] @ way[:2])
    return np.append(place[:2], place[2] + 1.5 * (end[2] + share * way[2] - place[2]))


def _nearest(a: Floats, b: Floats, radius: float) -> tuple[bool, Floats]:
    """Whether a segment runs through an endless cylinder, and the point of its line that is nearest to the axis."""
    d = b - a
    square = d[0] ** 2 + d[1] ** 2
    if square <= 2e-15 * float(d @ d):  # along the axis
        return False, a
    t = -(a[0] * d[0] + a[1] * d[1]) / square
    near = a + t * d
    return bool(near[0] ** 2 + near[1] ** 2 < radius**2 and 0.0 < t < 1.0), near


def _tangents(p: Floats, distance: float, radius: float) -> tuple[Floats, Floats]:
    """Where the tangents from a point touch the circle, (2,) m: further on counter-clockwise, and clockwise."""
    v = p[:2] / distance
    along, across = radius**2 / distance, radius * math.sqrt(max(1.0 - (radius / distance) ** 2, 0.0))
    u = np.array([-v[1], v[0]])
    return along * v + across * u, along * v - across * u


def _on_side(
    ways: tuple[tuple[Floats, Floats], tuple[Floats, Floats]], a: Floats, b: Floats, axis: int, side: int, smooth: bool
) -> tuple[Floats, Floats]:
    """The pair of tangent points on the side."""
    (a_on, a_back), (b_on, b_back) = ways
    wider = float(a_on @ b_back) < float(a_back @ b_on)  # the angle between the first two than between the others

    def on(p: Floats, z: float) -> bool:
        return sign(z if axis == 2 else p[axis]) == side

    a_sides = on(a_on, a[2]), on(a_back, a[2])
    if smooth and all(a_sides) and on(b_on, b[2]) and on(b_back, b[2]):
        forward = not wider
    elif a_sides[0] != a_sides[1]:
        forward = a_sides[0]
    elif on(b_on, b[2]):
        forward = False
    elif a_sides[0] or on(b_back, b[2]):
        forward = True
    else:
        forward = wider
    return (a_on, b_back) if forward else (a_back, b_on)


def _in_plane(a: Floats, b: Floats, da: float, db: float, first: Floats, second: Floats) -> tuple[float, float]:
    """Heights of both tangent points in the plane through a, b and the bisector of their directions from the axis."""
    rise = b[2] - a[2]
    bisector = a[:2] / da + b[:2] / db
    across = np.array([-bisector[1], bisector[0]])
    span = float(across @ (b[:2] - a[:2]))
    size = float(np.linalg.norm(across))
    # OpenSim gives up where the plane is so steep that the share of its unit normal along z is less than 5e-7.
    if rise == 0.0 or abs(span) <= 5e-7 * math.hypot(rise * size, span):
        return a[2], b[2]
    middle = a[2] + da / (da + db) * rise
    za, zb = (middle + float(across @ p) * rise / span for p in (first, second))
    return (za if abs(za - b[2]) < abs(rise) else a[2], zb if abs(zb - a[2]) < abs(rise) else b[2])


def _unrolled(a: Floats, b: Floats, first: Floats, second: Floats, arc: float) -> tuple[float, float]:
    """Heights of both tangent points where the path is straight on the unrolled cylinder."""
    before, after = float(np.linalg.norm(first - a[:2])), float(np.linalg.norm(second - b[:2]))
    rise = (b[2] - a[2]) / (before + arc + after)
    return a[2] + before * rise, b[2] - after * rise
