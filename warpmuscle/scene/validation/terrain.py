"""What the types of a scene cannot say about ground that is not flat."""

from __future__ import annotations

import math
from typing import Any

from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import check_size
from warpmuscle.scene.terrain.surface import grid_at
from warpmuscle.scene.terrain.tiles import (
    AnyTile,
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
from warpmuscle.scene.validation.checks import Checks

STEEPEST = math.radians(80.0)
MOST_PIECES = 10_000  # steps, stones, waves' points and the like, along one axis


def check_terrain(checks: Checks) -> None:
    """Check all tiles, their patches, and where they lie.

    Raises:
        SceneError: a number out of its range, tiles of too many points, or a damaged height field.
    """
    ground = checks.checked.ground
    terrain, key = ground.terrain, "ground.terrain"
    if terrain is None:
        return
    if not terrain.tiles:
        raise SceneError("there is no tile; give one, such as `[[ground.terrain.tiles]]` with `type`", f"{key}.tiles")
    if not checks.start(ground.normal[1]) > 0.0:
        raise SceneError("terrain lies over a plane whose normal points upwards", "ground.normal")
    low, high = checks.interval(terrain.tile)
    if low < -0.5 or high >= len(terrain.tiles) - 0.5:
        raise SceneError(f"tiles are numbered from 0 to {len(terrain.tiles) - 1}", f"{key}.tile")
    for index, tile in enumerate(terrain.tiles):
        _check_tile(f"{key}.tiles.{index}", tile, checks)
        _check_patches(f"{key}.tiles.{index}", tile, checks)
    points = sum(grid_at(tile).heights.size for tile in terrain.tiles)
    check_size("tiles", points, lambda text: SceneError(text, f"{key}.tiles"))


def _check_tile(key: str, tile: AnyTile, checks: Checks) -> None:
    """Lengths are positive, counts within bounds, and walls have room."""
    for name in ("rise", "height", "depth"):
        if abs(getattr(tile, name, 0.0)) > 1e4:
            raise SceneError("heights of tiles are at most 10000 m", f"{key}.{name}")
    match tile:
        case Slope():
            _slope(key, tile, checks)
        case Stairs():
            _pieces(key, "count", tile.count)
            _points(key, (tile.count * 2 * tile.tread + tile.landing) / min(tile.riser, tile.tread))
        case Steps():
            _pieces(key, "count", tile.count)
            _points(key, tile.count * tile.length / min(tile.riser, tile.length))
        case Stones():
            _stones(key, tile, checks)
        case Gaps():
            _pieces(key, "count", tile.count)
            if tile.spacing <= tile.width:
                raise SceneError(f"must be greater than the width {tile.width:g}", f"{key}.spacing")
            _points(key, tile.count * tile.spacing / min(tile.riser, tile.width / 3.0))
        case Waves():
            _pieces(key, "points", tile.points, least=4, most=1000)
        case Rough():
            for number, count in enumerate(tile.count):
                _pieces(key, f"count.{number}", count, least=2)
            _points(key, tile.count[0] * tile.count[1])
        case Profile():
            _profile(key, tile, checks)
        case HeightField():
            _height_field(key, tile)


def _slope(key: str, tile: Slope, checks: Checks) -> None:
    if not abs(tile.angle) <= STEEPEST:
        raise SceneError(f"{tile.angle:g} rad is steeper than {STEEPEST:.3g} rad, 80 degrees", f"{key}.angle")
    if tile.length is not None and tile.start is None:
        raise SceneError("a slope with a length has a start", f"{key}.start")


def _stones(key: str, tile: Stones, checks: Checks) -> None:
    for number, count in enumerate(tile.count):
        _pieces(key, f"count.{number}", count)
    cell = min(tile.riser, tile.gap / 3.0)
    sizes = [(size + tile.gap) * count / cell for size, count in zip(tile.size, tile.count, strict=True)]
    _points(key, sizes[0] * sizes[1])


def _profile(key: str, tile: Profile, checks: Checks) -> None:
    if len(tile.corners) < 2:
        raise SceneError("a profile has two corners at least", f"{key}.corners")
    checks.increasing(f"{key}.corners", [z for z, _ in tile.corners], "places z of corners")
    for number, ((before, _), (after, _)) in enumerate(zip(tile.corners, tile.corners[1:], strict=False), 1):
        if after - before < 0.5 * tile.spacing:
            raise SceneError(
                f"is nearer to the one before than the spacing {tile.spacing:g}", f"{key}.corners.{number}"
            )
    _points(key, (tile.corners[-1][0] - tile.corners[0][0]) / tile.spacing)


def _height_field(key: str, tile: HeightField) -> None:
    """The heights are there, whole, and in a place with a size."""
    if not tile.packed:
        raise SceneError("a height field takes its heights from a file; give its name", f"{key}.file")
    for number, count in enumerate(tile.points):
        _pieces(key, f"points.{number}", count, least=2, most=2**20)
    check_size("heights", tile.points[0] * tile.points[1], lambda text: SceneError(text, f"{key}.points"))
    for number, size in enumerate(tile.size):
        if not size > 0.0:
            raise SceneError("a height field has a size, m, along x and z, such as [10, 20]", f"{key}.size.{number}")
    try:
        heights = grid_at(tile).heights
    except ValueError as error:
        raise SceneError(str(error), f"{key}.packed") from None
    if not abs(heights).max() <= 1e4:  # NaN is not
        raise SceneError("heights must be finite, and at most 10000 m", f"{key}.{'file' if tile.file else 'packed'}")


def _check_patches(key: str, tile: AnyTile, checks: Checks) -> None:
    law = checks.checked.ground.law
    for index, patch in enumerate(tile.patches):
        own = f"{key}.patches.{index}"
        for name in ("x", "z"):
            low, high = getattr(patch, name)
            if low > high:
                raise SceneError(f"low {low:g} is greater than high {high:g}", f"{own}.{name}")
        if law == "soft_constraint" and (patch.stiffness, patch.damping) != (1.0, 1.0):
            raise SceneError('the law "soft_constraint" has patches of other friction alone', own)


def _pieces(key: str, name: str, number: Any, least: int = 1, most: int = MOST_PIECES) -> None:
    if not least <= number <= most:
        raise SceneError(f"must be from {least} to {most}, is {number}", f"{key}.{name}")


def _points(key: str, number: float) -> None:
    check_size("tiles", number, lambda text: SceneError(text, key))
