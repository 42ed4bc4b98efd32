"""Corners of Millard's curves: quintic Bezier curves, by de Casteljau's construction."""

from itertools import pairwise

import numpy as np
import pytest

from warpmuscle.kernels.curve import millard


def constructed(start: tuple, end: tuple, curviness: float, u: float) -> np.ndarray:
    """The place at u by repeated linear interpolation between control points.

    The inner ones lie, two each, at 0.1 + 0.8 c of the way to where the tangents of the ends meet (Millard 2013).
    """
    (x0, y0, slope0), (x1, y1, slope1) = start, end
    tangents = np.array([[slope0, -1.0], [slope1, -1.0]])
    meeting = np.linalg.solve(tangents, [slope0 * x0 - y0, slope1 * x1 - y1])
    first, last, part = np.array([x0, y0]), np.array([x1, y1]), 0.1 + 0.8 * curviness
    low, high = (1.0 - part) * first + part * meeting, (1.0 - part) * last + part * meeting
    points = [first, low, low, high, high, last]
    while len(points) > 1:
        points = [(1.0 - u) * a + u * b for a, b in pairwise(points)]
    return points[0]


@pytest.mark.parametrize("curviness", [0.0, 0.5, 0.9, 1.0])
def test_corners_are_bezier_curves_through_their_knots_with_the_slopes_of_these(curviness: float):
    start, end, u = (0.2, 0.1, 0.3), (1.4, 1.0, 2.0), np.linspace(0.0, 1.0, 41)
    x, y, slope = millard.corner(start, end, curviness, millard.quintic(u))
    expected = np.array([constructed(start, end, curviness, one) for one in u])
    np.testing.assert_allclose(np.stack([x, y], axis=1), expected, atol=1e-12)
    assert (slope[0], slope[-1]) == pytest.approx((0.3, 2.0))
    steps = np.linspace(0.0, 1.0, 20001)
    fine_x, fine_y, _ = millard.corner(start, end, curviness, millard.quintic(steps))
    np.testing.assert_allclose(np.gradient(fine_y, fine_x)[500:-500:500], slope[1:-1], rtol=1e-5)


def test_curves_are_their_corners_one_after_the_other():
    knots = [(0.0, 0.0, 0.0), (0.5, 0.2, 1.0), (1.2, 1.0, 1.5)]
    corners = zip(knots, knots[1:], (0.5, 0.8), strict=False)
    x, y = np.array([constructed(*corner, u) for corner in corners for u in (0.2, 0.6, 0.9)]).T
    value, _ = millard.sampled(knots, [0.5, 0.8], x)
    np.testing.assert_allclose(value, y, atol=1e-6)


def test_published_points_of_the_active_curve():
    """No force at 0.4441 and 1.8123 optimal lengths, all of it at 1 (Millard 2013, table 1); all values lie between."""
    knots, curviness, _ = millard.CURVES["active"]
    value, _ = millard.sampled(knots, curviness, np.array([0.4441, 1.0, 1.8123]))
    np.testing.assert_allclose(value, [0.0, 1.0, 0.0], atol=1e-6)
