"""Segments of a path round a sphere, as OpenSim 4.6 takes them (WrapSphere): along a great circle."""

from __future__ import annotations

import math

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene.wrapping.touch import BESIDE, INSIDE, THROUGH, Touch, kept_size, sign, untouched

STRAIGHT = 1e-5  # sine of the angle below which both ends lie opposite each other
REACH = 1.0  # m, from the first end to the middle of the sphere; OpenSim takes no segment beyond it as running through


def sphere_touch(a: Floats, b: Floats, full: float, axis: int, side: int, smooth: bool = False) -> Touch:
    """How a segment from a to b, (3,) m, goes round a sphere.

    Args:
        full: radius. axis, side: the half of the sphere that a path must stay on: the axis, and 1 or -1; 0: both
            halves. Only where the straight segment would run through the sphere does the path touch it.
        smooth: the sphere shrinks as an end of the segment goes inside.
    """
    da, db, d = np.linalg.norm(a), np.linalg.norm(b), b - a
    radius = full * kept_size(float(min(da, db)) / full) if smooth else full
    if radius == 0.0 or da < radius or db < radius:
        return untouched(INSIDE)
    square = float(d @ d)
    t = -float(a @ d) / square if square > 0.0 else 0.0
    near = a + t * d
    depth = radius**2 - float(near @ near)
    if depth < 0.0 or abs(t - 0.5) + math.sqrt(depth / square) >= 0.5:
        return untouched()
    normal = np.cross(a / da, b / db)
    size = float(np.linalg.norm(normal))
    if size < STRAIGHT:
        normal = _perpendicular(a)
        size = float(np.linalg.norm(normal))
    ways = _tangents(a / da, float(da), normal / size, radius), _tangents(b / db, float(db), normal / size, radius)
    first, second = max(((p, q) for p in ways[0] for q in ways[1]), key=lambda pair: float(pair[0] @ pair[1]))
    kind, far = BESIDE, False
    if side != 0:
        on = sign(a[axis]) == side, sign(b[axis]) == side
        if any(on):
            if 0.0 < t * math.sqrt(square) < REACH:
                kind = THROUGH
            elif on[0] == on[1] or sign(near[axis]) == side:
                return untouched()
        if not all(on):
            first, second = _on_side(ways, a, b, axis, side)
            far = float((first + second) @ (first - a + second - b)) < 0.0
    angle = math.acos(min(max(float(first @ second) / radius**2, -1.0), 1.0))
    return Touch(kind, first, second, radius * (2.0 * math.pi - angle if far else angle))


def _perpendicular(a: Floats) -> Floats:
    """Some direction at right angles to another one."""
    other = np.zeros(3)
    other[int(np.argmin(np.abs(a)))] = 1.0
    return np.asarray(np.cross(a, other))


def _tangents(v: Floats, distance: float, normal: Floats, radius: float) -> tuple[Floats, Floats]:
    """Where tangents from a point in direction v touch, (3,) m, in the plane of a normal."""
    along, across = radius**2 / distance, radius * math.sqrt(max(1.0 - (radius / distance) ** 2, 0.0))
    u = np.cross(normal, v)
    return along * v + across * u, along * v - across * u


def _on_side(
    ways: tuple[tuple[Floats, Floats], tuple[Floats, Floats]], a: Floats, b: Floats, axis: int, side: int
) -> tuple[Floats, Floats]:
    """The tangent points that lead to the side."""
    middle = -(a + b)
    chosen = [int(float(p @ middle) <= float(q @ middle)) for p, q in ways]
    first, second = (way[k] for way, k in zip(ways, chosen, strict=True))
    if (first[axis] - a[axis] + second[axis] - b[axis]) * side < 0.0:
        return ways[0][1 - chosen[0]], ways[1][1 - chosen[1]]
    return first, second
