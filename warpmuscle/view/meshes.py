"""Unit primitives as triangles, for viewers that have none of their own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats

Mesh = tuple[Floats, NDArray[np.uint32]]  # corners (V, 3), faces (F, 3)


def sphere(rings: int = 10, sectors: int = 16) -> Mesh:
    """A sphere of radius 1; corners at the poles coincide."""
    a, b = np.meshgrid(np.linspace(0.0, np.pi, rings + 1), np.linspace(0.0, 2.0 * np.pi, sectors + 1), indexing="ij")
    corners = np.stack([np.sin(a) * np.cos(b), np.cos(a), np.sin(a) * np.sin(b)], axis=-1).reshape(-1, 3)
    return corners, _grid_faces(rings, sectors)


def tube(sectors: int = 12, upper: float = 1.0) -> Mesh:
    """A tube of length 1 along y about its middle; its radius is 1 below, and `upper` above: a cone for 0."""
    b = np.linspace(0.0, 2.0 * np.pi, sectors + 1)
    circle = np.stack([np.cos(b), np.zeros_like(b), np.sin(b)], axis=-1)
    half = np.array([0.0, 0.5, 0.0])
    return np.concatenate([upper * circle + half, circle - half]), _grid_faces(1, sectors)


def box() -> Mesh:
    """A cube of edge 1; faces share no corners, so that they stay flat."""
    square = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    corners: list[Floats] = []
    faces: list[Floats] = []
    for axis in range(3):
        for sign in (-0.5, 0.5):
            side = np.insert(square, 0, sign, axis=1)
            first = 4 * len(corners)
            corners.append(np.roll(side, axis, axis=1))
            order = (0, 1, 2, 0, 2, 3) if sign > 0.0 else (0, 2, 1, 0, 3, 2)
            faces.append(first + np.array(order).reshape(2, 3))
    return np.concatenate(corners), np.concatenate(faces).astype(np.uint32)


def _grid_faces(rows: int, columns: int) -> NDArray[np.uint32]:
    """Two triangles for each cell of a grid of corners, seen from outside."""
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    k = (i * (columns + 1) + j).reshape(-1)
    below = k + columns + 1
    return np.concatenate([np.stack([k, k + 1, below], -1), np.stack([k + 1, below + 1, below], -1)]).astype(np.uint32)
