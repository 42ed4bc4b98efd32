"""Where the shapes of bodies meet a plane."""

from __future__ import annotations

from typing import Any

import numpy as np

from warpmuscle.core.number_rows import first_number, first_row
from warpmuscle.core.pose import rotate
from warpmuscle.scene import Box, Capsule, Character, Shape, Sphere
from warpmuscle.scene.initial_pose import Poses


def contact_points(shape: Shape) -> list[tuple[list[Any], Any]]:
    """Points and radii at which a shape meets a plane: a sphere's centre, a capsule's ends, a box's eight corners."""
    if isinstance(shape, Sphere):
        return [(list(shape.center), shape.radius)]
    if isinstance(shape, Capsule):
        return [(list(shape.start), shape.radius), (list(shape.end), shape.radius)]
    assert isinstance(shape, Box)
    (x0, y0, z0), (x1, y1, z1) = shape.low, shape.high
    return [([x, y, z], 0.0) for y in (y0, y1) for x in (x0, x1) for z in (z0, z1)]


def lowest_point(character: Character, poses: Poses) -> Any:
    """Height of the lowest point of all shapes of a character, m, of one pose, or (n,) of n poses.

    Raises:
        ValueError: it has no shapes.
    """
    heights = [
        (position + rotate(orientation, first_row(place)))[..., 1] - first_number(radius)
        for body, (position, orientation) in poses.items()
        for shape in character.bodies[body].shapes
        for place, radius in contact_points(shape)
    ]
    return np.min(heights, axis=0)
