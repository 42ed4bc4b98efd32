"""Where the shapes of bodies meet a plane."""

from __future__ import annotations

from typing import Any

from warpmuscle.scene import Box, Capsule, Shape, Sphere


def contact_points(shape: Shape) -> list[tuple[list[Any], Any]]:
    """Points and radii at which a shape meets a plane: a sphere's centre, a capsule's ends, a box's eight corners."""
    if isinstance(shape, Sphere):
        return [(list(shape.center), shape.radius)]
    if isinstance(shape, Capsule):
        return [(list(shape.start), shape.radius), (list(shape.end), shape.radius)]
    assert isinstance(shape, Box)
    (x0, y0, z0), (x1, y1, z1) = shape.low, shape.high
    return [([x, y, z], 0.0) for y in (y0, y1) for x in (x0, x1) for z in (z0, z1)]
