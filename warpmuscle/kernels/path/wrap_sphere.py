"""Paths round a sphere, along great circles, with side and contact as OpenSim 4.6 has them (WrapSphere)."""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.path.wrap_touch import BESIDE, FREE, INSIDE, Touch, allowed, kept_size, larger, on_side

STRAIGHT = 1.0e-5  # sine of the angle below which both ends lie opposite each other
REACH = 1.0  # m, from the first end to the middle of the sphere; OpenSim takes no segment beyond it as running through


@func
def sphere_tangent(p: wp.vec3, normal: wp.vec3, radius: float, way: float) -> wp.vec3:
    """Where the tangent from a point outside touches the sphere in a plane through its middle; way 1 or -1."""
    square = wp.dot(p, p)
    leg = way * wp.sqrt(wp.max(square - radius * radius, 0.0))
    return (p * radius + wp.cross(normal, p) * leg) * (radius / square)


@func
def direction_across(v: wp.vec3) -> wp.vec3:
    """A unit vector at right angles to a vector."""
    s = wp.abs(v)
    other = wp.vec3(1.0, 0.0, 0.0)
    if s[1] < s[0] and s[1] <= s[2]:
        other = wp.vec3(0.0, 1.0, 0.0)
    elif s[2] < s[0]:
        other = wp.vec3(0.0, 0.0, 1.0)
    return wp.normalize(wp.cross(v, other))


@func
def sphere_touch(a: wp.vec3, b: wp.vec3, radius: float, axis: int, side: int) -> Touch:
    """How a segment from a to b, m, goes round a sphere.

    Args:
        axis, side: the half that a path must stay on: the axis, and 1 or -1; side 0: both. Only where the straight
            segment would run through the sphere does the path touch it.
    """
    touch = Touch()
    square = radius * radius
    if wp.dot(a, a) < square or wp.dot(b, b) < square:
        touch.kind = INSIDE
        return touch
    d = b - a
    span = wp.max(wp.dot(d, d), 1.0e-12)
    t = -wp.dot(a, d) / span
    near = a + d * t
    depth = square - wp.dot(near, near)
    if depth < 0.0 or wp.abs(t - 0.5) + wp.sqrt(wp.max(depth, 0.0) / span) >= 0.5:
        return touch
    kind = BESIDE
    if side != 0:
        reached = t * wp.sqrt(span) < REACH
        kind = allowed(a[axis], b[axis], near[axis], side, reached)
        if kind == FREE:
            return touch
    normal = wp.cross(a, b)
    size = wp.length(normal)
    normal = normal / wp.max(size, 1.0e-30)
    if size < STRAIGHT * wp.length(a) * wp.length(b):
        normal = direction_across(a)
    a_on = sphere_tangent(a, normal, radius, 1.0)
    a_back = sphere_tangent(a, normal, radius, -1.0)
    b_on = sphere_tangent(b, normal, radius, 1.0)
    b_back = sphere_tangent(b, normal, radius, -1.0)
    pair = larger(wp.dot(a_on, b_on), wp.dot(a_on, b_back), wp.dot(a_back, b_on), wp.dot(a_back, b_back))
    on_a = pair < 2
    on_b = pair == 0 or pair == 2
    far = wp.bool(False)
    if side != 0 and (not on_side(a[axis], side) or not on_side(b[axis], side)):
        middle = a + b
        on_a = wp.dot(a_on - a_back, middle) < 0.0
        on_b = wp.dot(b_on - b_back, middle) < 0.0
        out = wp.where(on_a, a_on, a_back) - a + wp.where(on_b, b_on, b_back) - b
        if out[axis] * float(side) < 0.0:
            on_a = not on_a
            on_b = not on_b
        first = wp.where(on_a, a_on, a_back)
        second = wp.where(on_b, b_on, b_back)
        far = wp.dot(first + second, first - a + second - b) < 0.0
    touch.kind = kind
    touch.first = wp.where(on_a, a_on, a_back)
    touch.second = wp.where(on_b, b_on, b_back)
    angle = wp.atan2(wp.length(wp.cross(touch.first, touch.second)), wp.dot(touch.first, touch.second))
    touch.arc = radius * wp.where(far, 2.0 * wp.pi - angle, angle)
    return touch


@func
def smooth_sphere_touch(a: wp.vec3, b: wp.vec3, radius: float, axis: int, side: int) -> Touch:
    """`sphere_touch`, of a sphere off which no path jumps as one of its ends goes inside."""
    near = wp.sqrt(wp.min(wp.dot(a, a), wp.dot(b, b))) / radius
    return sphere_touch(a, b, radius * kept_size(near), axis, side)
