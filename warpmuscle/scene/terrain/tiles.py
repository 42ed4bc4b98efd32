"""What a scene says of ground that is not flat: a bank of tiles, and which of them an instance stands on, and where.

A tile is a height, m, over the plane of the ground, given over its own axes: x to the left and z forward. Kinds that
run along z are the same at every x. Walls are ramps: the ground is asked below each point, and has one height there.
"""

from __future__ import annotations

from typing import Annotated, Literal

from warpmuscle.scene.number import Number
from warpmuscle.scene.part import ABOVE_0, FROM_0, Part

Pair = tuple[float, float]
Edge = Literal["level", "repeat"]


class Patch(Part):
    """A rectangle of a tile where the ground is of another kind; of several that overlap, the last one counts."""

    x: Annotated[Pair, "m"]  # from, to; tile axes
    z: Annotated[Pair, "m"]
    friction: Annotated[float, "1", FROM_0] = 1.0e3  # a contact takes the smallest one of body, ground and patch
    stiffness: Annotated[float, "1", ABOVE_0] = 1.0  # times that of the ground
    damping: Annotated[float, "1", FROM_0] = 1.0


class Tile(Part, kw_only=True):
    """What tiles of all kinds have."""

    patches: list[Patch] = []


class Flat(Tile, tag_field="type", tag="flat"):
    """Level ground."""


class Slope(Tile, tag_field="type", tag="slope"):
    """Ground that rises along z: everywhere, or from `start` on, or from there for a length; level else."""

    angle: Annotated[float, "rad"]  # negative: it falls
    start: Annotated[float | None, "m"] = None  # along z; by default it has none, and goes through the tile's origin
    length: Annotated[float | None, "m", ABOVE_0] = None  # along z; by default it has no end


class Stairs(Tile, tag_field="type", tag="stairs"):
    """Stairs along z: up, a landing, and down again."""

    rise: Annotated[float, "m"] = 0.17  # of a step; negative: down first
    tread: Annotated[float, "m", ABOVE_0] = 0.29  # from edge to edge
    count: int = 5  # of steps up
    start: Annotated[float, "m"] = 1.0  # the edge of the first step
    landing: Annotated[float, "m", ABOVE_0] = 1.0  # from the last edge up to the first one down
    returns: bool = True  # whether they go down again; else the landing has no end
    riser: Annotated[float, "m", ABOVE_0] = 0.02  # along z, over which the ground rises before an edge, at most


class Steps(Tile, tag_field="type", tag="steps"):
    """Level pieces one after the other along z, each at a height drawn from -height to height."""

    height: Annotated[float, "m", FROM_0] = 0.05
    length: Annotated[float, "m", ABOVE_0] = 0.5
    count: int = 20
    start: Annotated[float, "m"] = 1.0
    seed: Annotated[int, FROM_0] = 0
    riser: Annotated[float, "m", ABOVE_0] = 0.02


class Stones(Tile, tag_field="type", tag="stones"):
    """Stepping stones in rows across z, with trenches around them; level before the first row and behind the last."""

    size: Annotated[Pair, "m", ABOVE_0] = (0.3, 0.4)  # of a stone along x and z
    gap: Annotated[float, "m", ABOVE_0] = 0.1  # between stones, walls included
    depth: Annotated[float, "m", FROM_0] = 0.3  # of the trenches
    height: Annotated[float, "m", FROM_0] = 0.0  # by which stones are higher or lower at most, drawn
    count: tuple[int, int] = (5, 12)  # along x and z
    start: Annotated[float, "m"] = 1.0  # where the first trench begins
    seed: Annotated[int, FROM_0] = 0
    riser: Annotated[float, "m", ABOVE_0] = 0.02


class Gaps(Tile, tag_field="type", tag="gaps"):
    """Trenches across z."""

    width: Annotated[float, "m", ABOVE_0] = 0.2  # along z, walls included
    depth: Annotated[float, "m", FROM_0] = 0.5
    spacing: Annotated[float, "m", ABOVE_0] = 1.5  # from trench to trench
    count: int = 5
    start: Annotated[float, "m"] = 1.5
    riser: Annotated[float, "m", ABOVE_0] = 0.02


class Waves(Tile, tag_field="type", tag="waves"):
    """Waves without end: height sin(2 pi z/length), times cos(2 pi x/across) where that is given."""

    height: Annotated[float, "m", FROM_0] = 0.05
    length: Annotated[float, "m", ABOVE_0] = 1.0
    across: Annotated[float | None, "m", ABOVE_0] = None
    points: int = 24  # of a wave, between which the ground is straight


class Rough(Tile, tag_field="type", tag="rough"):
    """Bumps without end: heights drawn from -height to height at points of a grid, straight between them."""

    height: Annotated[float, "m", FROM_0] = 0.05
    spacing: Annotated[float, "m", ABOVE_0] = 0.25  # of points
    count: tuple[int, int] = (32, 64)  # of points along x and z, after which the bumps come again
    seed: Annotated[int, FROM_0] = 0


class Profile(Tile, tag_field="type", tag="profile"):
    """Ground along z by corners, straight between them, and level before the first and behind the last one."""

    corners: Annotated[list[Pair], "m"]  # z and height; z is taken to the next multiple of the spacing
    spacing: Annotated[float, "m", ABOVE_0] = 0.02


class HeightField(Tile, tag_field="type", tag="height_field"):
    """Heights at points of a grid, from a file: bilinear between them, the middle of the grid at the tile's origin.

    `file`: a PNG, black at 0 and white at `height`, the top of the picture forward and its left
    side to the left; numbers in m, times `height`, in a `.npy` or `.csv`, rows along z and columns along x, both
    increasing; or a MuJoCo model (`.xml`), of which the `hfield` of a geom is taken with its own size. Relative to the
    scene's folder. A scene keeps the heights in `packed`, so that results and other machines need no file.
    """

    file: str = ""
    size: Annotated[Pair, "m"] = (0.0, 0.0)  # along x and z, from first to last point
    height: Annotated[float, "m"] = 1.0  # of white, or a factor
    edge: Edge = "level"  # beyond it the ground is level, or comes again
    points: tuple[int, int] = (0, 0)  # of `packed`, along x and z
    packed: str = ""  # heights as little-endian float32, row by row along z, compressed by zlib, in base64


AnyTile = Flat | Slope | Stairs | Steps | Stones | Gaps | Waves | Rough | Profile | HeightField


class Terrain(Part):
    """Ground that is not flat: heights over the ground's plane, which may itself be inclined.

    All numbers but those of tiles may differ between instances and follow commands. At a start, the root is raised by
    the highest ground within `clearing` of it.
    """

    tiles: list[AnyTile]
    tile: Annotated[Number, "1"] = 0.0  # which one, counted from 0; the nearest whole number
    scale: Annotated[Number, "1", FROM_0] = 1.0  # of heights: 0 is flat
    x: Annotated[Number, "m"] = 0.0  # where the tile's origin lies
    z: Annotated[Number, "m"] = 0.0
    yaw: Annotated[Number, "rad"] = 0.0  # by which the tile is turned to the left about its origin
    clearing: Annotated[float, "m", FROM_0] = 0.25
