"""Ways into the unit cube: a smooth map of all space onto it, and points scattered around one of its points."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats

MARGIN = 0.05  # of the edge, at either end, where the map bends
LARGEST_DEVIATION = 1.0 / 3.0  # of a coordinate: wider than that, candidates only fold back from the faces
_WIDTH = 1.0 + 2.0 * MARGIN  # of the interval that the map takes onto [0, 1] one to one


def into_cube(points: Floats) -> Floats:
    """Map points (..., P) of all space onto the unit cube, each coordinate alone.

    The identity over [0.05, 0.95], quadratic where it bends towards a face, which it reaches at -0.05 or 1.05, and
    mirrored there again and again: continuously differentiable, so that a search sees no kink at a face. This is
    `BoxConstraintsLinQuadTransformation` of the `cma` package, for all points at once.
    """
    mapped = np.array(points, dtype=np.float64)
    beyond = (mapped < -MARGIN) | (mapped > 1.0 + MARGIN)
    if beyond.any():
        turned = np.mod(mapped[beyond] + MARGIN, 2.0 * _WIDTH)
        mapped[beyond] = np.minimum(turned, 2.0 * _WIDTH - turned) - MARGIN
    low, high = mapped < MARGIN, mapped > 1.0 - MARGIN
    mapped[low] = (mapped[low] + MARGIN) ** 2 / (4.0 * MARGIN)
    mapped[high] = 1.0 - (1.0 + MARGIN - mapped[high]) ** 2 / (4.0 * MARGIN)
    return np.clip(mapped, 0.0, 1.0)


def out_of_cube(points: Floats) -> Floats:
    """The points next to the cube that `into_cube` maps to these points (..., P) of it."""
    mapped = np.array(points, dtype=np.float64)
    low, high = mapped < MARGIN, mapped > 1.0 - MARGIN
    mapped[low] = 2.0 * np.sqrt(MARGIN * mapped[low]) - MARGIN
    mapped[high] = 1.0 + MARGIN - 2.0 * np.sqrt(MARGIN * (1.0 - mapped[high]))
    return mapped


def scattered(center: Floats, sigma: float, generator: np.random.Generator) -> Floats:
    """A point of the cube, (P,), drawn from a normal distribution about a center (P,) and mirrored at the faces."""
    turned = np.mod(generator.normal(center, sigma), 2.0)
    return np.asarray(np.minimum(turned, 2.0 - turned))
