"""Vertebrae with their processes along a line; numbers only. Lengths and axes as in `skeleton`."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import normalized
from warpmuscle.view.bones.directions import ASIDE, perpendicular
from warpmuscle.view.bones.meshes import merged, tube
from warpmuscle.view.hulls import Mesh

VERTEBRA = 0.031  # m, from the middle of one to that of the next
BODY, DISC = 0.0205, 0.0168  # m, their radii


def vertebrae(line: Floats, scale: float, thin: float = 1.0) -> Mesh:
    """Vertebrae along points (N, 3) from the lowest to the highest, whose radius is multiplied by `thin`."""
    s = scale
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    count = max(round(float(way[-1]) / (VERTEBRA * s * (0.5 + 0.5 * thin))), 1)
    at = np.linspace(0.0, way[-1], 4 * count + 1)
    points = np.stack([np.interp(at, way, line[:, k]) for k in range(3)], axis=1)
    form = np.tile([DISC, BODY, 0.88 * BODY, BODY], count + 1)[: 4 * count + 1]
    parts = [tube(points, thin * s * form, 8)]
    along = normalized(np.gradient(points, axis=0))
    for k in range(2, 4 * count + 1, 4):
        up, middle, t = along[k], points[k], thin * s
        aside = perpendicular(up, ASIDE)
        back = np.cross(up, aside)
        back = back if back[2] < 0.0 else -back
        arch, end = middle + 0.012 * t * back, middle + t * (0.043 * back - 0.022 * up)
        parts.append(tube([arch, end], t * np.array([0.0115, 0.006]), 5))
        tips = [arch + sign * 0.034 * t * aside + 0.006 * t * back for sign in (-1.0, 1.0)]
        parts.append(tube([tips[0], arch, tips[1]], t * np.array([0.005, 0.0105, 0.005]), 5))
    return merged(parts)
