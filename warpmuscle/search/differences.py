"""Gradients in the unit cube from differences."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats


def stencil(point: Floats, step: float) -> tuple[Floats, Floats]:
    """Points that tell the gradient at a point (P,): the point and two others for each coordinate.

    The two others lie a step to either side, or one and two steps inwards where a face is nearer than a step.

    Returns:
        The points (2 P + 1, P), and the offsets (P, 2) of the two others along their coordinate.
    """
    count = len(point)
    offsets = np.tile([step, -step], (count, 1))
    offsets[point + step > 1.0] = -step, -2.0 * step
    offsets[point - step < 0.0] = step, 2.0 * step
    points = np.tile(point, (2 * count + 1, 1))
    axes = np.arange(count)
    points[1 + axes, axes] += offsets[:, 0]
    points[1 + count + axes, axes] += offsets[:, 1]
    exact = np.stack([points[1 + axes, axes], points[1 + count + axes, axes]], axis=1) - point[:, np.newaxis]
    return points, exact


def gradient(values: Floats, offsets: Floats) -> Floats:
    """Gradient (P,) from the values (2 P + 1,) at a stencil's points: of the parabola through each three."""
    count = len(offsets)
    near, far = offsets.T
    rise, other = values[1 : 1 + count] - values[0], values[1 + count :] - values[0]
    return np.asarray((rise * far / near - other * near / far) / (far - near))
