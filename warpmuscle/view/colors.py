"""Colours of replays, told apart with any kind of colour vision."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats

Bytes = NDArray[np.uint8]

TINTS = {"left": (140, 184, 219), "right": (237, 186, 148), "middle": (199, 204, 212)}  # of shapes
LINES = {"left": "#0072b2", "right": "#d55e00", "middle": "#404040"}  # of curves (Okabe and Ito)
BONE, DESIRED, COM, PUSH = (240, 237, 224), (64, 158, 128), (0, 158, 115), (230, 159, 0)
FORCES = ((0, 97, 158), (194, 79, 0))  # on the left and the right foot
_PLASMA = np.array([(13, 8, 135), (126, 3, 168), (204, 71, 120), (248, 149, 64), (240, 249, 33)], dtype=np.float64)


def of_activation(activation: Floats) -> Bytes:
    """Colours (..., 3) of activations (...), from dark blue at 0 over magenta to yellow at 1."""
    place = np.clip(np.asarray(activation, dtype=np.float64), 0.0, 1.0) * (len(_PLASMA) - 1)
    low = np.minimum(place.astype(int), len(_PLASMA) - 2)
    part = (place - low)[..., None]
    return np.asarray(np.rint((1.0 - part) * _PLASMA[low] + part * _PLASMA[low + 1]), dtype=np.uint8)
