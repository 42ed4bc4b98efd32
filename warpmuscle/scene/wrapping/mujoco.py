"""Segments of a path round cylinders and spheres as MuJoCo takes them, in float64; see `kernels.path.wrap_mujoco`."""

from __future__ import annotations

import math

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene.wrapping.touch import THROUGH, Touch, untouched

NEAR = 1.0e-9  # m^2, squared distances that are none
PARALLEL = 1.0e-9  # sine of the angle between both ends, as seen from the middle of a sphere
HALVINGS = 50  # of the arc on which a path inside touches

Flat = tuple[Floats, Floats, float]  # where the path reaches and leaves a circle, m, and the arc between them, m


def mujoco_touch(a: Floats, b: Floats, radius: float, side: Floats | None, round_sphere: bool) -> Touch:
    """How a segment from a to b, (3,) m in a surface's axes, goes round it: a sphere, or a cylinder about z.

    Args:
        side: a point, (3,) m, on the side of which the path stays; one within the radius asks for a path inside.
    """
    x, y = np.eye(3)[0], np.eye(3)[1]
    if round_sphere:
        x = a / np.linalg.norm(a)
        normal = np.cross(x, b / np.linalg.norm(b))
        if float(np.linalg.norm(normal)) < PARALLEL:
            normal = np.cross(x, np.eye(3)[int(np.argmin(np.abs(x)))])
        y = np.cross(normal / np.linalg.norm(normal), x)
    plane = np.stack([x, y])
    if side is not None and float(np.linalg.norm(side)) < radius:
        flat = _inside(plane @ a, plane @ b, radius)
    else:
        flat = _outside(plane @ a, plane @ b, radius, None if side is None else plane @ side)
    if flat is None:
        return untouched()
    first, second, arc = flat
    if round_sphere:
        return Touch(THROUGH, plane.T @ first, plane.T @ second, arc)
    before, after = float(np.linalg.norm(first - a[:2])), float(np.linalg.norm(second - b[:2]))
    slope = float(b[2] - a[2]) / (before + arc + after)
    heights = float(a[2]) + before * slope, float(b[2]) - after * slope
    return Touch(THROUGH, np.append(first, heights[0]), np.append(second, heights[1]), math.hypot(arc, slope * arc))


def _nearest(a: Floats, b: Floats) -> Floats:
    """The point of a segment that is nearest to the origin."""
    d = b - a
    return np.asarray(a + d * min(max(-float(a @ d) / max(float(d @ d), NEAR), 0.0), 1.0))


def _outside(a: Floats, b: Floats, radius: float, side: Floats | None) -> Flat | None:
    """Round a circle where the segment runs through it, or where it is on the far side of the side point."""
    if min(float(a @ a), float(b @ b)) < radius**2 or float((b - a) @ (b - a)) < NEAR:
        return None
    near = _nearest(a, b)
    far = side is not None and _passes_behind(a, b, side)
    if float(near @ near) > radius**2 and not far:
        return None
    way = -1.0 if (_cross(a, b) < 0.0) != far else 1.0
    first, second = _tangent(a, radius, way), _tangent(b, radius, -way)
    turn = way * math.atan2(_cross(first, second), float(first @ second))
    return first, second, radius * (turn + 2.0 * math.pi if turn < 0.0 else turn)


def _passes_behind(a: Floats, b: Floats, side: Floats) -> bool:
    """Whether a segment crosses the ray from the origin that leads away from a side point."""
    of_a, of_b = _cross(a, side), _cross(b, side)
    if of_a * of_b >= 0.0:
        return False
    return float((a + (b - a) * of_a / (of_a - of_b)) @ side) < 0.0


def _tangent(p: Floats, radius: float, way: float) -> Floats:
    """Where the tangent from a point outside touches the circle; way 1: on counter-clockwise, -1: back."""
    square = float(p @ p)
    leg = way * math.sqrt(max(square - radius**2, 0.0))
    return np.array([radius * p[0] - leg * p[1], leg * p[0] + radius * p[1]]) * radius / square


def _inside(a: Floats, b: Floats, radius: float) -> Flat | None:
    """Over the point of the circle that makes the path shortest, unless the segment comes inside by itself."""
    far = float(np.linalg.norm(a)), float(np.linalg.norm(b))
    if min(float(np.linalg.norm(_nearest(a, b))), *far) <= radius:
        return None
    angle = math.atan2(abs(_cross(a, b)), float(a @ b))
    low, high = 0.0, angle
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        rates = (_rate(far[0], radius, middle), _rate(far[1], radius, angle - middle))
        low, high = (middle, high) if rates[0] < rates[1] else (low, middle)
    turn = -low if _cross(a, b) < 0.0 else low
    cosine, sine = math.cos(turn), math.sin(turn)
    place = np.array([[cosine, -sine], [sine, cosine]]) @ a * (radius / far[0])
    return place, place, 0.0


def _rate(far: float, radius: float, angle: float) -> float:
    """Rate by an angle of the distance from a point, so far from the middle, to one on the circle, m/rad."""
    distance = math.sqrt(far**2 + radius**2 - 2.0 * far * radius * math.cos(angle))
    return far * radius * math.sin(angle) / max(distance, math.sqrt(NEAR))


def _cross(a: Floats, b: Floats) -> float:
    return float(a[0] * b[1] - a[1] * b[0])
