"""Where a capsule is nearest to a box: of a capsule's segment and a box the nearest points, and what lies between them.

A ball is a box without edges about which a sphere is swept, a capsule one with edges along one axis.
"""

import warp as wp

from warpmuscle.kernels.functions import func

HALVINGS = 14  # of the segment, before a straight line finds the rest of the way
LEVEL = 1.0e-3  # slope of the distance along the segment that counts as none: there it is as near everywhere
TINY = 1.0e-6  # m, distance at which a segment is inside
PARTS = 5  # points along each edge of a box, corners among them
ALONG = 25  # of the same along a capsule


@func
def beyond(point: wp.vec3, half: wp.vec3) -> wp.vec3:
    """The way to a point from the nearest point of a box about the origin, m; 0 inside."""
    return point - wp.vec3(
        wp.clamp(point[0], -half[0], half[0]),
        wp.clamp(point[1], -half[1], half[1]),
        wp.clamp(point[2], -half[2], half[2]),
    )


@func
def slope_along(middle: wp.vec3, along: wp.vec3, t: float, half: wp.vec3) -> float:
    """How the distance of a point of a segment from a box grows along the segment, m per m."""
    away = beyond(middle + along * t, half)
    return wp.dot(along, away) / wp.max(wp.length(away) * wp.length(along), 1.0e-12)


@func
def end_of_nearest(middle: wp.vec3, along: wp.vec3, half: wp.vec3, level: float) -> float:
    """The place on a segment, -1 to 1, from which on its distance from a box grows by more than `level`.

    The distance is convex along the segment, so that its slope only grows.
    """
    low = wp.float32(-1.0)
    high = wp.float32(1.0)
    at_low = slope_along(middle, along, low, half) - level
    at_high = slope_along(middle, along, high, half) - level
    if at_low >= 0.0:
        return -1.0
    if at_high <= 0.0:
        return 1.0
    for _ in range(HALVINGS):
        t = 0.5 * (low + high)
        value = slope_along(middle, along, t, half) - level
        if value > 0.0:
            high = t
            at_high = value
        else:
            low = t
            at_low = value
    return low + (high - low) * at_low / (at_low - at_high)


@func
def nearest_on_segment(middle: wp.vec3, along: wp.vec3, half: wp.vec3) -> float:
    """The place on a segment, -1 to 1, that is nearest to a box; where a part of it is as near, the middle of that.

    Args:
        middle: of the segment, m, in the axes of the box from its middle. along: from there to its end.
        half: half edges of the box, m.
    """
    if wp.length_sq(along) == 0.0:
        return 0.0
    first = end_of_nearest(middle, along, half, -LEVEL)
    last = end_of_nearest(middle, along, half, LEVEL)
    return 0.5 * (first + last)


@wp.struct
class Between:
    """What lies between a box and a point."""

    on_box: wp.vec3  # m, the nearest point of the box
    normal: wp.vec3  # unit vector from there to the point; inside, to the nearest face
    distance: float  # m, negative inside


@func
def between(point: wp.vec3, half: wp.vec3) -> Between:
    """From a box about the origin to a point, m."""
    b = Between()
    away = beyond(point, half)
    b.distance = wp.length(away)
    b.on_box = point - away
    if b.distance > TINY:
        b.normal = away / b.distance
        return b
    depth = half - wp.vec3(wp.abs(point[0]), wp.abs(point[1]), wp.abs(point[2]))
    axis = wp.where(depth[0] <= depth[1], 0, 1)
    axis = wp.where(depth[2] < depth[axis], 2, axis)
    normal = wp.vec3(0.0)
    normal[axis] = wp.where(point[axis] < 0.0, -1.0, 1.0)
    b.normal = normal
    b.distance = -depth[axis]
    return b


@func
def between_on(point: wp.vec3, half: wp.vec3, face: wp.vec3) -> Between:
    """The same where a point inside lies below a given face, m.

    Args:
        face: unit vector from the middle of the box to the middle of the face.
    """
    b = between(point, half)
    if wp.length(beyond(point, half)) <= TINY:
        b.distance = wp.dot(face, point) - wp.dot(wp.vec3(wp.abs(face[0]), wp.abs(face[1]), wp.abs(face[2])), half)
        b.normal = face
        b.on_box = point - face * b.distance
    return b


@func
def least_overlap(middle: wp.vec3, reach: wp.vec3, half: wp.vec3) -> wp.vec3:
    """The way from the middle of a box about the origin to the face out of which another object has least far to go.

    The nearest face to a single point tells less: a corner near an edge is as near to the side, where nothing holds it.

    Args:
        middle: of the other object, m. reach: how far that goes from its middle along the axes of the box, m.
    """
    overlap = half + reach - wp.vec3(wp.abs(middle[0]), wp.abs(middle[1]), wp.abs(middle[2]))
    axis = wp.where(overlap[0] < overlap[1], 0, 1)
    axis = wp.where(overlap[2] < overlap[axis], 2, axis)
    face = wp.vec3(0.0)
    face[axis] = wp.where(middle[axis] < 0.0, -1.0, 1.0)
    return face


@func
def corner(number: int, half: wp.vec3) -> wp.vec3:
    """One of the eight corners of a box, m."""
    x = wp.where(number % 2 == 0, half[0], -half[0])
    y = wp.where(number // 2 % 2 == 0, half[1], -half[1])
    z = wp.where(number // 4 == 0, half[2], -half[2])
    return wp.vec3(x, y, z)


@func
def is_another(number: int, half: wp.vec3) -> bool:
    """Whether a corner lies where none of lower number does."""
    again = number % 2 == 1 and half[0] == 0.0
    again = again or (number // 2 % 2 == 1 and half[1] == 0.0)
    return not (again or (number // 4 == 1 and half[2] == 0.0))


@func
def part_of(number: int, half: wp.vec3) -> wp.vec3:
    """One of the points that part a box, or a capsule along y, evenly, corners among them, m; there are 125."""
    if half[0] == 0.0 and half[2] == 0.0:
        return wp.vec3(0.0, half[1] * (1.0 - float(number) * wp.static(2.0 / (ALONG - 1.0))), 0.0)
    per_part = wp.static(2.0 / (PARTS - 1.0))
    x = 1.0 - per_part * float(number % PARTS)
    y = 1.0 - per_part * float(number // PARTS % PARTS)
    z = 1.0 - per_part * float(number // (PARTS * PARTS))
    return wp.vec3(x * half[0], y * half[1], z * half[2])


@func
def is_between(number: int, half: wp.vec3) -> bool:
    """Whether such a point lies on an edge or a face between the corners."""
    if half[0] == 0.0 and half[2] == 0.0:
        return half[1] > 0.0 and number > 0 and number < ALONG - 1
    ends = wp.int32(0)
    place = wp.vec3i(number % PARTS, number // PARTS % PARTS, number // (PARTS * PARTS))
    for axis in range(3):
        if place[axis] == 0 or place[axis] == PARTS - 1:
            ends += 1
    return ends == 1 or ends == 2


@func
def edge_middle(number: int, half: wp.vec3) -> wp.vec3:
    """The middle of one of the twelve edges of a box, m; edges 0 to 3 lie along x, 4 to 7 along y, 8 to 11 along z."""
    axis = number // 4
    first = wp.where(number % 2 == 0, 1.0, -1.0)
    second = wp.where(number // 2 % 2 == 0, 1.0, -1.0)
    middle = wp.vec3(0.0)
    middle[(axis + 1) % 3] = first * half[(axis + 1) % 3]
    middle[(axis + 2) % 3] = second * half[(axis + 2) % 3]
    return middle


@func
def within(middle: wp.vec3, along: wp.vec3, half: wp.vec3) -> wp.vec2:
    """Places on a segment, -1 to 1, between which it is inside a box about the origin; in reverse where it never is."""
    first = wp.float32(-1.0)
    last = wp.float32(1.0)
    for axis in range(3):
        if wp.abs(along[axis]) < TINY:
            if wp.abs(middle[axis]) >= half[axis]:
                last = -2.0
        else:
            low = (-half[axis] - middle[axis]) / along[axis]
            high = (half[axis] - middle[axis]) / along[axis]
            first = wp.max(first, wp.min(low, high))
            last = wp.min(last, wp.max(low, high))
    return wp.vec2(first, last)
