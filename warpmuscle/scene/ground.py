"""The ground of a numeric scene as numbers, and when a foot counts as standing on it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import normalized
from warpmuscle.scene import Ground

LOADED = 0.03  # of the body weight: a foot with more is on the ground
HELD = 0.02  # s, that a foot has to be loaded to have touched down
LIFTED = 0.2  # s, that it has to be unloaded to have left the ground; in shorter gaps it bounces or drags


class Plane(NamedTuple):
    """A plane in the world."""

    normal: Floats  # (3,) of length 1
    height: float  # m, from the origin along the normal

    def height_at(self, x: ArrayLike, z: ArrayLike) -> Floats:
        """Height y above or below places of the world, m."""
        rise = self.height - self.normal[0] * np.asarray(x) - self.normal[2] * np.asarray(z)
        return np.asarray(rise / self.normal[1])


def plane(ground: Ground) -> Plane:
    """The ground of a numeric scene."""
    return Plane(normalized(np.array(ground.normal, dtype=float)), float(np.asarray(ground.height).item()))
