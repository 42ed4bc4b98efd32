"""Ground that is not flat: heights on a grid, bilinear between its points, over the plane of the ground.

A contact is with the plane that touches the ground below it. That is the ground itself where this is straight; what a
sphere of radius r has more than r n_y to its side is asked of walls alone, see `walls.py`. The plane of an incline goes
on above its edge, where there is no ground: what is clear of the ground at the foot of its perpendicular is told that.
What is deep in the ground is pushed out by the nearest of the planes about it.
"""

import warp as wp

from warpmuscle.kernels.contact.ground_plane import above_ground
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, at
from warpmuscle.kernels.terrain_structs import Patch, Terrain, Tile, TilePlace

ENDLESS_TOP = 1.0e30  # m, of tiles that rise without an end
DEEP = wp.constant(0.02)  # m below the ground, from where on it is asked which way out is the easiest
ABOUT = wp.constant(0.015)  # m from a point, and twice and three times that, the ground is then looked at
FLAT, RISES, PATCHED = 0, 1, 2  # what a step has compiled in: nothing, heights, other kinds of ground besides
WALLED = 4  # added to the last two: walls of tiles, see `walls.py`
BOUNDED = 8  # added to all of them: how high tiles get about a place, see `beneath.py`


def has_patches(terrain: int) -> bool:
    """Whether a step has patches of ground compiled in."""
    return terrain & PATCHED != 0


def has_walls(terrain: int) -> bool:
    """Whether a step has walls beside spheres compiled in."""
    return terrain & WALLED != 0


def has_bounds(terrain: int) -> bool:
    """Whether a step has bounds of the ground about bodies compiled in."""
    return terrain & BOUNDED != 0


@func
def wrapped(cells: float, period: float) -> float:
    """A place on an axis of a grid that comes again after a period, from 0 on; the place itself where it is 0."""
    if period > 0.0:
        return cells - period * wp.floor(cells / period)
    return cells


@func
def in_tile(x: float, z: float, place: TilePlace) -> wp.vec2:
    """A place of the world, m, in the axes of a tile that is turned to the left."""
    to_x = x - place.x
    to_z = z - place.z
    return wp.vec2(to_x * place.cosine - to_z * place.sine, to_x * place.sine + to_z * place.cosine)


@func
def bilinear(a: float, b: float, c: float, d: float, s: float, t: float) -> wp.vec3:
    """Height between four corners, and its derivatives along s and t.

    Args:
        a, b, c, d: at (s, t) = (0, 0), (1, 0), (0, 1), (1, 1).
    """
    low = a + s * (b - a)
    high = c + s * (d - c)
    return wp.vec3(low + t * (high - low), (b - a) + t * ((d - c) - (b - a)), high - low)


@func
def tile_surface(u: float, w: float, tile: Tile, height: wp.array[float]) -> wp.vec3:
    """Height of a tile, m, and how it grows along its axes, at a place in these, m."""
    x = wrapped((u - tile.x) * tile.per_x, tile.period_x)
    z = wrapped((w - tile.z) * tile.per_z, tile.period_z)
    s = wp.clamp(x, tile.low_x, tile.high_x)
    t = wp.clamp(z, tile.low_z, tile.high_z)
    i = wp.clamp(int(wp.floor(s)), 0, tile.columns - 2)
    j = wp.clamp(int(wp.floor(t)), 0, tile.rows - 2)
    k = tile.first + j * tile.columns + i
    m = k + tile.columns
    found = bilinear(height[k], height[k + 1], height[m], height[m + 1], s - float(i), t - float(j))
    along_x = wp.where(s == x, found[1] * tile.per_x, 0.0)
    along_z = wp.where(t == z, found[2] * tile.per_z, 0.0)
    return wp.vec3(found[0], along_x, along_z)


@func
def turned_rise(found: wp.vec3, place: TilePlace) -> wp.vec3:
    """What `tile_surface` has found, where the tile lies: m, and how it grows along x and z of the world."""
    along_x = found[1] * place.cosine + found[2] * place.sine
    along_z = found[2] * place.cosine - found[1] * place.sine
    return wp.vec3(found[0], along_x, along_z) * place.scale


@func
def tile_rise(x: float, z: float, place: TilePlace, terrain: Terrain) -> wp.vec3:
    """Height of a tile where it lies, m, and how it grows along x and z of the world, at a place of that, m."""
    own = in_tile(x, z, place)
    return turned_rise(tile_surface(own[0], own[1], terrain.tile[place.tile], terrain.height), place)


@func
def rise_at(instance: int, x: float, z: float, model: ModelRef) -> wp.vec3:
    """Height of the ground over its plane, m, and how it grows along x and z of the world, at a place."""
    return tile_rise(x, z, at(model.contacts.terrain.place, instance, 0), model.contacts.terrain)


@func
def above_terrain(instance: int, point: wp.vec3, model: ModelRef) -> float:
    """Distance of a point from the plane through the ground below it, m, as `above_ground` where it is flat."""
    rise = rise_at(instance, point[0], point[2], model)
    return above_ground(instance, point, model) - at(model.contacts.normal, instance, 0)[1] * rise[0]


@func
def above_surface(instance: int, point: wp.vec3, model: ModelRef) -> float:
    """The same on any ground, flat or not, for functions of users; m, negative below it."""
    if model.contacts.terrain.tile.shape[0] > 0:
        return above_terrain(instance, point, model)
    return above_ground(instance, point, model)


@wp.struct
class Footing:
    """The plane that touches the ground below a point."""

    normal: wp.vec3
    height: float  # m, of the body's joint above it


@func
def footing(normal: wp.vec3, height: float, arm: wp.vec3, rise: wp.vec3) -> Footing:
    """The plane that touches the ground below a point of a body; where the ground is level, to the last digit.

    Args:
        normal: of the ground's plane. height: of the body's joint above that, m. arm: from there to the point, m.
        rise: of the ground over the plane, see `rise_at`.
    """
    f = Footing()
    f.normal = normal
    f.height = height - normal[1] * rise[0]
    if rise[1] != 0.0 or rise[2] != 0.0:
        f.normal = wp.normalize(wp.vec3(normal[0] / normal[1] - rise[1], 1.0, normal[2] / normal[1] - rise[2]))
        over = (height + wp.dot(normal, arm)) / normal[1] - rise[0]
        f.height = f.normal[1] * over - wp.dot(f.normal, arm)
    return f


@func
def easiest_way_out(
    instance: int, normal: wp.vec3, height: float, arm: wp.vec3, point: wp.vec3, below: Footing, model: ModelRef
) -> Footing:
    """Of the planes that touch the ground below a point and about it, the one that it is least deep under.

    So what is pressed into a riser is pushed back, not thrown up by the stair.
    """
    found = below
    least = below.height + wp.dot(below.normal, arm)
    for number in range(12):
        step = ABOUT * float(1 + number / 4)
        to_x = wp.where(number % 4 == 0, step, wp.where(number % 4 == 1, -step, 0.0))
        to_z = wp.where(number % 4 == 2, step, wp.where(number % 4 == 3, -step, 0.0))
        beside = wp.vec3(to_x, 0.0, to_z)
        there = footing(normal, height, arm + beside, rise_at(instance, point[0] + to_x, point[2] + to_z, model))
        depth = there.height + wp.dot(there.normal, arm)
        if depth < 0.0 and depth > least:
            least = depth
            found = there
    return found


@func
def footing_near(
    instance: int, normal: wp.vec3, height: float, arm: wp.vec3, point: wp.vec3, radius: float, rise: wp.vec3,
    model: ModelRef,
) -> Footing:  # fmt: skip
    """That plane below the middle of a sphere; the one at its foot, where the sphere touches a plane but no ground.

    Args:
        normal, height, arm: as of `footing`. point: the middle, m, world. radius: m.
        rise: of the ground below the middle, see `rise_at`.
    """
    below = footing(normal, height, arm, rise)
    distance = below.height + wp.dot(below.normal, arm)
    if distance < -DEEP:
        return easiest_way_out(instance, normal, height, arm, point, below, model)
    if distance < radius and distance > radius * below.normal[1]:
        foot = point - below.normal * distance
        to_foot = arm - below.normal * distance
        there = footing(normal, height, to_foot, rise_at(instance, foot[0], foot[2], model))
        if there.height + wp.dot(there.normal, to_foot) > radius:
            return there
    return below


@func
def nearest_footing(
    instance: int, normal: wp.vec3, height: float, arm: wp.vec3, point: wp.vec3, radius: float, model: ModelRef
) -> Footing:
    """As `footing_near`, which asks for the ground itself."""
    rise = rise_at(instance, point[0], point[2], model)
    return footing_near(instance, normal, height, arm, point, radius, rise, model)


@func
def highest_about(instance: int, body: int, model: ModelRef, work: ScratchRef) -> float:
    """How far the ground rises over its plane, along the normal of that, where a body may touch it, m, at most.

    That is the highest that a tile gets anywhere; of a slope without an end, what it can rise to from below the joint.
    """
    place = at(model.contacts.terrain.place, instance, 0)
    top = place.top
    if top >= wp.static(ENDLESS_TOP):
        joint = work.position[body]
        below = rise_at(instance, joint[0], joint[2], model)
        top = below[0] + place.steepest * at(model.contacts.reach, instance, body)
    return at(model.contacts.normal, instance, 0)[1] * top


@func
def patch_at(u: float, w: float, first: int, end: int, patches: wp.array[Patch]) -> int:
    """Number of the last of some patches that a place of a tile lies in, -1 for none."""
    found = wp.int32(-1)
    for k in range(first, end):
        patch = patches[k]
        if u >= patch.low_x and u <= patch.high_x and w >= patch.low_z and w <= patch.high_z:
            found = k
    return found


@func
def patch_below(instance: int, point: wp.vec3, model: ModelRef) -> Patch:
    """What the ground is like below a point, m, world: as everywhere where there is no patch."""
    place = at(model.contacts.terrain.place, instance, 0)
    own = in_tile(point[0], point[2], place)
    tile = model.contacts.terrain.tile[place.tile]
    number = patch_at(own[0], own[1], tile.first_patch, tile.end_patch, model.contacts.terrain.patch)
    patch = Patch()
    patch.friction = 1.0e30
    patch.stiffness = 1.0
    patch.damping = 1.0
    if number >= 0:
        patch = model.contacts.terrain.patch[number]
    return patch
