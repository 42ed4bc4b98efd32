"""The ground of a numeric scene as numbers."""

from __future__ import annotations

import numpy as np

from warpmuscle.pose import normalized
from warpmuscle.recording import Floats
from warpmuscle.scene import Ground


def plane(ground: Ground) -> tuple[Floats, float]:
    """The unit normal (3,) of a numeric scene's ground, and how far along it the ground lies from the origin, m."""
    return normalized(np.array(ground.normal, dtype=float)), float(np.asarray(ground.height).item())
