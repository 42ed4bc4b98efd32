"""Arcs of paths on an ellipsoid: exact, and as OpenSim adds them up in pieces."""

import warp as wp

from warpmuscle.kernels.functions import func

PIECE, MOST_PIECES = 1.0e-3, 499  # m, of OpenSim's arcs
LEAST_TURN = 1.0e-3  # rad, which counts as none
SMALLEST = 1.0e-12


@func
def most_along(d: wp.vec3) -> int:
    """The axis that is most along a direction."""
    x = wp.abs(d[0])
    y = wp.abs(d[1])
    z = wp.abs(d[2])
    return wp.where(y > x, wp.where(z > y, 2, 1), wp.where(z > x, 2, 0))


@func
def gauss_place(k: int) -> wp.vec2:
    """Place k of Gauss's rule of 5 points on -1..1, and its weight."""
    near = wp.where(k == 1 or k == 3, 0.5384693101, 0.9061798459)
    x = wp.where(k == 2, 0.0, wp.where(k < 2, -near, near))
    weight = wp.where(k == 2, 0.5688888889, wp.where(k == 1 or k == 3, 0.4786286705, 0.2369268851))
    return wp.vec2(x, weight)


@func
def arc_on_ellipsoid(u: wp.vec3, v: wp.vec3, angle: float, r: wp.vec3) -> float:
    """Length of the arc u cos t + v sin t, t from 0 to an angle, stretched by radii; by Gauss's rule of 5 points."""
    total = wp.float32(0.0)
    for k in range(5):
        own = gauss_place(k)
        t = 0.5 * angle * (1.0 + own[0])
        total += own[1] * wp.length(wp.cw_mul(r, v * wp.cos(t) - u * wp.sin(t)))
    return 0.5 * angle * total


@func
def arc_in_pieces(u: wp.vec3, v: wp.vec3, angle: float, middle: wp.vec3, normal: wp.vec3, r: wp.vec3, n: int) -> float:
    """The same arc about a middle as n chords, which turn by equal angles about where an axis meets its plane.

    Of a curve with the curvature k, chords of the length x are shorter by the integral of k^2 x^2/24; round a circle
    they are sin y/y as long as it, with y half of what they turn by, which is taken for this.

    Args:
        normal: of the plane of the arc, where the ellipsoid is a unit sphere.
    """
    across = wp.cw_div(normal, r)
    axis = most_along(across)
    center = wp.cw_mul(r, middle)
    center[axis] = center[axis] - wp.dot(normal, middle) / across[axis]
    a = wp.cw_mul(r, u)
    b = wp.cw_mul(r, v)
    area = wp.length(wp.cross(a, b))
    total = wp.float32(0.0)
    turned = wp.float32(0.0)
    lost = wp.float32(0.0)
    for k in range(5):
        own = gauss_place(k)
        t = 0.5 * angle * (1.0 + own[0])
        along = b * wp.cos(t) - a * wp.sin(t)
        away = center + a * wp.cos(t) + b * wp.sin(t)
        speed = wp.length(along)
        turn = wp.length(wp.cross(along, away)) / wp.max(wp.dot(away, away), SMALLEST)
        bent = area / wp.max(speed * turn, SMALLEST)
        total += own[1] * speed
        turned += own[1] * turn
        lost += own[1] * bent * bent / wp.max(speed, SMALLEST)
    step = 0.5 * angle * turned / float(n)
    y = step * wp.sqrt(0.25 * lost / wp.max(total, SMALLEST))
    return 0.5 * angle * total * wp.where(y > LEAST_TURN, wp.sin(y) / y, 1.0)


@func(inline=False)
def arc_as_opensim(
    p: wp.vec3, q: wp.vec3, c: wp.vec3, first: wp.vec3, second: wp.vec3, radii: wp.vec3, side: int
) -> float:
    """Length of the arc of a path between two places, which is the long way round if the short one leads back.

    Args:
        p, q, c, first, second: ends of the segment, a place in the plane of the path, and where it touches, in the axes
            where the ellipsoid is a unit sphere. radii: m. side: 0 if the short way counts at all events.
    """
    chord = wp.length(wp.cw_mul(radii, second - first))
    if chord < PIECE:
        return chord
    normal = wp.normalize(wp.cross(q - p, c - p))
    middle = normal * wp.dot(normal, c)
    u = first - middle
    w = second - middle
    v = wp.cross(normal, u)
    if wp.dot(v, w) < 0.0:
        v = -v
    angle = wp.atan2(wp.dot(w, v), wp.dot(w, u))
    onward = wp.cw_mul(radii, v)
    backward = wp.cw_mul(radii, u * wp.sin(angle) - v * wp.cos(angle))
    back = wp.dot(onward, wp.cw_mul(radii, p - first)) > 0.0 or wp.dot(backward, wp.cw_mul(radii, q - second)) > 0.0
    if side != 0 and chord >= 2.0 * PIECE and back:
        v = -v
        angle = 2.0 * wp.pi - angle
    pieces = wp.min(int(chord / PIECE), MOST_PIECES)
    return arc_in_pieces(u, v, angle, middle, normal, radii, pieces)
