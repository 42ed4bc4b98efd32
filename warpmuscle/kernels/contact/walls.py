"""Walls beside spheres: risers of stairs and steps, sides of stones and trenches, which are cells of a tile's grid.

A sphere rests on what is below its middle, and besides on the walls that rise in front of it along both axes of the
tile. Of a wall it touches the nearest point: of the face, or its upper edge. Below a middle that is over a wall is
the ground at the foot of the wall, so that a sphere in a corner rests on both. Points have no walls beside them: they
touch nothing before they are in it.
"""

import warp as wp

from warpmuscle.kernels.contact.terrain import (
    Footing,
    footing,
    footing_near,
    in_tile,
    rise_at,
    tile_surface,
    turned_rise,
)
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, at
from warpmuscle.kernels.terrain_structs import TilePlace

ALONG_Z, ALONG_X = wp.constant(1), wp.constant(2)  # bits of `Tile.walls`
NEAR = (0.03, 0.2)  # m beside a cell, within which the highest ground is known beforehand
WAYS = 5  # what is below, and four directions with walls
STEEP = wp.constant(1.0)  # slope of a wall, at least
NOTHING = wp.constant(1.0e30)  # m, height over a plane that is none
MOST = wp.constant(64)  # cells beside a sphere that are looked at
NARROWEST = wp.constant(3.0)  # cells of a wall, what is behind it, and the wall behind that
LEVEL = wp.constant(1.0e-4)  # m, by which ground beside a sphere is higher, if there is a wall


@func
def tile_way(way: int) -> wp.vec2:
    """A direction in a tile's axes: forward, back, left or right for 1 to 4."""
    sign = wp.where(way % 2 == 1, 1.0, -1.0)
    return wp.where(way <= 2, wp.vec2(0.0, sign), wp.vec2(sign, 0.0))


@func
def in_world(way: wp.vec2, place: TilePlace) -> wp.vec3:
    """A direction in a tile's axes in those of the world."""
    return wp.vec3(way[0] * place.cosine + way[1] * place.sine, 0.0, way[1] * place.cosine - way[0] * place.sine)


@func
def cells_behind(own: wp.vec2, way: wp.vec2, start: float, per_metre: float) -> float:
    """Cells from the last line of a grid behind a place, along a direction, to the place."""
    cells = (wp.dot(own, way) - start) * per_metre
    return cells - wp.floor(cells)


@func
def slope_along(own: wp.vec2, along: wp.vec2, place: TilePlace, model: ModelRef) -> float:
    """How the ground rises along an axis of its tile at a place of that."""
    found = tile_surface(own[0], own[1], model.contacts.terrain.tile[place.tile], model.contacts.terrain.height)
    return place.scale * (along[0] * found[1] + along[1] * found[2])


@func
def wall_beside(
    instance: int, way: int, normal: wp.vec3, height: float, arm: wp.vec3, point: wp.vec3, reach: float, model: ModelRef
) -> Footing:
    """The plane that touches the nearest wall of a tile in a direction from the middle of a sphere; see `NOTHING`.

    Args:
        way: 1 to 4, see `tile_way`. normal, height, arm: as of `footing`. point: the middle, m, world.
        reach: m from the middle, within which walls count.
    """
    found = Footing()
    found.normal = normal
    found.height = NOTHING
    place = at(model.contacts.terrain.place, instance, 0)
    tile = model.contacts.terrain.tile[place.tile]
    if tile.walls & wp.where(way <= 2, ALONG_Z, ALONG_X) == 0:
        return found
    heights = model.contacts.terrain.height
    along = tile_way(way)
    forward = in_world(along, place)
    own = in_tile(point[0], point[2], place)
    per_metre = wp.where(way <= 2, tile.per_z, tile.per_x)
    if reach * per_metre <= NARROWEST:  # else there may be a wall, and lower ground behind it
        here = tile_surface(own[0], own[1], tile, heights)
        there = tile_surface(own[0] + reach * along[0], own[1] + reach * along[1], tile, heights)
        if (there[0] - here[0]) * place.scale <= LEVEL:
            return found
    first = wp.where(way <= 2, tile.z, tile.x)
    cell = 1.0 / per_metre
    near = -cell * cells_behind(own, along, (along[0] + along[1]) * first, per_metre)
    incline = -wp.dot(normal, forward) / normal[1]
    over = (height + wp.dot(normal, arm)) / normal[1]
    line = own + along * near
    low = place.scale * tile_surface(line[0], line[1], tile, heights)[0]
    best = wp.float32(reach)
    for _ in range(MOST):
        if near >= reach:
            break
        far = near + cell
        line = own + along * far
        high = place.scale * tile_surface(line[0], line[1], tile, heights)[0]
        if high - low > STEEP * cell:
            a = wp.vec2(near, low + incline * near - over)
            b = wp.vec2(far, high + incline * far - over)
            d = b - a
            share = -wp.dot(a, d) / wp.length_sq(d)
            if share > 0.0:
                out = wp.normalize(wp.vec2(-d[1], d[0]))
                distance = -wp.dot(a, out)
                if share >= 1.0:
                    distance = wp.length(b)
                    out = -wp.normalize(b)
                if distance < best:
                    best = distance
                    found.normal = forward * out[0] + wp.vec3(0.0, out[1], 0.0)
                    found.height = distance - wp.dot(found.normal, arm)
        near = far
        low = high
    return found


@func
def foot_of_wall(instance: int, point: wp.vec3, reach: float, model: ModelRef) -> wp.vec3:
    """The level way, m, from a place on a wall to the ground at its foot, half a cell from it; 0 from elsewhere.

    It ends on the wall where the foot is farther than the reach.
    """
    place = at(model.contacts.terrain.place, instance, 0)
    tile = model.contacts.terrain.tile[place.tile]
    own = in_tile(point[0], point[2], place)
    here = own
    for axis in range(2):
        if tile.walls & wp.where(axis == 0, ALONG_Z, ALONG_X) != 0:
            along = wp.where(axis == 0, wp.vec2(0.0, 1.0), wp.vec2(1.0, 0.0))
            first = wp.where(axis == 0, tile.z, tile.x)
            cell = 1.0 / wp.where(axis == 0, tile.per_z, tile.per_x)
            middle = here + along * cell * (0.5 - cells_behind(here, along, first, 1.0 / cell))
            slope = slope_along(middle, along, place, model)
            if wp.abs(slope) > STEEP:
                here = middle
                gone = wp.float32(0.0)
                while gone < reach and wp.abs(slope) > STEEP:
                    here -= along * wp.sign(slope) * cell
                    gone += cell
                    slope = slope_along(here, along, place, model)
    return in_world(here - own, place)


@wp.struct
class Beneath:
    """The ground beneath a sphere."""

    ways: int  # in which it may touch: 0, 1: below alone, or `WAYS`
    rise: wp.vec3  # of the ground below its middle, where it may touch in any; see `rise_at`


@func
def ways_of(
    instance: int, normal: wp.vec3, height: float, arm: wp.vec3, point: wp.vec3, radius: float, margin: float,
    model: ModelRef,
) -> Beneath:  # fmt: skip
    """In how many ways a sphere may touch the ground, and how this rises. Arguments as of `sphere_plane`."""
    beneath = Beneath()
    place = at(model.contacts.terrain.place, instance, 0)
    tile = model.contacts.terrain.tile[place.tile]
    reach = radius + margin
    own = in_tile(point[0], point[2], place)
    crest = wp.float32(NOTHING)
    beneath.ways = wp.static(WAYS)
    if tile.walls == 0 or radius == 0.0:
        beneath.ways = 1
    elif reach <= wp.static(NEAR[1]):
        x = (own[0] - tile.x) * tile.per_x
        z = (own[1] - tile.z) * tile.per_z
        s = wp.clamp(x, tile.low_x, tile.high_x)
        t = wp.clamp(z, tile.low_z, tile.high_z)
        beyond_x = tile.walls & ALONG_X != 0 and wp.abs(x - s) > reach * tile.per_x
        beyond_z = tile.walls & ALONG_Z != 0 and wp.abs(z - t) > reach * tile.per_z
        if beyond_x or beyond_z:
            beneath.ways = 1  # beyond the tile's edge it is as at the edge
        else:
            k = tile.first_crest + wp.min(int(t), tile.rows - 2) * tile.columns + wp.min(int(s), tile.columns - 2)
            crest = place.scale * model.contacts.terrain.crest[wp.where(reach > wp.static(NEAR[0]), 1, 0), k]
            incline = wp.sqrt(wp.max(1.0 - normal[1] * normal[1], 0.0)) / normal[1]
            over = (height + wp.dot(normal, arm)) / normal[1]
            if over > crest + (1.0 + 2.0 * incline) * reach:
                beneath.ways = 0
                return beneath
    beneath.rise = turned_rise(tile_surface(own[0], own[1], tile, model.contacts.terrain.height), place)
    if crest <= beneath.rise[0] + LEVEL:
        beneath.ways = 1
    return beneath


@func
def sphere_plane(
    instance: int, way: int, beneath: Beneath, normal: wp.vec3, height: float, arm: wp.vec3, point: wp.vec3,
    radius: float, margin: float, model: ModelRef,
) -> Footing:  # fmt: skip
    """The plane that a sphere touches below its middle, or in one of the directions that `tile_way` tells.

    Args:
        way: 0: below. beneath: see `ways_of`. normal, height, arm: as of `footing`. point: the middle, m, world.
        radius: m. margin: m, from where on contacts count before they touch.
    """
    if way > 0:
        return wall_beside(instance, way, normal, height, arm, point, radius + margin, model)
    moved = wp.vec3(0.0)
    if beneath.ways > 1:
        moved = foot_of_wall(instance, point, radius, model)
    if moved[0] == 0.0 and moved[2] == 0.0:
        return footing_near(instance, normal, height, arm, point, radius, beneath.rise, model)
    rise = rise_at(instance, point[0] + moved[0], point[2] + moved[2], model)
    plane = footing(normal, height, arm + moved, rise)
    if wp.abs(rise[1]) + wp.abs(rise[2]) > STEEP:
        plane.height = NOTHING
    return plane
