"""The ground that is nearest to a ball, beside it as well as below: walls, edges of stairs, bumps smaller than it.

Where the ground about a ball is one plane, that is the plane below it. Else it is sought in eight directions where the
ground comes up to the ball's middle, or to an edge below that, and points of the ground about the nearest one are
tried, at less and less distance. The plane is that of the ground where the perpendicular from the ball's middle to it
ends on the ground, and at an edge the one across the way to the middle.
"""

import warp as wp

from warpmuscle.kernels.contact.terrain import Footing, footing, nearest_footing, rise_at
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef

ABOUT = wp.constant(8)  # directions in which walls and edges are sought
HALVES = wp.constant(17)  # of the way to them
TRIALS = wp.constant(48)  # points of the ground that are tried then
FIRST = wp.constant(0.1)  # radii, how far from the nearest point so far they are at first
CLOSER = wp.constant(0.7)  # that is so many times as far after each round of four
LEVEL = wp.constant(1.0e-4)  # radii by which ground is off a plane that is none of it


@func
def ground_point(normal: wp.vec3, height: float, arm: wp.vec3, beside: wp.vec3, rise: float) -> wp.vec3:
    """The way to the ground below a place beside a ball, from the ball's middle, m.

    Args:
        normal, height, arm: as of `footing`. beside: level way to the place, m. rise: of the ground there, m.
    """
    above = (height + wp.dot(normal, arm + beside)) / normal[1] - rise
    return beside - wp.vec3(0.0, above, 0.0)


@func
def direction_of(number: int) -> wp.vec3:
    """One of eight level directions, first along the axes and then between them."""
    angle = float(number % 4) * wp.static(wp.pi / 2.0) + float(number // 4 % 2) * wp.static(wp.pi / 4.0)
    return wp.vec3(wp.sin(angle), 0.0, wp.cos(angle))


@func
def rim(
    instance: int,
    normal: wp.vec3,
    height: float,
    arm: wp.vec3,
    point: wp.vec3,
    out: wp.vec3,
    top: float,
    model: ModelRef,
) -> wp.vec3:
    """The way to where the ground comes up to a height, or to the ball's middle, between that and a place.

    Args:
        out: level way to the place, m. top: height of the ground there, m, above the ball's middle.
    """
    level = wp.min(top, 0.0)
    near = wp.float32(0.0)
    far = wp.float32(1.0)
    found = wp.vec3(out[0], top, out[2])
    for _ in range(HALVES):
        middle = 0.5 * (near + far)
        there = rise_at(instance, point[0] + middle * out[0], point[2] + middle * out[2], model)
        way = ground_point(normal, height, arm, middle * out, there[0])
        if way[1] >= level:
            far = middle
            found = way
        else:
            near = middle
    return found


@func
def nearer(
    instance: int, normal: wp.vec3, height: float, arm: wp.vec3, point: wp.vec3, way: wp.vec3, model: ModelRef
) -> wp.vec3:
    """The way to the foot of the perpendicular to the plane of the ground at the end of a way, if it is shorter."""
    beside = wp.vec3(way[0], 0.0, way[2])
    here = rise_at(instance, point[0] + way[0], point[2] + way[2], model)
    plane = footing(normal, height, arm + beside, here)
    down = plane.normal * -(plane.height + wp.dot(plane.normal, arm))
    there = rise_at(instance, point[0] + down[0], point[2] + down[2], model)
    foot = ground_point(normal, height, arm, wp.vec3(down[0], 0.0, down[2]), there[0])
    if wp.length_sq(foot) < wp.length_sq(way):
        return foot
    return way


@func
def lies_on(
    instance: int,
    plane: Footing,
    normal: wp.vec3,
    height: float,
    arm: wp.vec3,
    point: wp.vec3,
    radius: float,
    model: ModelRef,
) -> bool:
    """Whether the foot of the perpendicular from a ball's middle to a plane is a point of the ground."""
    down = plane.normal * -(plane.height + wp.dot(plane.normal, arm))
    rise = rise_at(instance, point[0] + down[0], point[2] + down[2], model)
    above = (height + wp.dot(normal, arm + down)) / normal[1] - rise[0]
    return wp.abs(above) <= LEVEL * radius


@func
def nearest_ground(
    instance: int, normal: wp.vec3, height: float, arm: wp.vec3, point: wp.vec3, radius: float, model: ModelRef
) -> Footing:
    """The plane that a ball touches first, which the ball may be above.

    Args:
        normal, height, arm: as of `footing`. point: the middle, m, world. radius: m; of a point 0.
    """
    rise = rise_at(instance, point[0], point[2], model)
    below = footing(normal, height, arm, rise)
    above = below.height + wp.dot(below.normal, arm)
    if radius == 0.0 or above <= 0.0:
        return nearest_footing(instance, normal, height, arm, point, radius, model)
    nearest = ground_point(normal, height, arm, wp.vec3(0.0), rise[0])
    plain = wp.bool(True)
    for number in range(ABOUT):
        beside = direction_of(number) * radius
        there = rise_at(instance, point[0] + beside[0], point[2] + beside[2], model)
        way = ground_point(normal, height, arm, beside, there[0])
        off = above + wp.dot(below.normal, way)
        plain = plain and wp.abs(off) <= LEVEL * radius
        if off > LEVEL * radius:
            way = rim(instance, normal, height, arm, point, beside, way[1] - LEVEL * radius, model)
            way = nearer(instance, normal, height, arm, point, way, model)
        if wp.length_sq(way) < wp.length_sq(nearest):
            nearest = way
    if plain:
        return below
    straight = ground_point(normal, height, arm, wp.vec3(0.0), rise[0])
    straight = nearer(instance, normal, height, arm, point, straight, model)
    if wp.length_sq(straight) < wp.length_sq(nearest):
        nearest = straight
    step = FIRST * radius
    for number in range(TRIALS):
        beside = wp.vec3(nearest[0], 0.0, nearest[2]) + direction_of(number) * step
        there = rise_at(instance, point[0] + beside[0], point[2] + beside[2], model)
        way = ground_point(normal, height, arm, beside, there[0])
        if wp.length_sq(way) < wp.length_sq(nearest):
            nearest = way
        if number % 4 == 3:
            step = step * CLOSER
    at_nearest = rise_at(instance, point[0] + nearest[0], point[2] + nearest[2], model)
    beside = wp.vec3(nearest[0], 0.0, nearest[2])
    plane = footing(normal, height, arm + beside, at_nearest)
    if lies_on(instance, plane, normal, height, arm, point, radius, model):
        return plane
    edge = Footing()
    edge.normal = -wp.normalize(nearest)
    edge.height = wp.length(nearest) - wp.dot(edge.normal, arm)
    return edge
