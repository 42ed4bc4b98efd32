"""Wraps that never touch their surface, since an end of each segment is fixed inside of it.

OpenSim lets a segment with an end inside run straight. Where paths slip off surfaces smoothly, a surface shrinks as an
end comes in; one that is always inside would let the path touch what is left of it.
"""

from __future__ import annotations

import itertools

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import rotate
from warpmuscle.scene import (
    Character,
    CylinderSurface,
    EllipsoidSurface,
    Muscle,
    SphereSurface,
    Surface,
    ViaPoint,
    Wrap,
)


def drop_idle_wraps(character: Character) -> dict[str, list[str]]:
    """Take such wraps out of the paths of a scene without free parameters; the surfaces by muscle."""
    dropped: dict[str, list[str]] = {}
    for name, muscle in character.muscles.items():
        idle = [wrap for wrap in muscle.wraps if is_idle(wrap, muscle, character)]
        if idle:
            dropped[name] = [wrap.surface for wrap in idle]
            muscle.wraps = [wrap for wrap in muscle.wraps if wrap not in idle]
    return dropped


def is_idle(wrap: Wrap, muscle: Muscle, character: Character) -> bool:
    """Whether one end of each segment that a surface may take round is fixed inside of the surface."""
    surface = character.surfaces[wrap.surface]
    points = muscle.path[(wrap.first or 1) - 1 : wrap.last or len(muscle.path)]
    inside = [_is_fixed_inside(point, surface) for point in points]
    return len(points) > 1 and all(a or b for a, b in itertools.pairwise(inside))


def _is_fixed_inside(point: ViaPoint, surface: Surface) -> bool:
    if point.body != surface.body or point.condition is not None or point.motion:
        return False
    turn = np.array(surface.orientation, dtype=float)
    angle = float(np.linalg.norm(turn))
    axis = turn / angle if angle > 0.0 else np.array([1.0, 0.0, 0.0])
    back = np.array([*(-np.sin(0.5 * angle) * axis), np.cos(0.5 * angle)])
    apart = np.array(point.position, dtype=float) - np.array(surface.position, dtype=float)
    return is_inside(np.asarray(rotate(back, apart)), surface)


def is_inside(place: Floats, surface: Surface) -> bool:
    """Whether a place, (3,) m in a surface's own axes, is inside of it; never of a ring."""
    match surface:
        case SphereSurface():
            return bool(np.linalg.norm(place) < float(surface.radius))  # type: ignore[arg-type]
        case CylinderSurface():
            return bool(np.hypot(place[0], place[1]) < float(surface.radius))  # type: ignore[arg-type]
        case EllipsoidSurface():
            return bool(np.linalg.norm(place / np.array(surface.radii, dtype=float)) < 1.0)
    return False
