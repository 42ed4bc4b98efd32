"""Paths round cylinders and spheres as MuJoCo 4.0 has them (its documentation, "Spatial tendons").

In the plane across a cylinder, or through both ends of a segment and the middle of a sphere, the path goes round a
circle: the shorter way where the segment runs through it; with a side point outside, never behind the circle as seen
from there. A side point inside asks for a path inside the circle, which touches it in one point if the segment does
not come in by itself. Along a cylinder the path has one slope, and the cylinder has no ends.
"""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.path.wrap_cylinder import heights_unrolled, tangent
from warpmuscle.kernels.path.wrap_sphere import direction_across
from warpmuscle.kernels.path.wrap_touch import FREE, THROUGH, Touch

NEAR = 1.0e-9  # m^2, squared distances that are none
PARALLEL = 1.0e-7  # sine of the angle between both ends, as seen from the middle of a sphere
NO_SIDE, SIDED = 0, 1
HALVINGS = 22  # of the arc on which a path inside touches


@wp.struct
class CircleTouch:
    """How a segment meets a circle about the origin."""

    kind: int  # FREE or THROUGH
    first: wp.vec2  # m
    second: wp.vec2  # m
    arc: float  # m


@func
def cross2(a: wp.vec2, b: wp.vec2) -> float:
    """The one component of a product across."""
    return a[0] * b[1] - a[1] * b[0]


@func
def passes_behind(a: wp.vec2, b: wp.vec2, side: wp.vec2) -> bool:
    """Whether a segment crosses the ray from the origin that leads away from a side point."""
    of_a = cross2(a, side)
    of_b = cross2(b, side)
    if of_a * of_b >= 0.0:
        return False
    return wp.dot(a + (b - a) * (of_a / (of_a - of_b)), side) < 0.0


@func
def nearest_on_segment(a: wp.vec2, b: wp.vec2) -> wp.vec2:
    """The point of a segment that is nearest to the origin."""
    d = b - a
    return a + d * wp.clamp(-wp.dot(a, d) / wp.max(wp.dot(d, d), NEAR), 0.0, 1.0)


@func
def circle_outside(a: wp.vec2, b: wp.vec2, radius: float, sided: int, side: wp.vec2) -> CircleTouch:
    """Round the circle where the segment runs through it, or where it is on the far side of the side point."""
    t = CircleTouch()
    square = radius * radius
    d = b - a
    if wp.dot(a, a) < square or wp.dot(b, b) < square or wp.dot(d, d) < NEAR:
        return t
    near = nearest_on_segment(a, b)
    far = sided != NO_SIDE and passes_behind(a, b, side)
    if wp.dot(near, near) > square and not far:
        return t
    way = wp.where((cross2(a, b) < 0.0) != far, -1.0, 1.0)
    t.first = tangent(a, radius, way)
    t.second = tangent(b, radius, -way)
    turn = way * wp.atan2(cross2(t.first, t.second), wp.dot(t.first, t.second))
    t.arc = radius * wp.where(turn < 0.0, turn + 2.0 * wp.pi, turn)
    t.kind = THROUGH
    return t


@func
def reach_rate(p: float, radius: float, angle: float) -> float:
    """Rate by an angle of the distance from a point, so far from the middle, to one on the circle, m/rad."""
    cosine = wp.cos(angle)
    return p * radius * wp.sin(angle) / wp.sqrt(wp.max(p * p + radius * radius - 2.0 * p * radius * cosine, NEAR))


@func
def circle_inside(a: wp.vec2, b: wp.vec2, radius: float) -> CircleTouch:
    """Over the point of the circle that makes the path shortest, unless the segment comes inside by itself."""
    t = CircleTouch()
    near = nearest_on_segment(a, b)
    from_a = wp.length(a)
    from_b = wp.length(b)
    if wp.length(near) <= radius or from_a <= radius or from_b <= radius:
        return t
    angle = wp.atan2(wp.abs(cross2(a, b)), wp.dot(a, b))
    low = wp.float32(0.0)
    high = wp.float32(angle)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if reach_rate(from_a, radius, middle) < reach_rate(from_b, radius, angle - middle):
            low = middle
        else:
            high = middle
    turn = wp.where(cross2(a, b) < 0.0, -low, low)
    u = a * (radius / from_a)
    t.first = wp.vec2(wp.cos(turn) * u[0] - wp.sin(turn) * u[1], wp.sin(turn) * u[0] + wp.cos(turn) * u[1])
    t.second = t.first
    t.kind = THROUGH
    return t


@func
def circle_touch(a: wp.vec2, b: wp.vec2, radius: float, sided: int, side: wp.vec2, inside: bool) -> CircleTouch:
    """How a segment from a to b goes round or inside of a circle."""
    if inside:
        return circle_inside(a, b, radius)
    return circle_outside(a, b, radius, sided, side)


@func
def mujoco_cylinder_touch(a: wp.vec3, b: wp.vec3, radius: float, sided: int, side: wp.vec3) -> Touch:
    """How a segment from a to b, m, goes round a cylinder about z, or inside of it.

    Args:
        sided: NO_SIDE, or SIDED with a side point `side`, m.
    """
    inside = sided != NO_SIDE and wp.length(side) < radius
    flat = circle_touch(
        wp.vec2(a[0], a[1]), wp.vec2(b[0], b[1]), radius, sided, wp.vec2(side[0], side[1]), inside
    )  # fmt: skip
    touch = Touch()
    if flat.kind != FREE:
        heights = heights_unrolled(a, b, flat.first, flat.second, flat.arc)
        rise = heights[1] - heights[0]
        touch.kind = THROUGH
        touch.first = wp.vec3(flat.first[0], flat.first[1], heights[0])
        touch.second = wp.vec3(flat.second[0], flat.second[1], heights[1])
        touch.arc = wp.sqrt(flat.arc * flat.arc + rise * rise)
    return touch


@func
def mujoco_sphere_touch(a: wp.vec3, b: wp.vec3, radius: float, sided: int, side: wp.vec3) -> Touch:
    """The same of a sphere, see `mujoco_cylinder_touch`."""
    inside = sided != NO_SIDE and wp.length(side) < radius
    x = wp.normalize(a)
    normal = wp.cross(x, wp.normalize(b))
    if wp.length(normal) < PARALLEL:
        normal = direction_across(a)
    y = wp.cross(wp.normalize(normal), x)
    flat = circle_touch(
        wp.vec2(wp.dot(a, x), wp.dot(a, y)), wp.vec2(wp.dot(b, x), wp.dot(b, y)), radius, sided,
        wp.vec2(wp.dot(side, x), wp.dot(side, y)), inside,
    )  # fmt: skip
    touch = Touch()
    if flat.kind != FREE:
        touch.kind = THROUGH
        touch.first = x * flat.first[0] + y * flat.first[1]
        touch.second = x * flat.second[0] + y * flat.second[1]
        touch.arc = flat.arc
    return touch
