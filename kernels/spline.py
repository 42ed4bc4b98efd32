"""Curves over the phase of a controller state."""

import warp as wp

from warpmuscle.kernels.structs import at


@wp.func
def hermite(before: float, start: float, end: float, after: float, s: float) -> float:
    """Cubic between two knots at s = 0..1 with Catmull-Rom tangents (p[k+1] - p[k-1])/2.

    As in the original program, tangents are not divided by the spacing of the knots.
    """
    s2 = s * s
    s3 = s2 * s
    tangents = 0.5 * (end - before) * (s3 - 2.0 * s2 + s) + 0.5 * (after - start) * (s3 - s2)
    return start * (2.0 * s3 - 3.0 * s2 + 1.0) + end * (3.0 * s2 - 2.0 * s3) + tangents


@wp.func
def curve_value(
    phase: wp.array2d[float], value: wp.array2d[float], instance: int, first: int, end: int, x: float
) -> float:
    """Catmull-Rom curve through knots first..end-1 of an instance, constant beyond them, 0 without knots.

    Args:
        phase, value: (1 or instances, knots); phases increase within a curve.
        x: phase to evaluate at.
    """
    if end <= first:
        return 0.0
    if x <= at(phase, instance, first):
        return at(value, instance, first)
    last = end - 1
    if x >= at(phase, instance, last):
        return at(value, instance, last)
    k = int(first + 1)
    while x >= at(phase, instance, k):
        k += 1
    left = at(phase, instance, k - 1)
    right = at(phase, instance, k)
    return hermite(
        at(value, instance, wp.max(k - 2, first)),
        at(value, instance, k - 1),
        at(value, instance, k),
        at(value, instance, wp.min(k + 1, last)),
        (x - left) / (right - left),
    )
