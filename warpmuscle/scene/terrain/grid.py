"""A tile as heights on a grid, bilinear between its points: what all kinds of tiles become, and what a device reads."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats

ENDLESS = 1.0e6  # cells beyond its edge over which a slope that has no end goes on


class Axis(NamedTuple):
    """Points of a grid along one axis, and what is beyond them."""

    first: float  # m, of the first point
    spacing: float  # m
    level_before: bool = True  # else it goes on as between the first two points
    level_after: bool = True
    repeats: bool = False  # the last point is the first one again

    def cells(self, place: ArrayLike, points: int) -> Floats:
        """Places, m, in cells from the first point, wrapped into a grid of so many points that repeats."""
        cells = (np.asarray(place, dtype=float) - self.first) / self.spacing
        return np.asarray(cells - (points - 1) * np.floor(cells / (points - 1)) if self.repeats else cells)

    def ends(self, points: int) -> tuple[float, float]:
        """Cells between which the ground follows the grid; it is level beyond them."""
        last = float(points - 1)
        return 0.0 if self.level_before else -ENDLESS, last if self.level_after else last + ENDLESS


EVERYWHERE = Axis(0.0, 1.0)  # of two equal points: what is the same all along


class Grid(NamedTuple):
    """Heights over the plane of the ground, m."""

    heights: Floats  # (points along z, points along x), at least 2 each
    x: Axis
    z: Axis

    @property
    def top(self) -> float:
        """The highest that it gets anywhere, m."""
        rises = not (self.z.level_before and self.z.level_after and self.x.level_before and self.x.level_after)
        return np.inf if rises else float(self.heights.max())

    @property
    def steepest(self) -> float:
        """Its greatest slope in any direction, at most."""
        along_x = np.abs(np.diff(self.heights, axis=1)).max() / self.x.spacing
        along_z = np.abs(np.diff(self.heights, axis=0)).max() / self.z.spacing
        return float(np.hypot(along_x, along_z))

    def height_and_slope(self, x: ArrayLike, z: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Height, m, and how it grows along x and z at places of the tile, m; what kernels compute, in float64."""
        rows, columns = self.heights.shape
        (i, s, per_x), (j, t, per_z) = _within(self.x, x, columns), _within(self.z, z, rows)
        a, b = self.heights[j, i], self.heights[j, i + 1]
        c, d = self.heights[j + 1, i], self.heights[j + 1, i + 1]
        low, high = a + s * (b - a), c + s * (d - c)
        along_x = ((b - a) + t * ((d - c) - (b - a))) * per_x
        return np.asarray(low + t * (high - low)), np.asarray(along_x), np.asarray((high - low) * per_z)


def _within(axis: Axis, place: ArrayLike, points: int) -> tuple[np.ndarray, Floats, Floats]:
    """Cell that places are in, the part of it that is behind them, and cells a metre, 0 where the ground is level."""
    cells = axis.cells(place, points)
    held = np.clip(cells, *axis.ends(points))
    cell = np.clip(np.floor(held), 0, points - 2).astype(int)
    return cell, held - cell, np.where(held == cells, 1.0 / axis.spacing, 0.0)
