"""Where a segment of a path touches a surface."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats

FREE, INSIDE, BESIDE, THROUGH = 0, 1, 2, 3  # what a segment does: see `Touch`


class Touch(NamedTuple):
    """How a segment from a to b goes round a surface, in the surface's axes.

    `FREE`: it does not touch it; `INSIDE`: one of its ends is inside, and so it runs straight; `BESIDE`: the surface
    takes it to its own side; `THROUGH`: straight, it would run through the surface.
    """

    kind: int
    first: Floats  # (3,) m, where the path reaches the surface
    second: Floats  # (3,) m, and where it leaves it
    length: float  # m, on the surface between them


def untouched(kind: int = FREE) -> Touch:
    """The touch of a segment that runs straight."""
    return Touch(kind, np.zeros(3), np.zeros(3), 0.0)


def sign(x: float) -> int:
    """1 or -1; that of 0 is 1."""
    return 1 if x >= 0.0 else -1


GIVES = 4.0  # see `kernels/path/wrap_touch.py`


def kept_size(near: float) -> float:
    """Share of its size that a smooth surface keeps with the end of a segment at so much of it from its middle."""
    return min(max(1.0 - GIVES * (1.0 - near), 0.0), 1.0)
