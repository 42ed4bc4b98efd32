"""Where a search is to begin: in directions that move what is judged alike."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats


def directions(slopes: Floats, deviation: float, moved: float) -> Floats:
    """Changes (U, U), a row each, that deviate by so much at most and together move what they change by so much.

    They are the root of a covariance: the inverse of 1 / deviation^2 + U J J^T / moved^2.

    Args:
        slopes: (U, R) J, derivatives by the changes, so scaled that the sum of squares of R is a mean square.
    """
    count = len(slopes)
    stiff, axes = np.linalg.eigh(count / moved**2 * slopes @ slopes.T + np.eye(count) / deviation**2)
    return np.asarray((axes * stiff**-0.5) @ axes.T)
