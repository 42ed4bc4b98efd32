"""Segments of a path round an ellipsoid, as OpenSim 4.6 takes them (WrapEllipsoid): in a plane through both ends.

The plane also goes through a point c on the ellipsoid. By the method `midpoint` that is the one nearest to the middle
of the chord within the ellipsoid; by `axial` the one nearest to where the chord crosses the plane across the axis that
is most along it, within that plane; by `hybrid`, between the two, with the mean of the directions from the chord to
the ellipsoid in place of the middle's.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene.wrapping.ellipsoid_tangent import tangent_of
from warpmuscle.scene.wrapping.touch import INSIDE, THROUGH, Touch, kept_size, sign, untouched

FAN, AXIAL = 0.7073, 0.9  # cosines of the greatest angle to an axis, between which the methods blend
FADED = 0.3  # share of the chord near its ends where the axial method counts less
SAMPLES = 300  # of the chord
LEAST_SHARE = 1.0e-3  # of radii that something goes round
ENTERED = 0.12  # see `kernels/path/wrap_ellipsoid.py`
PIECE = 0.001  # m, of the arc
NEARLY_ROUND = 6.0  # rad; an arc as long as that is one that has just begun the other way round


class Guide(NamedTuple):
    """What determines the plane of a path."""

    point: Floats  # (3,) on the ellipsoid
    fan: float  # how much the mean direction from the chord counts, 0..1
    beside: bool = False  # whether the method `axial` has found it by a place outside the ellipsoid


def ellipsoid_touch(
    a: Floats,
    b: Floats,
    full: Floats,
    axis: int,
    side: int,
    method: str,
    smooth: bool = False,
    as_opensim: bool = False,
) -> Touch:
    """How a segment from a to b, (3,) m, goes round an ellipsoid, which it only does where it would run through it.

    Args:
        full: radii. smooth: the ellipsoid shrinks as an end of the segment goes inside, and a path comes over to its
            side as the segment goes in. as_opensim: places are those of OpenSim's search, see `ellipsoid_tangent.py`.
        axis, side: the half of the ellipsoid that a path must stay on: the axis, and 1 or -1; 0: both halves.
    """
    share = kept_size(float(min(np.linalg.norm(a / full), np.linalg.norm(b / full)))) if smooth else 1.0
    if share < LEAST_SHARE:
        return untouched(INSIDE)
    radii = full * share
    scale = 3.0 / float(np.sum(radii))
    p, q, r = a * scale, b * scale, radii * scale
    if min(float(np.sum((p / r) ** 2)), float(np.sum((q / r) ** 2))) < 1.0 - 1e-4:
        return untouched(INSIDE)
    if abs(float(p @ q) / float(np.linalg.norm(p) * np.linalg.norm(q)) - 1.0) < 1e-4:
        return untouched()
    chord = _chord(p / r, q / r)
    if chord is None:
        return untouched()
    ends = [p + (q - p) * t for t in chord]
    guide = _guide(ends[0], ends[1] - ends[0], r, method)
    c = start = guide.point
    begins = ends if guide.beside else [start, start]  # of OpenSim's search
    if side != 0 and sign(c[axis]) != side:
        c = start = np.where(np.arange(3) == axis, -c, c)
        if guide.fan > 0.0:
            c = nearest(np.where(np.arange(3) == axis, c * (1.0 - guide.fan), c), r)
        if smooth:
            over = min(_depth(p / r, q / r) / ENTERED, 1.0)
            c = start = nearest(guide.point + (c - guide.point) * over, r)
        begins = [start, start]
    normal = np.cross(p - q, p - c)
    normal = normal / max(float(np.linalg.norm(normal)), 1e-300)
    first, second = _tangents(p / r, q / r, c / r, start / r)
    first, second = first * r, second * r
    if as_opensim:
        reached, left = (tangent_of(end, begin, r, normal, c) for end, begin in zip((p, q), begins, strict=True))
        first, second = first if reached is None else reached, second if left is None else left
        return _touch_as_opensim(p, q, first, second, c, normal, r, scale, side)
    return _touch(p, first, second, c, normal, r, scale, side)


def _touch(
    p: Floats, first: Floats, second: Floats, c: Floats, normal: Floats, r: Floats, scale: float, side: int
) -> Touch:
    """The touch with these tangent points, all in scaled numbers; its arc is measured in pieces, as OpenSim does it."""
    chord = float(np.linalg.norm(second - first)) / scale
    if chord < PIECE:
        return Touch(THROUGH, first / scale, second / scale, chord)
    pieces = min(int(chord / PIECE), 499)
    points = _arc(first, second, c, normal, r, pieces, side != 0 and _goes_far(p / r, first / r, second / r, c / r))
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    return Touch(THROUGH, first / scale, second / scale, length / scale)


def _touch_as_opensim(
    p: Floats, q: Floats, first: Floats, second: Floats, c: Floats, normal: Floats, r: Floats, scale: float, side: int
) -> Touch:
    """The same where the arc is the long way round if its first or last piece leads back to an end."""
    chord = float(np.linalg.norm(second - first)) / scale
    if chord < PIECE:
        return Touch(THROUGH, first / scale, second / scale, chord)
    pieces = min(int(chord / PIECE), 499)
    points = _arc(first, second, c, normal, r, pieces, False)
    back = float((points[1] - first) @ (p - first)) > 0.0 or float((points[-2] - second) @ (q - second)) > 0.0
    if side != 0 and len(points) > 2 and back:
        points = _arc(first, second, c, normal, r, pieces, True)
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    return Touch(THROUGH, first / scale, second / scale, length / scale)


def _goes_far(p: Floats, first: Floats, second: Floats, c: Floats) -> bool:
    """Whether the arc that goes on from the first leg, on the unit sphere, is more than half of its circle.

    OpenSim asks pieces of its arc instead, and takes some short arcs for long ones so.
    """
    normal = np.cross(first - p, c - p)
    middle = normal * float(normal @ first) / max(float(normal @ normal), 1e-300)
    u, w = first - middle, second - middle
    v = np.cross(normal, u)
    if float(v @ (first - p)) < 0.0:
        v = -v
    angle = math.atan2(float(w @ v) * float(np.linalg.norm(u)), float(w @ u) * float(np.linalg.norm(v)))
    return angle < 0.0 and 2.0 * math.pi + angle < NEARLY_ROUND


def _chord(p: Floats, q: Floats) -> tuple[float, float] | None:
    """Where the way from p to q goes into and out of the unit sphere, shares of it; None if it does not."""
    d = q - p
    square, half, rest = float(d @ d), float(p @ d), float(p @ p) - 1.0
    under = half**2 - square * rest
    if under < 0.0:
        return None
    t = (-half - math.sqrt(under)) / square, (-half + math.sqrt(under)) / square
    return t if 0.0 < t[0] < t[1] < 1.0 else None  # one that only touches has no part within


def _depth(p: Floats, q: Floats) -> float:
    """How deep the way from p to q goes into the unit sphere: 1 less the square of its least distance."""
    d = q - p
    near = p - d * (float(p @ d) / float(d @ d))
    return 1.0 - float(near @ near)


def _guide(start: Floats, chord: Floats, r: Floats, method: str) -> Guide:
    """The point of the ellipsoid that a path's plane goes through, from the part of the segment within."""
    middle = start + 0.5 * chord
    slopes = np.abs(chord) / np.linalg.norm(chord)
    along = int(np.argmax(slopes))
    toward = float(slopes[along])
    if method == "midpoint":
        return Guide(nearest(middle, r), 0.0)
    t = -start[along] / chord[along]
    crossing = np.where(np.arange(3) == along, 0.0, start + t * chord)
    axial = _nearest_in_plane(crossing, r, along)
    if method == "axial":
        return Guide(axial, 0.0, not 0.0 < t < 1.0)
    if toward > FAN:
        share = min(max(min(t, 1.0 - t) / FADED, 0.0), 1.0)
        toward = FAN + share * (toward - FAN)
    if toward >= AXIAL:
        return Guide(axial, 0.0)
    samples = [start + chord * (k / SAMPLES) for k in range(1, SAMPLES - 1)]
    blades = np.array([nearest(sample, r) - sample for sample in samples])
    total = np.sum(blades / np.maximum(np.linalg.norm(blades, axis=1), 1e-300)[:, None], axis=0)
    fan = nearest(middle + total / max(float(np.linalg.norm(total)), 1e-300), r)
    if toward <= FAN:
        return Guide(fan, 1.0)
    share = (toward - FAN) / (AXIAL - FAN)
    return Guide(nearest(share * axial + (1.0 - share) * fan, r), 1.0 - share)


def nearest(point: Floats, r: Floats) -> Floats:
    """The point (3,), m, of an ellipsoid of radii r (3,) that is nearest to another one, in the ellipsoid's axes."""
    flat = np.flatnonzero(np.abs(point) <= 2e-13)
    if len(flat):  # within the narrowest of the sections that it is in
        return _nearest_in_plane(point, r, int(max(flat, key=lambda k: float(r[k]))))
    return _nearest_off_planes(point, r)


def _nearest_off_planes(point: Floats, r: Floats) -> Floats:
    """The same of an ellipse or ellipsoid, for a point on none of its planes of symmetry."""
    t = float(np.max(-(r**2) + r * np.abs(point)))
    for _ in range(100):  # Newton's method on a convex function, from its left
        x = r * point / (t + r**2)
        step = float(x @ x - 1.0) / float(2.0 * np.sum(x**2 / (t + r**2)))
        t += step
        if abs(step) <= 1e-14 * (1.0 + abs(t)):
            break
    return np.asarray(r**2 * point / (t + r**2))


def _nearest_in_plane(point: Floats, r: Floats, across: int) -> Floats:
    """The same of the ellipse in which the plane across an axis meets the ellipsoid."""
    found = np.zeros(3)
    first, second = ((across + 1) % 3, (across + 2) % 3)
    u, v, a, b = point[first], point[second], r[first], r[second]
    on_first, on_second = abs(u) <= 2e-13, abs(v) <= 2e-13
    if on_first and on_second:
        found[[first, second]] = (a, 0.0) if a < b else (0.0, b)
    elif on_first and not (a >= b or abs(v) >= b - a**2 / b):
        y = b**2 * v / (b**2 - a**2)
        found[[first, second]] = a * math.sqrt(abs(1.0 - (y / b) ** 2)), y
    elif on_second and not (b >= a or abs(u) >= a - b**2 / a):
        x = a**2 * u / (a**2 - b**2)
        found[[first, second]] = x, b * math.sqrt(abs(1.0 - (x / a) ** 2))
    else:
        found[[first, second]] = _nearest_off_planes(np.array([u, v]), np.array([a, b]))
    return found


def _tangents(p: Floats, q: Floats, c: Floats, start: Floats) -> tuple[Floats, Floats]:
    """Where tangents from p and q in the plane through c touch the unit sphere, on the side of `start`."""
    normal = np.cross(p - q, p - c)
    normal = normal / max(float(np.linalg.norm(normal)), 1e-300)
    middle = normal * float(normal @ c)
    square = 1.0 - float(middle @ middle)
    outward = np.cross(normal, q - p)
    if float(outward @ (start - p)) < 0.0:
        outward = -outward
    found = []
    for end in (p, q):
        v = end - middle
        far = float(v @ v)
        across = np.cross(normal, v) * math.sqrt(max(square * (far - square), 0.0)) / far
        touching = [middle + v * (square / far) + across, middle + v * (square / far) - across]
        found.append(max(touching, key=lambda x: float(x @ outward)) if far > square else end)
    return found[0], found[1]


def _arc(first: Floats, second: Floats, c: Floats, normal: Floats, r: Floats, pieces: int, far: bool) -> Floats:
    """Points of the arc, by equal angles about where the axis that is most across the plane meets it, (n, 3)."""
    across = int(np.argmax(np.abs(normal)))
    center = np.where(np.arange(3) == across, float(normal @ c) / normal[across], 0.0)
    u, v = (x / max(float(np.linalg.norm(x)), 1e-300) for x in (first - center, second - center))
    angle = math.acos(min(max(float(u @ v), -1.0), 1.0))
    w = np.cross(np.cross(u, v), u)
    w = w / max(float(np.linalg.norm(w)), 1e-300)
    turn = (angle - 2.0 * math.pi if far else angle) * np.arange(1, pieces) / pieces
    ways = np.cos(turn)[:, None] * u + np.sin(turn)[:, None] * w
    square, half, rest = (
        (ways / r**2 * ways).sum(1),
        (ways / r**2 * center).sum(1),
        float(np.sum((center / r) ** 2)) - 1.0,
    )
    reach = (-half + np.sqrt(np.maximum(half**2 - square * rest, 0.0))) / square
    return np.array([first, *(center + ways * reach[:, None]), second])
