"""The grids that kinds of tiles are made of. Their surfaces are those that the tiles describe, not samples of them.

Along z, points are so near that a wall is one cell. Lengths that are no multiple of this cell become the next one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.scene.terrain.grid import EVERYWHERE, Axis, Grid
from warpmuscle.scene.terrain.packing import unpacked
from warpmuscle.scene.terrain.tiles import (
    AnyTile,
    Flat,
    Gaps,
    HeightField,
    Profile,
    Rough,
    Slope,
    Stairs,
    Steps,
    Stones,
    Waves,
)


def grid_of(tile: AnyTile) -> Grid:
    """The grid of a checked tile."""
    make: Callable[[Any], Grid] = GRIDS[type(tile)]
    return make(tile)


def flat(tile: Flat) -> Grid:
    """Zeros."""
    return along_z(np.zeros(2), Axis(0.0, 1.0))


def slope(tile: Slope) -> Grid:
    """Two points, a cell apart."""
    length = 1.0 if tile.length is None else tile.length
    axis = Axis(tile.start or 0.0, length, tile.start is not None, tile.length is not None)
    return along_z(np.array([0.0, math.tan(tile.angle) * length]), axis)


def stairs(tile: Stairs) -> Grid:
    """Points at both ends of every riser."""
    cell, whole = cell_of(tile.tread, tile.riser)
    up = np.repeat(np.arange(tile.count + 1), [1, *[whole] * (tile.count - 1), cells(tile.landing, cell) + 1])
    down = np.repeat(np.arange(tile.count - 1, -1, -1), [*[whole] * (tile.count - 1), 1])
    levels = np.concatenate([up, down]) if tile.returns else up
    return along_z(tile.rise * levels, Axis(tile.start - cell, cell))


def _drawn(tile: Steps | Stones | Rough, shape: int | tuple[int, ...]) -> Floats:
    """Heights of this shape, m, up to that of the tile to either side of 0, which may be written -0.0."""
    most = abs(tile.height)
    return np.asarray(np.random.default_rng(tile.seed).uniform(-most, most, shape))


def steps(tile: Steps) -> Grid:
    """Points at both ends of every riser."""
    cell, whole = cell_of(tile.length, tile.riser)
    drawn = _drawn(tile, tile.count)
    return along_z(np.concatenate([[0.0], np.repeat(drawn, whole), [0.0]]), Axis(tile.start - cell, cell))


def stones(tile: Stones) -> Grid:
    """Stones and trenches in whole cells, and a level row before and behind."""
    cell, whole = cell_of(tile.gap, tile.riser)
    wide, long = (
        _runs(count, cells(size, cell) + 1, whole - 1) for count, size in zip(tile.count, tile.size, strict=True)
    )
    drawn = _drawn(tile, tile.count[::-1])
    heights = np.where((long[:, None] < 0) | (wide < 0), -tile.depth, drawn[long[:, None], wide])
    level = np.zeros((1, len(wide)))
    middle = 0.5 * (len(wide) - 1) * cell
    return Grid(np.concatenate([level, heights, level]), Axis(-middle, cell), Axis(tile.start, cell))


def gaps(tile: Gaps) -> Grid:
    """Points at both ends of every wall."""
    cell, whole = cell_of(tile.width, tile.riser)
    one = np.concatenate([np.full(whole - 1, -tile.depth), np.zeros(cells(tile.spacing - tile.width, cell) + 1)])
    return along_z(np.concatenate([[0.0], np.tile(one, tile.count)]), Axis(tile.start, cell))


def waves(tile: Waves) -> Grid:
    """Whole waves, which repeat."""
    phase = 2.0 * np.pi * np.arange(tile.points + 1) / tile.points
    along = tile.height * np.sin(phase)
    along[-1] = along[0]
    z = Axis(0.0, tile.length / tile.points, repeats=True)
    if tile.across is None:
        return along_z(along, z)
    over = np.cos(phase)
    over[-1] = over[0]
    return Grid(along[:, None] * over, Axis(0.0, tile.across / tile.points, repeats=True), z)


def rough(tile: Rough) -> Grid:
    """Random heights, which repeat; the middle is at the origin."""
    columns, rows = tile.count
    drawn = _drawn(tile, (rows, columns))
    return _repeated(drawn, tile.spacing, tile.spacing)


def profile(tile: Profile) -> Grid:
    """The corners, and points between them."""
    corners = np.array(tile.corners, dtype=float)
    at = np.rint((corners[:, 0] - corners[0, 0]) / tile.spacing).astype(int)
    heights = np.interp(np.arange(max(at[-1] + 1, 2)), at, corners[:, 1])
    return along_z(heights, Axis(float(corners[0, 0]), tile.spacing))


def height_field(tile: HeightField) -> Grid:
    """The heights of the file."""
    heights = unpacked(tile)
    rows, columns = heights.shape
    if tile.edge == "repeat":
        return _repeated(heights, tile.size[0] / columns, tile.size[1] / rows)
    x, z = (Axis(-0.5 * size, size / (n - 1)) for size, n in zip(tile.size, (columns, rows), strict=True))
    return Grid(heights, x, z)


GRIDS: dict[type, Callable[[Any], Grid]] = {
    Flat: flat, Slope: slope, Stairs: stairs, Steps: steps, Stones: stones, Gaps: gaps, Waves: waves, Rough: rough,
    Profile: profile, HeightField: height_field,
}  # fmt: skip


def along_z(heights: Floats, axis: Axis) -> Grid:
    """A grid that is the same at every x."""
    return Grid(np.stack([heights, heights], axis=1), EVERYWHERE, axis)


def cell_of(length: float, most: float) -> tuple[float, int]:
    """The longest cell, m, that is not longer than `most` and fits whole times, at least three, into a length."""
    whole = max(math.ceil(length / most - 1e-9), 3)
    return length / whole, whole


def cells(length: float, cell: float) -> int:
    """How many cells a length is, at least one."""
    return max(round(length / cell), 1)


def _runs(count: int, size: int, between: int) -> NDArray[np.int64]:
    """-1 so many times as `between` says, then 0 `size` times, then -1 again, 1, ..., -1."""
    gap = np.full(between, -1)
    return np.concatenate([*(part for k in range(count) for part in (gap, np.full(size, k))), gap])


def _repeated(heights: Floats, spacing_x: float, spacing_z: float) -> Grid:
    """Heights that come again, their middle at the origin."""
    closed = np.pad(heights, ((0, 1), (0, 1)), mode="wrap")
    rows, columns = heights.shape
    x, z = (Axis(-(n // 2) * s, s, repeats=True) for n, s in ((columns, spacing_x), (rows, spacing_z)))
    return Grid(closed, x, z)
