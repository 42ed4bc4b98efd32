"""Functions of a coordinate against NumPy's own evaluation in float64."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from warpmuscle.scene import Displacement
from warpmuscle.scene.joints.displacement import MANY, depends, held_beyond, pieces, rates

X = (1.0, 0.0, 0.0)


def evaluated(start: np.ndarray, c: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Value and slope (2, n) of cubic pieces (P, 4)."""
    piece = np.maximum(np.searchsorted(start, q, side="right") - 1, 0)
    t, own = q - start[piece], c[piece]
    slopes = own[:, 1] + 2.0 * own[:, 2] * t + 3.0 * own[:, 3] * t**2
    return np.stack([np.sum(own * t[:, None] ** np.arange(4), axis=1), slopes])


@pytest.mark.parametrize("coefficients", [[0.3], [0.1, -0.5, 0.2, 0.05], [0.01, 0.2, -0.3, 0.4, 0.1, -0.07, 0.02]])
def test_a_polynomial_is_met_within_its_span_and_its_derivatives_are_exact(coefficients):
    wave = Displacement(X, polynomial=coefficients)
    q = np.linspace(-2.0, 1.5, 999)
    start, c = pieces(wave, (-2.0, 1.5))
    power = np.polynomial.Polynomial(coefficients)
    found = evaluated(start, c[0], q)
    np.testing.assert_allclose(found[0], power(q), atol=1.5e-9)
    np.testing.assert_allclose(found[1], power.deriv()(q), atol=1e-6)
    for order, value in enumerate(rates(wave, q)):
        np.testing.assert_allclose(value, power.deriv(order)(q) if order else power(q), atol=1e-13)
    assert depends(wave) is (len(coefficients) > 1)


def test_linear_ends_mean_straight_lines_that_go_on_beyond_the_knots():
    x, y = [-1.0, 0.2, 1.0], [0.3, -0.1, 0.5]
    q = np.array([-0.7, 0.1, 0.9])
    value, first, second = rates(Displacement(X, x=x, y=y, ends="linear"), q)
    np.testing.assert_allclose(value, np.interp(q, x, y), atol=1e-15)
    np.testing.assert_allclose(first, [-1.0 / 3.0, -1.0 / 3.0, 0.75], atol=1e-15)
    np.testing.assert_array_equal(second, 0.0)
    outside = rates(Displacement(X, x=x, y=y, ends="linear"), np.array([-2.0, 3.0]))[0]
    np.testing.assert_allclose(outside, [0.3 + 1.0 / 3.0, 0.5 + 1.5], atol=1e-15)


def test_every_instance_may_have_its_own_coefficients():
    wave = Displacement(X, polynomial=[0.0, np.array([1.0, 2.0]), 0.0, 0.0, 0.5])
    q = np.array([0.3, 0.7])
    start, c = pieces(wave, (-1.0, 1.0))
    for row, slope in enumerate((1.0, 2.0)):
        np.testing.assert_allclose(evaluated(start, c[row], q)[0], slope * q + 0.5 * q**4, atol=1.5e-9)
    np.testing.assert_allclose(rates(wave, q)[0], [0.3 + 0.5 * 0.3**4, 1.4 + 0.5 * 0.7**4], atol=1e-15)


KNOTS = {"x": [-1.5, -0.5, 0.3, 1.2, 2.0], "y": [0.1, -0.2, 0.05, 0.4, 0.3]}
CURVES = [
    Displacement(X, value=0.2, slope=-0.7),
    Displacement(X, **KNOTS),
    Displacement(X, **KNOTS, ends="linear"),
    Displacement(X, polynomial=[0.1, -0.5, 0.2, 0.05]),
]


@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize(("low", "high"), [(-0.9, 1.1), (-0.5, 1.2), (-2.5, 3.0), (0.4, 0.5), (-1.5, -0.5)])
def test_what_is_held_beyond_a_range_is_the_function_of_the_clamped_coordinate(curve, low, high):
    q = np.linspace(-4.0, 4.0, 801)
    start, c = held_beyond(*pieces(curve), low, high)
    found, slope = evaluated(start, c[0], q)
    np.testing.assert_allclose(found, rates(curve, np.clip(q, low, high))[0], atol=1e-12)
    beyond = (q < low) | (q > high)
    np.testing.assert_allclose(slope[beyond], 0.0, atol=1e-15)
    inside = (q > low + 1e-6) & (q < high - 1e-6)
    np.testing.assert_allclose(slope[inside], rates(curve, q[inside])[1], atol=1e-11)


def test_a_spline_through_many_knots_is_scipys():
    x = np.sort(np.random.default_rng(1).uniform(-2.0, 2.0, 3 * MANY))
    y = np.sin(3.0 * x)
    at = np.linspace(x[0], x[-1], 501)
    found = rates(Displacement(X, x=x.tolist(), y=y.tolist(), ends="natural"), at)
    spline = CubicSpline(x, y, bc_type="natural")
    for order in range(3):
        np.testing.assert_allclose(found[order], spline(at, order), rtol=1e-8, atol=1e-8)


def test_pieces_that_a_caller_changes_are_as_they_were_for_the_next_one():
    spline = Displacement(X, x=[0.0, 1.0, 2.0, 4.0], y=[0.5, 0.1, 0.7, 0.2])
    start, c = pieces(spline)
    expected = start.copy(), c.copy()
    start += 1.0
    c *= 0.0
    for found, wanted in zip(pieces(spline), expected, strict=True):
        np.testing.assert_array_equal(found, wanted)
    other = Displacement(X, x=[0.0, 1.0, 2.0, 4.0], y=[0.5, 0.1, 0.7, 0.2], ends="linear")
    assert not np.array_equal(pieces(other)[1], expected[1])
