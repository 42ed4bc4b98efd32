"""Values over time as they are at other moments."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats


def at_moments(time: Floats, values: NDArray[Any], moments: Floats) -> Floats:
    """Values (F, ...) at times (F,), in order, as they are at moments (...): linearly between, constant beyond.

    Returns:
        An array of the shape of the moments, and then of one value.
    """
    clock = np.asarray(time, dtype=float)
    after = np.clip(np.searchsorted(clock, moments), 1, len(clock) - 1)
    part = np.clip((moments - clock[after - 1]) / (clock[after] - clock[after - 1]), 0.0, 1.0)
    part = part.reshape(part.shape + (1,) * (values.ndim - 1))
    return np.asarray((1.0 - part) * values[after - 1] + part * values[after])
