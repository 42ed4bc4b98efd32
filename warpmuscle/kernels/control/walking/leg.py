"""A leg of two segments whose ankle is to come to a place: its knee, and how its thigh lies (Coros 2010, 4.1)."""

import warp as wp

from warpmuscle.kernels.functions import func


@func
def knee_angle(distance: float, thigh: wp.vec3, shank: wp.vec3, axis: wp.vec3, sense: float) -> float:
    """Angle of a knee about its axis at which the ankle is so far from the hip, rad; the nearest one if there is none.

    Args:
        thigh, shank: from hip to knee and from knee to ankle at angle 0, m. sense: 1 or -1, of flexion.
    """
    a = wp.length(thigh)
    b = wp.length(shank)
    bend = wp.clamp((distance * distance - a * a - b * b) / (2.0 * a * b), -1.0, 1.0)
    at_zero = wp.atan2(wp.dot(axis, wp.cross(thigh, shank)), wp.dot(thigh, shank))
    return sense * wp.acos(bend) - at_zero


@func
def axes_along(first: wp.vec3, second: wp.vec3) -> wp.mat33:
    """Three axes as columns: one direction, what of another one is across it, and what is across both."""
    x = wp.normalize(first)
    y = wp.normalize(second - x * wp.dot(x, second))
    z = wp.cross(x, y)
    return wp.matrix_from_cols(x, y, z)


@func
def thigh_rotation(to_ankle: wp.vec3, knee_axis: wp.vec3, own_to_ankle: wp.vec3, own_axis: wp.vec3) -> wp.mat33:
    """Rotation of a thigh from its own axes to the world that points the leg to a place, its knee along an axis.

    Args:
        to_ankle, knee_axis: wanted, world. own_to_ankle, own_axis: the same in the thigh, at the knee's angle.
    """
    return axes_along(to_ankle, knee_axis) * wp.transpose(axes_along(own_to_ankle, own_axis))


@func
def turned(v: wp.vec3, axis: wp.vec3, angle: float) -> wp.vec3:
    """A vector turned about a unit axis (Rodrigues)."""
    s = wp.sin(angle)
    c = wp.cos(angle)
    return v * c + wp.cross(axis, v) * s + axis * (wp.dot(axis, v) * (1.0 - c))


@func
def reaching_length(to_foothold: wp.vec3, to_foot: wp.vec3, reach: float) -> float:
    """How long the leg that stands may be, from hip to ankle, that the other one comes down to its foothold, m.

    Args:
        to_foothold, to_foot: from the hip to where the ankles are to be, and are, m, world.
        reach: m, of a leg that swings.
    """
    across = to_foothold[0] * to_foothold[0] + to_foothold[2] * to_foothold[2]
    too_high = wp.max(-to_foothold[1] - wp.sqrt(wp.max(reach * reach - across, 0.25 * reach * reach)), 0.0)
    return wp.length(to_foot + wp.vec3(0.0, too_high, 0.0))
