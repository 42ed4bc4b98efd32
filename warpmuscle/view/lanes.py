"""Where several bipeds walk, so that all are seen."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats

ACROSS = 8  # beside each other at most, unless there are more than 64
MOST = 64  # bipeds that can be told apart
BESIDE, BEHIND = 1.3, 2.0  # m, between neighbours


def lanes(count: int) -> Floats:
    """Offsets (count, 3), m, of each biped: from left to right, row behind row, about the middle of the first row."""
    columns = min(count, max(ACROSS, int(np.ceil(np.sqrt(count)))))
    number = np.arange(count)
    x = ((columns - 1) / 2.0 - number % columns) * BESIDE
    return np.stack([x, np.zeros(count), -BEHIND * (number // columns)], axis=1)
