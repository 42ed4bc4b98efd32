"""Device structures of ground that is not flat, see `contact/terrain.py`."""

import warp as wp


@wp.struct
class Tile:
    """Heights on a grid, in axes of its own: x to the left, z forward."""

    first: int  # of its heights, which lie row by row along z
    columns: int  # points along x
    rows: int  # points along z
    first_patch: int
    end_patch: int
    x: float  # m, of the first point
    z: float  # m
    per_x: float  # cells a metre
    per_z: float
    period_x: float  # cells after which it comes again; 0: never
    period_z: float
    low_x: float  # cells from the first point, between which it is not level
    high_x: float
    low_z: float
    high_z: float
    walls: int  # along which axes it may have any: see `contact.walls`
    first_crest: int  # of its crests, as many as heights where it has walls


@wp.struct
class TilePlace:
    """Which tile an instance stands on, and where that lies."""

    tile: int
    x: float  # m, of its origin
    z: float  # m
    cosine: float  # of its turn to the left
    sine: float
    scale: float  # of its heights
    top: float  # m, the highest that it gets over the plane; see `contact.terrain.ENDLESS_TOP`
    steepest: float  # its greatest slope


@wp.struct
class Patch:
    """A rectangle of a tile, and what the ground is like in it."""

    low_x: float  # m, tile axes
    high_x: float
    low_z: float
    high_z: float
    friction: float
    stiffness: float  # times the ground's
    damping: float


@wp.struct
class TileBounds:
    """A coarse grid over a tile, of whose cells it is known how high the ground gets about them."""

    first: int  # of its cells, which lie row by row along z
    columns: int  # cells along x
    rows: int  # cells along z; 0: there are none, since it would spare nothing
    x: float  # m, where the first cell begins, tile axes
    z: float
    per_metre: float  # cells


@wp.struct
class Terrain:
    """Tiles that all instances share, and where they lie; nothing in it where the ground is flat."""

    place: wp.array2d[TilePlace]  # (rows, 1)
    tile: wp.array[Tile]  # (tiles,)
    height: wp.array[float]  # m, over the plane of the ground
    crest: wp.array2d[float]  # (2, crests) m, highest near each cell of tiles with walls, see `contact.walls.NEAR`
    bounds: wp.array[TileBounds]  # (tiles,)
    span: wp.array2d[wp.vec2]  # (3, cells) m, lowest and highest about each, see `contact.beneath.SPANS`
    patch: wp.array[Patch]  # (patches,)
