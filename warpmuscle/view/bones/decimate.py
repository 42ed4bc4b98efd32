"""Surfaces of fewer triangles: corners near one another are joined (Rossignac and Borrel 1993). Numbers only."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.formats.meshes.triangles import Triangles
from warpmuscle.view.hulls import Mesh

TRIALS = 18  # to find the size of cells
FINEST, COARSEST = 2.0e-4, 0.2  # of cells, in the extent of all surfaces


def thinned(surfaces: Sequence[Triangles], most: int) -> list[Triangles]:
    """The same surfaces with so many corners at most together, all of them as fine; small ones lose the most."""
    if sum(len(one.corners) for one in surfaces) <= most:
        return list(surfaces)
    extent = max(float(np.ptp(one.corners, axis=0).max()) for one in surfaces)
    low, high = FINEST * extent, COARSEST * extent
    for _ in range(TRIALS):
        cell = float(np.sqrt(low * high))
        count = sum(len(np.unique(_cells(one.corners, cell), axis=0)) for one in surfaces)
        low, high = (cell, high) if count > most else (low, cell)
    return [joined(one, high) for one in surfaces]


def joined(surface: Triangles, cell: float) -> Triangles:
    """A surface whose corners in each cubic cell of an edge, in its unit, are one, in their middle."""
    _, at, counts = np.unique(_cells(surface.corners, cell), axis=0, return_inverse=True, return_counts=True)
    at = at.reshape(-1)
    corners = np.stack([np.bincount(at, surface.corners[:, k], len(counts)) / counts for k in range(3)], axis=1)
    faces = at[surface.faces]
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    faces = faces[whole]
    turned = np.argmin(faces, axis=1) if len(faces) else np.zeros(0, dtype=np.int64)
    first = np.take_along_axis(faces, (turned[:, None] + np.arange(3)) % 3, axis=1)
    faces = np.unique(first, axis=0)
    used, again = np.unique(faces, return_inverse=True)
    return Triangles(corners[used], again.reshape(-1, 3))


def shaded(surface: Triangles) -> Mesh:
    """A surface with a normal at each corner: the mean of its triangles', by their areas."""
    a, b, c = (surface.corners[surface.faces[:, k]] for k in range(3))
    area = np.cross(b - a, c - a)
    normals = np.zeros_like(surface.corners)
    for k in range(3):
        np.add.at(normals, surface.faces[:, k], area)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return surface.corners, np.where(length > 0.0, normals / np.maximum(length, 1e-300), [0.0, 1.0, 0.0]), surface.faces


def _cells(corners: Floats, cell: float) -> Integers:
    return np.asarray(np.floor(corners / cell), dtype=np.int64)
