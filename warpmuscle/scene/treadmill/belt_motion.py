"""How fast the belts of a treadmill are over time, and how far they have gone."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number
from warpmuscle.scene import Ground
from warpmuscle.scene.ground import plane
from warpmuscle.scene.treadmill.part import Treadmill

BELTS = "ground.treadmill.left", "ground.treadmill.right"  # what recordings call their speeds, m/s, backwards
MEASURED_BELT = "ground.velocity.x", "ground.velocity.z"  # m/s, world: of the belt below a measured motion


def knots_of(treadmill: Treadmill) -> Floats:
    """Times, s, and factors (K, 2) of the profile; a factor of 1 where there is none."""
    return np.array(treadmill.profile or [(0.0, 1.0)], dtype=float)


def share(treadmill: Treadmill, time: ArrayLike) -> Floats:
    """What speeds are multiplied by at times, s."""
    knots = knots_of(treadmill)
    return np.interp(np.asarray(time, dtype=float) - first_number(treadmill.start), knots[:, 0], knots[:, 1])


def gone(treadmill: Treadmill, time: ArrayLike) -> Floats:
    """The integral of `share` from 0 to times, s."""
    knots, start = knots_of(treadmill), first_number(treadmill.start)
    asked = np.asarray(time, dtype=float)
    corners = np.concatenate([np.ravel(asked), [0.0], knots[:, 0] + start])
    times = np.unique(corners)
    values = share(treadmill, times)
    parts = 0.5 * (values[1:] + values[:-1]) * np.diff(times)
    summed = np.concatenate([[0.0], np.cumsum(parts)])
    return np.asarray(np.interp(asked, times, summed) - np.interp(0.0, times, summed))


def belt_speeds(treadmill: Treadmill) -> tuple[float, float]:
    """Speeds of the left and the right belt, m/s, backwards, before the profile."""
    both = first_number(treadmill.speed)
    return both + first_number(treadmill.left), both + first_number(treadmill.right)


def mean_shift(ground: Ground, time: ArrayLike) -> Floats:
    """How far the belts have moved (..., 3) in their mean from time 0 to times, m, world; 0 where there are none."""
    treadmill = ground.treadmill
    if treadmill is None:
        return np.zeros((*np.shape(time), 3))
    normal = plane(ground).normal
    across = np.array([normal[1], -normal[0], 0.0])
    across /= np.linalg.norm(across)
    velocity = across * first_number(treadmill.sideways) - np.cross(across, normal) * np.mean(belt_speeds(treadmill))
    return np.asarray(gone(treadmill, time)[..., None] * velocity)
