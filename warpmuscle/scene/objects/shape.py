"""Size and inertia of objects whose numbers are floats, or arrays with one value an instance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import rows
from warpmuscle.scene.objects.part import AnyObject, BallObject, BoxObject

ROUNDING = 0.02  # m, of edges of boxes, for bodies that touch them


class Rounded(NamedTuple):
    """A box about which a sphere is swept."""

    half: Floats  # (rows, 3) m, half edges
    radius: Floats  # (rows,) m, of the sphere


def rounded(solid: AnyObject) -> Rounded:
    """The shape of an object."""
    if isinstance(solid, BoxObject):
        half = 0.5 * rows(list(solid.size))
        return Rounded(half, np.zeros(len(half)))
    if isinstance(solid, BallObject):
        radius = rows(solid.radius)
        return Rounded(np.zeros((len(radius), 3)), radius)
    length = rows([solid.length])
    return Rounded(0.5 * length * np.array([0.0, 1.0, 0.0]), rows(solid.radius))


def inertia(solid: AnyObject) -> Floats:
    """Principal moments of inertia about its middle (rows, 3), kg m^2, of a solid of even density."""
    mass = rows(solid.mass)[:, None]
    half, radius = rounded(solid)
    r = radius[:, None]
    if isinstance(solid, BoxObject):
        square = half**2
        return np.asarray(mass / 3.0 * (square.sum(axis=1, keepdims=True) - square))
    if isinstance(solid, BallObject):
        return np.asarray(0.4 * mass * r**2 * np.ones(3))
    length = 2.0 * half[:, 1:2]
    ball_share = 4.0 * r / (4.0 * r + 3.0 * length)  # volumes: 4/3 pi r^3 of the ends, pi r^2 l of the cylinder
    ends, bar = mass * ball_share, mass * (1.0 - ball_share)
    along = 0.4 * ends * r**2 + 0.5 * bar * r**2
    across = bar * (length**2 / 12.0 + r**2 / 4.0) + ends * (0.4 * r**2 + 0.25 * length**2 + 0.375 * length * r)
    return np.concatenate(np.broadcast_arrays(across, along, across), axis=1)
