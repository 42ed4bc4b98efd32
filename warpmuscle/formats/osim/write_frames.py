"""Points and frames on bodies, as a model file has them."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.formats.osim.placement import WORLD, vector
from warpmuscle.formats.osim.xml_text import element, numbers


def angles_of(matrix: Floats) -> tuple[float, float, float]:
    """Angles, rad, about x, the new y and the newer z axis, of a matrix (3, 3)."""
    if abs(matrix[0, 2]) > 1.0 - 1e-12:  # x and z turn about one axis; as much as they should together
        return vector(np.array([0.0, np.pi / 2.0 * np.sign(matrix[0, 2]), np.arctan2(matrix[1, 0], matrix[1, 1])]))
    x = np.arctan2(-matrix[1, 2], matrix[2, 2])
    y = np.arcsin(np.clip(matrix[0, 2], -1.0, 1.0))
    return vector(np.array([x, y, np.arctan2(-matrix[0, 1], matrix[0, 0])]))


def placed(socket: str, path: str, position: Floats, tag: str = "location") -> str:
    """A point on a body: the socket that names it, and its place (3,), m, in our axes of it."""
    return element(socket, path) + element(tag, numbers(vector(WORLD.T @ position)))


def frame_xml(name: str, parent: str, place: Floats, turn: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> str:
    """An offset frame at a place (3,), m, of another one, turned by angles, rad, in OpenSim's axes."""
    inner = element("socket_parent", parent) + element("translation", numbers(vector(place)))
    return element("PhysicalOffsetFrame", inner + element("orientation", numbers(turn)), name=name)
