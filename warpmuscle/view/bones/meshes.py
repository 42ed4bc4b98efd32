"""Round bodies of triangles that bones are made of: tubes along curves, ellipsoids, and several of them as one mesh."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import normalized
from warpmuscle.view.hulls import Mesh

CAP = ((1.0, 0.0), (0.72, 0.7), (0.0, 1.0))  # of a tube's end: radius and way beyond it, in its radius


def tube(points: Sequence[Floats] | Floats, radii: float | Sequence[float] | Floats, sectors: int = 10) -> Mesh:
    """A tube with round ends along points (N, 3), m, with a radius at each."""
    way = np.asarray(points, dtype=np.float64)
    radius = np.broadcast_to(np.asarray(radii, dtype=np.float64), len(way)).copy()
    along = np.gradient(way, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    begin = [(way[0] - far * radius[0] * along[0], size * radius[0], along[0], -far) for size, far in CAP[:0:-1]]
    end = [(way[-1] + far * radius[-1] * along[-1], size * radius[-1], along[-1], far) for size, far in CAP[1:]]
    rings = [*begin, *zip(way, radius, along, np.zeros(len(way)), strict=True), *end]
    place = np.array([ring[0] for ring in rings])
    size = np.array([ring[1] for ring in rings])
    axis = np.array([ring[2] for ring in rings])
    lean = np.array([ring[3] for ring in rings])  # of the normal along the axis
    across = _perpendicular(axis)
    angle = 2.0 * np.pi * np.arange(sectors) / sectors
    outward = (
        np.cos(angle)[None, :, None] * across[:, None] + np.sin(angle)[None, :, None] * np.cross(axis, across)[:, None]
    )
    corners = place[:, None] + size[:, None, None] * outward
    flat = np.sqrt(np.maximum(1.0 - lean**2, 0.0))
    normals = flat[:, None, None] * outward + (lean[:, None] * axis)[:, None]
    return corners.reshape(-1, 3), normals.reshape(-1, 3), _grid(len(rings), sectors)


def ellipsoid(center: Floats, radii: Sequence[float], turn: Floats | None = None, sectors: int = 14) -> Mesh:
    """An ellipsoid about a point, m; `turn` has its axes as columns (3, 3), by default those of the body."""
    rows = sectors // 2 + 2
    polar, round_ = np.linspace(0.0, np.pi, rows), 2.0 * np.pi * np.arange(sectors) / sectors
    sphere = np.stack(
        [
            np.sin(polar)[:, None] * np.cos(round_),
            np.repeat(-np.cos(polar)[:, None], sectors, axis=1),
            -np.sin(polar)[:, None] * np.sin(round_),
        ],
        axis=-1,
    ).reshape(-1, 3)
    size, axes = np.asarray(radii, dtype=np.float64), np.eye(3) if turn is None else turn
    normals = normalized(sphere / size)
    return center + (sphere * size) @ axes.T, normals @ axes.T, _grid(rows, sectors)


def merged(meshes: Sequence[Mesh]) -> Mesh:
    """Several meshes as one."""
    offsets = np.cumsum([0, *(len(corners) for corners, _, _ in meshes)])
    corners, normals = (np.concatenate([mesh[k] for mesh in meshes]) for k in (0, 1))
    faces = np.concatenate([mesh[2] + offset for mesh, offset in zip(meshes, offsets, strict=False)])
    return corners, normals, faces


def _perpendicular(axis: Floats) -> Floats:
    """Directions (N, 3) across axes (N, 3) that turn as little as they can from one to the next."""
    first = np.eye(3)[int(np.argmin(np.abs(axis[0])))]
    found = []
    for one in axis:
        first = first - np.dot(first, one) * one
        first = first / max(float(np.linalg.norm(first)), 1e-12)
        found.append(first)
    return np.array(found)


def _grid(rows: int, sectors: int) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    """Triangles (F, 3) between rings of corners, counter-clockwise from outside; the first and last are points."""
    faces = []
    for row in range(rows - 1):
        for k in range(sectors):
            a, b = row * sectors + k, row * sectors + (k + 1) % sectors
            if row > 0:
                faces.append((a, b, a + sectors))
            if row < rows - 2:
                faces.append((b, b + sectors, a + sectors))
    return np.array(faces, dtype=np.int64)
