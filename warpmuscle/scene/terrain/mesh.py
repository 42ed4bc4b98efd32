"""Ground that is not flat as a mesh to be drawn, whose lines are those of the tile's own grid where it is seen."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene.terrain.grid import Axis
from warpmuscle.scene.terrain.surface import Lie, Surface

MOST = 240  # lines along an axis; of more, some are left out


class Mesh(NamedTuple):
    """Heights over the plane of the ground where lines of a tile cross."""

    x: Floats  # (n,) m, tile axes
    z: Floats  # (m,) m
    rise: Floats  # (m, n) m


def mesh_of(lie: Lie, low: Floats, high: Floats, most: int = MOST, longest: float = np.inf) -> Mesh:
    """The mesh of a tile where it lies within a rectangle of the world.

    Args:
        low, high: (2,) x and z of the rectangle's corners, m. most: lines along an axis. longest: m, from line to line,
            for which there are more of them.
    """
    corners = np.array([(x, z) for x in (low[0], high[0]) for z in (low[1], high[1])]) - (lie.x, lie.z)
    cosine, sine = np.cos(lie.yaw), np.sin(lie.yaw)
    u = corners[:, 0] * cosine - corners[:, 1] * sine
    w = corners[:, 0] * sine + corners[:, 1] * cosine
    rows, columns = lie.grid.heights.shape
    x, z = _lines(lie.grid.x, columns, u, most), _lines(lie.grid.z, rows, w, most)
    x, z = _split(x, longest), _split(z, longest)
    height, _, _ = lie.grid.height_and_slope(*np.meshgrid(x, z))
    return Mesh(x, z, lie.scale * height)


def in_world(lie: Lie, mesh: Mesh, surface: Surface) -> Floats:
    """Points (m, n, 3) of a mesh in the world, m."""
    u, w = np.meshgrid(mesh.x, mesh.z)
    cosine, sine = np.cos(lie.yaw), np.sin(lie.yaw)
    x, z = lie.x + u * cosine + w * sine, lie.z + w * cosine - u * sine
    return np.stack([x, surface.plane.height_at(x, z) + mesh.rise, z], axis=-1)


def _split(lines: Floats, longest: float) -> Floats:
    """Lines with others between those that are too far apart."""
    pieces = np.maximum(np.ceil(np.diff(lines) / longest), 1).astype(int)
    parts = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(lines, lines[1:], pieces, strict=False)]
    return np.concatenate([*parts, lines[-1:]])


def _lines(axis: Axis, points: int, places: Floats, most: int) -> Floats:
    """Where lines of a grid are along one axis, and the ends of what is seen."""
    low, high = float(places.min()), float(places.max())
    first, last = np.ceil((low - axis.first) / axis.spacing), np.floor((high - axis.first) / axis.spacing)
    if not axis.repeats:
        first, last = max(first, 0), min(last, points - 1)
    numbers: Any = np.arange(first, last + 1) if last - first < 1e6 else np.linspace(first, last, most)
    inner = axis.first + axis.spacing * numbers
    lines = np.unique(np.concatenate([[low], inner[(inner > low) & (inner < high)], [high]]))
    if len(lines) > most:
        lines = lines[np.unique(np.rint(np.linspace(0, len(lines) - 1, most)).astype(int))]
    return np.asarray(lines)
