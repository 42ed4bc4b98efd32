"""Routes of muscles as polylines with a constant number of points, over the surfaces that they wrap around."""

from __future__ import annotations

import math

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import from_rotation_vector, multiply, rotate
from warpmuscle.scene import Character, CylinderSurface, EllipsoidSurface, Muscle, SphereSurface, Surface
from warpmuscle.scene.initial_pose import plain_number, plain_vector
from warpmuscle.scene.wrapping.route import Angles, Poses, route_stops

ARC = 10  # pieces of the way over a surface


def drawn_count(muscle: Muscle) -> int:
    """Number of points of a route that is drawn."""
    return len(muscle.path) + (ARC + 1) * len(muscle.wraps)


def drawn_route(character: Character, muscle: Muscle, poses: Poses, angles: Angles) -> Floats:
    """Points (`drawn_count`, 3) of a muscle in a pose, m, world; the last one again where it has fewer.

    Args:
        character: checked, without free parameters. poses, angles: see `route.route_stops`.
    """
    points: list[Floats] = []
    stops = route_stops(character, muscle, poses, angles)
    for before, stop in zip([None, *stops[:-1]], stops, strict=True):
        if before is not None and stop.wrap >= 0 and before.wrap == stop.wrap:
            surface = character.surfaces[muscle.wraps[stop.wrap].surface]
            points += list(_arc(surface, before.place, stop.place, stop.length, poses))
        else:
            points.append(stop.place)
    points += [points[-1]] * (drawn_count(muscle) - len(points))
    return np.array(points)


def surface_pose(surface: Surface, poses: Poses) -> tuple[Floats, Floats]:
    """Centre (3,), m, and orientation (4,) of a surface in a pose, world."""
    position, turn = poses[surface.body]
    own = from_rotation_vector(plain_vector(surface.orientation))
    return position + rotate(turn, plain_vector(surface.position)), multiply(turn, own)


def _arc(surface: Surface, start: Floats, end: Floats, length: float, poses: Poses) -> Floats:
    """Points behind a place where a path reaches a surface, up to that where it leaves it, (ARC, 3)."""
    center, turn = surface_pose(surface, poses)
    axes = rotate(turn, np.eye(3))  # rows: the surface's axes
    a, b = axes @ (start - center), axes @ (end - center)
    part = np.arange(1, ARC + 1)[:, None] / ARC
    return np.asarray(center + over(surface, a, b, length, part) @ axes)


def over(surface: Surface, a: Floats, b: Floats, length: float, part: Floats) -> Floats:
    """Places (n, 3) of a way over a surface from a to b, in its axes, m, of that length, at parts (n, 1) of it."""
    straight = a + (b - a) * part
    if isinstance(surface, CylinderSurface):
        radius, rise = plain_number(surface.radius), b[2] - a[2]
        flat = [np.array([p[0], p[1], 0.0]) for p in (a, b)]
        angle = math.sqrt(max(length**2 - rise**2, 0.0)) / radius
        turned = _turned(flat[0], flat[1], np.array([0.0, 0.0, 1.0]), angle, part)
        return np.asarray(np.column_stack([turned[:, :2], straight[:, 2]]))
    if isinstance(surface, SphereSurface):
        normal = np.cross(a, b)
        size = float(np.linalg.norm(normal))
        if size < 1e-12:
            return straight
        return _turned(a, b, normal / size, length / plain_number(surface.radius), part)
    if isinstance(surface, EllipsoidSurface):  # along rays from its middle
        radii = plain_vector(surface.radii)
        return np.asarray(straight / np.maximum(np.linalg.norm(straight / radii, axis=1, keepdims=True), 1e-9))
    return straight


def _turned(a: Floats, b: Floats, axis: Floats, angle: float, part: Floats) -> Floats:
    """Places (n, 3) on a circle from a to b about an axis, at parts of the way that is about so long, rad."""
    across = np.cross(axis, a)
    short = math.atan2(float(across @ b), float(a @ b))  # -pi..pi
    long = short - math.copysign(2.0 * math.pi, short)
    way = short if abs(abs(short) - angle) <= abs(abs(long) - angle) else long
    return np.asarray(a * np.cos(way * part) + across * np.sin(way * part))
