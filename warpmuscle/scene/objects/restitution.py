"""How a spring and a damper bounce that do not pull."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats

GREATEST = 2.0  # damping ratio; with more, what was pressed in would come back too slowly to rest
_RATIOS = np.concatenate([[0.0], np.geomspace(1e-5, GREATEST, 4000)])


def restitution_of(ratio: ArrayLike) -> Floats:
    """Speed after an impact over that before, by the damping ratio c/(2 sqrt(k m)) of spring and damper.

    Schwager and Poeschel 2007, Granular Matter 9:465, eq. 21: the contact ends where the force is gone, not the depth.
    """
    zeta = np.abs(np.asarray(ratio, dtype=float))
    under = np.minimum(zeta, 1.0 - 1e-9)
    root = np.sqrt(1.0 - under**2)
    end = np.arctan2(2.0 * under * root, 2.0 * under**2 - 1.0)  # phase at which the force is gone
    over = np.maximum(zeta, 1.0 + 1e-9)
    other = np.sqrt(over**2 - 1.0)
    slow = (over / other) * np.log((over + other) / (over - other))
    return np.asarray(np.where(zeta < 1.0, np.exp(-under / root * end), np.exp(-slow)))


def damping_ratio(restitution: ArrayLike) -> Floats:
    """The damping ratio that has a restitution from 0 to 1; that of 0.05, the greatest, below it."""
    table = restitution_of(_RATIOS)
    return np.asarray(np.interp(-np.asarray(restitution, dtype=float), -table, _RATIOS))
