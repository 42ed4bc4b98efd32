"""The ground of a numeric scene as a surface: its plane, and the heights of a tile over it."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.pose import normalized
from warpmuscle.scene import Ground
from warpmuscle.scene.ground import Plane, plane
from warpmuscle.scene.terrain.grid import Grid
from warpmuscle.scene.terrain.shapes import grid_of
from warpmuscle.scene.terrain.tiles import AnyTile, Gaps, Profile, Stairs, Steps, Stones, Terrain

WITH_WALLS = (Stairs, Steps, Stones, Gaps, Profile)
TALL = 0.1  # m, from the lowest to the highest ground of a tile without walls that has bounds, see `is_bounded`
WALL = 0.5  # slope of a wall before heights are scaled, at least; see `kernels.contact.walls`


class Lie(NamedTuple):
    """A tile, and where it lies."""

    grid: Grid
    x: float  # m, of its origin
    z: float  # m
    yaw: float  # rad, by which it is turned to the left
    scale: float  # of its heights

    def rise(self, x: ArrayLike, z: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Height over the ground's plane, m, and how it grows along x and z of the world."""
        cosine, sine = np.cos(self.yaw), np.sin(self.yaw)
        to_x, to_z = np.asarray(x, dtype=float) - self.x, np.asarray(z, dtype=float) - self.z
        height, u, w = self.grid.height_and_slope(to_x * cosine - to_z * sine, to_x * sine + to_z * cosine)
        return self.scale * height, self.scale * (u * cosine + w * sine), self.scale * (w * cosine - u * sine)


AROUND = 4  # places to each side of the root where the ground is asked at a start; see `kernels.contact.terrain_starts`


class Surface(NamedTuple):
    """The ground: a plane, or what lies over it."""

    plane: Plane
    lie: Lie | None = None

    def height_at(self, x: ArrayLike, z: ArrayLike) -> Floats:
        """Height y at places of the world, m."""
        level = self.plane.height_at(x, z)
        return level if self.lie is None else np.asarray(level + self.lie.rise(x, z)[0])

    def highest_rise(self, x: float, z: float, clearing: float) -> float:
        """The highest that the ground rises over its plane within `clearing` of a place along x and z, m."""
        if self.lie is None:
            return 0.0
        beside = clearing * np.arange(-AROUND, AROUND + 1) / AROUND
        return float(self.lie.rise(x + beside[:, None], z + beside)[0].max())

    def normal_at(self, x: ArrayLike, z: ArrayLike) -> Floats:
        """Unit normals (..., 3), upwards, at places of the world."""
        shape = np.broadcast_shapes(np.shape(x), np.shape(z))
        normal = np.broadcast_to(self.plane.normal, (*shape, 3))
        if self.lie is None:
            return normal
        _, along_x, along_z = self.lie.rise(x, z)
        steep = normal / normal[..., 1:2]
        steep = np.stack([steep[..., 0] - along_x, np.ones(shape), steep[..., 2] - along_z], axis=-1)
        return normalized(steep)

    def above(self, places: ArrayLike) -> Floats:
        """Distance of places (..., 3), m, from the plane that touches the ground below each: m, negative inside."""
        place = np.asarray(places, dtype=float)
        if self.lie is None:
            return np.asarray(place @ self.plane.normal - self.plane.height)
        x, y, z = np.moveaxis(place, -1, 0)
        return np.asarray((y - self.height_at(x, z)) * self.normal_at(x, z)[..., 1])


def surface(ground: Ground) -> Surface:
    """The ground of a numeric scene; of several instances, that of the first."""
    flat = plane(first_of(ground))
    if ground.terrain is None:
        return Surface(flat)
    t = ground.terrain
    number = tile_number(t, first_number(t.tile))
    lie = Lie(grid_at(t.tiles[number]), *(first_number(one) for one in (t.x, t.z, t.yaw, t.scale)))
    return Surface(flat, lie)


def first_of(ground: Ground) -> Ground:
    """The plane's numbers of the first instance."""
    normal = tuple(first_number(one) for one in ground.normal)
    return msgspec.structs.replace(ground, normal=normal, height=first_number(ground.height))


def tile_number(terrain: Terrain, number: float) -> int:
    """Which tile a number means: the nearest one that there is."""
    return int(np.clip(np.rint(number), 0, len(terrain.tiles) - 1))


def grid_at(tile: AnyTile) -> Grid:
    """The grid of a tile, made once for tiles that say the same."""
    return _grid(as_text(tile), type(tile))


def walls_of(tile: AnyTile) -> int:
    """Along which axes a tile may have walls beside which spheres touch it: 1 of z and 2 of x, added; 0: it has none.

    Heights of a file and bumps have slopes in all directions, and none of these is a wall.
    """
    if not isinstance(tile, WITH_WALLS):
        return 0
    grid = grid_at(tile)
    steepest = [np.abs(np.diff(grid.heights, axis=k)).max() / axis.spacing for k, axis in enumerate((grid.z, grid.x))]
    return sum(bit for bit, slope in zip((1, 2), steepest, strict=True) if slope > WALL)


def is_bounded(tile: AnyTile) -> bool:
    """Whether a body on a tile first asks how high that gets about it: with walls or tall, and not repeated."""
    grid = grid_at(tile)
    repeats = grid.x.repeats or grid.z.repeats
    return not repeats and np.isfinite(grid.top) and (walls_of(tile) != 0 or float(np.ptp(grid.heights)) > TALL)


def as_text(tiles: AnyTile | list[AnyTile]) -> bytes:
    """What tiles say, to tell them apart; NumPy's scalars count as plain numbers."""
    return msgspec.json.encode(tiles, enc_hook=lambda number: number.item())


@lru_cache(maxsize=64)
def _grid(tile: bytes, kind: type[AnyTile]) -> Grid:
    return grid_of(msgspec.json.decode(tile, type=kind))
