"""Where OpenSim 4.6 has a path touch an ellipsoid (WrapEllipsoid): a search that may end at the other tangent.

It looks for a place r and a number d with which four things are 0: how far r is from the plane of the path, by how
much it misses the ellipsoid, and how far r and the end of the segment are from the tangent plane with offset d. Steps
are damped least squares (Levenberg and Marquardt); of a step that helps, ever more is taken while that helps.
"""

import warp as wp

from warpmuscle.kernels.functions import func

FOUND = 1.0e-8  # sum of squares of what is to be 0
LOST = 0.1  # the same where the search has found nothing
ON_IT = 1.0e-4  # by which the squared distance of an end on the unit sphere may differ from 1
STEPS, TRIES = 50, 100
DAMPING = 0.01  # at first
PART = 0.0625  # of a full step that is taken
STRAIGHT = 0.1  # cosine between the ways to the place and to the middle from which steps are shorter, ...
SHORTER = 100.0  # by 1 less this power of it


@func
def tangent_errors(x: wp.vec4, end: wp.vec3, square: wp.vec3, normal: wp.vec3, level: float) -> wp.vec4:
    """What is to be 0, for a place and a number d."""
    place = wp.vec3(x[0], x[1], x[2])
    out = wp.cw_div(place, square)
    on = wp.dot(place, out)
    return wp.vec4(wp.dot(normal, place) + level, on - 1.0, 2.0 * on + x[3], 2.0 * wp.dot(out, end) + x[3])


@func
def share_of_step(place: wp.vec3, end: wp.vec3) -> float:
    """How much of a step is taken: less, the more the place lies between the end and the middle."""
    cosine = wp.dot(wp.normalize(place - end), wp.normalize(-end))
    return wp.where(cosine > STRAIGHT, 1.0 - wp.pow(wp.max(cosine, STRAIGHT), SHORTER), 1.0)


@func(inline=False)
def tangent_as_opensim(
    end: wp.vec3, start: wp.vec3, radii: wp.vec3, normal: wp.vec3, through: wp.vec3, otherwise: wp.vec3
) -> wp.vec3:
    """The place that the search finds for an end of a segment, from a place on the ellipsoid on.

    Args:
        end, start: in the axes of the ellipsoid, in numbers with which its radii are 1 on average.
        normal, through: of the plane of the path, and a place in it. otherwise: the result where the search finds none.
    """
    square = wp.cw_mul(radii, radii)
    level = -wp.dot(normal, through)
    if wp.abs(wp.dot(end, wp.cw_div(end, square)) - 1.0) < ON_IT:
        return end
    x = wp.vec4(start[0], start[1], start[2], -2.0 * wp.dot(start, wp.cw_div(start, square)))
    missed = tangent_errors(x, end, square, normal, level)
    now = wp.dot(missed, missed)
    before = wp.float32(now)
    damping = wp.float32(DAMPING)
    for _ in range(STEPS):
        if now <= FOUND:
            break
        place = wp.vec3(x[0], x[1], x[2])
        out = wp.cw_div(place, square)
        far = wp.cw_div(end, square)
        slopes = wp.mat44(
            normal[0], 2.0 * out[0], 4.0 * out[0], 2.0 * far[0], normal[1], 2.0 * out[1], 4.0 * out[1], 2.0 * far[1],
            normal[2], 2.0 * out[2], 4.0 * out[2], 2.0 * far[2], 0.0, 0.0, 1.0, 1.0,
        )  # fmt: skip
        downward = slopes * missed
        squares = slopes * wp.transpose(slopes)
        part = -PART * share_of_step(place, end)
        step = wp.vec4(0.0)
        for _try in range(TRIES):
            if now < before:
                break
            damped = wp.mat44(squares)
            for k in range(4):
                damped[k, k] = squares[k, k] * (1.0 + damping)
            step = part * (wp.inverse(damped) * downward)
            x = x + step
            missed = tangent_errors(x, end, square, normal, level)
            before = now
            now = wp.dot(missed, missed)
            damping = 4.0 * damping
        damping = damping / 8.0
        more = wp.float32(0.5)
        for _more in range(TRIES):
            if now > before:
                break
            more = 2.0 * more
            x = x + step * more
            missed = tangent_errors(x, end, square, normal, level)
            before = now
            now = wp.dot(missed, missed)
        x = x - step * more
        missed = tangent_errors(x, end, square, normal, level)
        now = wp.dot(missed, missed)
        before = now
    if not (now <= LOST):  # nor where that is no number
        return otherwise
    return wp.vec3(x[0], x[1], x[2])
