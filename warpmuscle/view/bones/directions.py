"""Directions of bones: across an axis, as near as may be to where a person's points."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats

ASIDE, DOWN, AHEAD = np.array([1.0, 0.0, 0.0]), np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, 1.0])
ACROSS = 0.2  # sine of the least angle between an axis and what a direction across it is taken from


def unit(vector: Floats) -> Floats:
    """A vector of length 1."""
    return np.asarray(vector / max(float(np.linalg.norm(vector)), 1e-9))


def perpendicular(axis: Floats, wanted: Floats) -> Floats:
    """The direction across an axis that is nearest to a wanted one, or some other where the axis points that way."""
    across = wanted - np.dot(wanted, axis) * axis
    if np.linalg.norm(across) <= ACROSS:
        across = np.cross(axis, AHEAD)
    if np.linalg.norm(across) <= ACROSS:
        across = DOWN - np.dot(DOWN, axis) * axis
    return unit(across)


def turned(axis: Floats, aside: Floats) -> Floats:
    """Axes (3, 3), as columns, of which y is along a bone and x aside."""
    return np.stack([aside, axis, np.cross(aside, axis)], axis=1)
