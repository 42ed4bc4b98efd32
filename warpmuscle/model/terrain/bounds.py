"""How low and how high tiles get about places, on coarse grids: what spares a body the questions of its spheres."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import starts, structs_to_device, to_device
from warpmuscle.kernels import structs
from warpmuscle.kernels.contact.beneath import SPANS
from warpmuscle.scene import Terrain
from warpmuscle.scene.terrain.grid import Axis, Grid
from warpmuscle.scene.terrain.surface import is_bounded

CELL = 0.1  # m
MOST = 1000  # cells along an axis; larger tiles have larger cells


def bounds_arrays(terrain: Terrain, grids: list[Grid], device: Any) -> tuple[wp.array, wp.array]:
    """`kernels.structs.TileBounds` of all tiles, and lowest and highest ground about the cells of all, one by one."""
    found = [bounds_of(grid) if is_bounded(tile) else None for tile, grid in zip(terrain.tiles, grids, strict=True)]
    spans = [one[0] if one else np.zeros((len(SPANS), 0, 1, 2)) for one in found]
    columns = {
        "first": starts(span[0, ..., 0].size for span in spans)[:-1],
        "rows": [span.shape[1] for span in spans],
        "columns": [span.shape[2] for span in spans],
        **{name: [one[1][k] if one else 0.0 for one in found] for k, name in enumerate(("x", "z", "per_metre"))},
    }
    cells = np.concatenate([span.reshape(len(SPANS), -1, 2) for span in spans], axis=1)
    return structs_to_device(structs.TileBounds, columns, device), to_device(cells, wp.vec2, device)


def bounds_of(grid: Grid) -> tuple[Floats, tuple[float, float, float]]:
    """Lowest and highest ground within each of `SPANS` of each cell of a coarse grid, (3, rows, columns, 2), m.

    The coarse grid goes on beyond the tile, to where all is as at its edge. A cell's distances are along the axes.

    Returns:
        Also where it begins along x and z, m, and its cells a metre.
    """
    lengths = [axis.spacing * (count - 1) for axis, count in zip((grid.z, grid.x), grid.heights.shape, strict=True)]
    cell = max(CELL, max(lengths) / MOST)
    beyond = math.ceil(max(SPANS) / cell) + 2  # so that its outermost cells are level
    low, high = ([extremes(grid, how, reach, cell, beyond) for reach in SPANS] for how in (np.minimum, np.maximum))
    start = [axis.first - beyond * cell for axis in (grid.x, grid.z)]
    return np.stack([low, high], axis=-1), (start[0], start[1], 1.0 / cell)


def extremes(grid: Grid, how: np.ufunc, reach: float, cell: float, beyond: int) -> Floats:
    """The lowest or the highest ground within a distance of each cell, (rows, columns), m."""
    heights = grid.heights
    for axis in (grid.z, grid.x):
        first, last = points_about(axis, heights.shape[0], reach, cell, beyond)
        heights = np.stack([how.reduce(heights[a : b + 1], axis=0) for a, b in zip(first, last, strict=True)]).T
    return heights


def points_about(axis: Axis, points: int, reach: float, cell: float, beyond: int) -> tuple[np.ndarray, np.ndarray]:
    """The first and the last point of a grid that say how high the ground is within a distance of each coarse cell."""
    count = math.ceil(axis.spacing * (points - 1) / cell - 1e-9) + 2 * beyond
    start = cell * (np.arange(count) - beyond)
    first = np.floor((start - reach) / axis.spacing - 1e-6)
    last = np.ceil((start + cell + reach) / axis.spacing + 1e-6)
    return tuple(np.clip(one, 0, points - 1).astype(int) for one in (first, last))
