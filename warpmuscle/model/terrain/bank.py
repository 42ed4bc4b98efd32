"""Ground that is not flat as a kernel wants it: the grids of all tiles in a row, and where instances have theirs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import rows, starts, structs_to_device, to_device
from warpmuscle.kernels import structs
from warpmuscle.kernels.contact.terrain import ENDLESS_TOP
from warpmuscle.kernels.contact.walls import NEAR
from warpmuscle.model.terrain.bounds import bounds_arrays
from warpmuscle.scene import Ground, Terrain
from warpmuscle.scene.terrain.grid import Axis, Grid
from warpmuscle.scene.terrain.surface import as_text, grid_at, walls_of
from warpmuscle.scene.terrain.tiles import Patch

_banks: dict[tuple[bytes, str], tuple[wp.array, ...]] = {}  # the last one of each device


def terrain_struct(ground: Ground, device: Any) -> structs.Terrain:
    """The device structure of the ground of a scene whose numbers are floats or (n,) arrays; empty where it is flat."""
    s = structs.Terrain()
    terrain = ground.terrain
    if terrain is None:
        return s
    grids = [grid_at(tile) for tile in terrain.tiles]
    s.tile, s.height, s.crest, s.bounds, s.span, s.patch = _bank(terrain, grids, device)
    tile = np.clip(np.rint(rows([terrain.tile])), 0, len(grids) - 1).astype(np.int32)
    yaw, scale = rows([terrain.yaw]), rows([terrain.scale])
    tops = np.minimum([grid.top for grid in grids], ENDLESS_TOP)
    steepest = np.array([grid.steepest for grid in grids])
    columns = {
        "tile": tile, "x": rows([terrain.x]), "z": rows([terrain.z]), "cosine": np.cos(yaw), "sine": np.sin(yaw),
        "scale": scale, "top": np.where(tops[tile] < ENDLESS_TOP, scale * tops[tile], ENDLESS_TOP),
        "steepest": scale * steepest[tile],
    }  # fmt: skip
    s.place = structs_to_device(structs.TilePlace, columns, device)
    return s


def _bank(terrain: Terrain, grids: list[Grid], device: Any) -> tuple[wp.array, ...]:
    """Tiles, heights, crests, bounds and patches on a device, which keeps them as long as it is asked for no others."""
    key = as_text(terrain.tiles), str(device)
    if key not in _banks:
        for other in [kept for kept in _banks if kept[1] == key[1]]:
            del _banks[other]
        patches = [patch for tile in terrain.tiles for patch in tile.patches]
        heights = np.concatenate([grid.heights.ravel() for grid in grids])
        walled = [grid for tile, grid in zip(terrain.tiles, grids, strict=True) if walls_of(tile)]
        crests = np.concatenate([np.zeros((len(NEAR), 0)), *map(_crests, walled)], axis=1)
        _banks[key] = (
            _tiles(terrain, grids, device), to_device(heights, float, device), to_device(crests, float, device),
            *bounds_arrays(terrain, grids, device), _patches(patches, device),
        )  # fmt: skip
    return _banks[key]


def _tiles(terrain: Terrain, grids: list[Grid], device: Any) -> wp.array:
    """`kernels.structs.Tile` of all tiles."""
    sizes = np.array([grid.heights.shape for grid in grids])
    patches = starts(len(tile.patches) for tile in terrain.tiles)
    columns: dict[str, Any] = {
        "first": starts(grid.heights.size for grid in grids)[:-1], "rows": sizes[:, 0], "columns": sizes[:, 1],
        "first_patch": patches[:-1], "end_patch": patches[1:],
        "walls": [walls_of(tile) for tile in terrain.tiles],
        "first_crest": starts(
            grid.heights.size if walls_of(tile) else 0 for tile, grid in zip(terrain.tiles, grids, strict=True)
        )[:-1],
    }  # fmt: skip
    for name, axes, points in (("x", [g.x for g in grids], sizes[:, 1]), ("z", [g.z for g in grids], sizes[:, 0])):
        columns |= _axis(name, axes, points)
    return structs_to_device(structs.Tile, columns, device)


def _crests(grid: Grid) -> Floats:
    """Highest ground, m, within the distances `NEAR` of each cell, (2, heights).

    Cells are numbered as their first points. What is no cell, in the last row and column, has no meaning.
    """
    from scipy.ndimage import maximum_filter  # takes a while, which only walls cost

    cells = grid.heights.copy()
    cells[:-1] = np.maximum(cells[:-1], grid.heights[1:])
    cells[:, :-1] = np.maximum(cells[:, :-1], cells[:, 1:])
    beside = [[2 * math.ceil(near / axis.spacing) + 1 for axis in (grid.z, grid.x)] for near in NEAR]
    sizes = [[min(size, 2 * count) for size, count in zip(one, cells.shape, strict=True)] for one in beside]
    return np.stack([maximum_filter(cells, size=size, mode="nearest").ravel() for size in sizes])


def _axis(name: str, axes: list[Axis], points: Any) -> dict[str, Any]:
    """What of these columns is of one axis, called x or z."""
    low, high = zip(*(axis.ends(int(count)) for axis, count in zip(axes, points, strict=True)), strict=True)
    return {
        name: [axis.first for axis in axes],
        f"per_{name}": [1.0 / axis.spacing for axis in axes],
        f"period_{name}": [(count - 1.0) * axis.repeats for axis, count in zip(axes, points, strict=True)],
        f"low_{name}": low,
        f"high_{name}": high,
    }


def _patches(patches: list[Patch], device: Any) -> wp.array:
    """`kernels.structs.Patch` of all patches; one of no size where there are none."""
    found = patches or [Patch(x=(0.0, 0.0), z=(0.0, 0.0))]
    columns = {
        "low_x": [one.x[0] for one in found], "high_x": [one.x[1] for one in found],
        "low_z": [one.z[0] for one in found], "high_z": [one.z[1] for one in found],
        "friction": [one.friction for one in found], "stiffness": [one.stiffness for one in found],
        "damping": [one.damping for one in found],
    }  # fmt: skip
    return structs_to_device(structs.Patch, columns, device)
