"""Curves over the phase of a controller state."""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import Knot, at


@func
def hermite(before: float, start: float, end: float, after: float, s: float) -> float:
    """Cubic between two knots at s = 0..1 with Catmull-Rom tangents (p[k+1] - p[k-1])/2.

    As in the original program, tangents are not divided by the spacing of the knots.
    """
    s2 = s * s
    s3 = s2 * s
    tangents = 0.5 * (end - before) * (s3 - 2.0 * s2 + s) + 0.5 * (after - start) * (s3 - s2)
    return start * (2.0 * s3 - 3.0 * s2 + 1.0) + end * (3.0 * s2 - 2.0 * s3) + tangents


@func
def between_knots(knots: wp.array2d[Knot], instance: int, first: int, last: int, x: float) -> float:
    """The same between the first and the last knot."""
    k = int(first + 1)
    while x >= at(knots, instance, k).phase:
        k += 1
    left = at(knots, instance, k - 1)
    right = at(knots, instance, k)
    before = at(knots, instance, wp.max(k - 2, first)).value
    after = at(knots, instance, wp.min(k + 1, last)).value
    return hermite(before, left.value, right.value, after, (x - left.phase) / (right.phase - left.phase))


@func
def curve_value(knots: wp.array2d[Knot], instance: int, first: int, end: int, x: float) -> float:
    """Catmull-Rom curve through knots first..end-1 of an instance, constant beyond them, 0 without knots.

    Args:
        knots: (1 or instances, knots); phases increase within a curve.
        x: phase to evaluate at.
    """
    if end <= first:
        return 0.0
    last = end - 1
    left = at(knots, instance, first)
    ending = at(knots, instance, last)
    # Both are fetched in any case, so that one does not wait for the other.
    value = wp.where(x <= left.phase, left.value, ending.value)
    if x > left.phase and x < ending.phase:
        value = between_knots(knots, instance, first, last, x)
    return value
