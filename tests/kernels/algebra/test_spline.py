"""Curves over the phase against the formula written out."""

import numpy as np
import pytest
import simbicon_oracle as oracle
import warp as wp
from probes import evaluate

from warpmuscle.core.arrays import structs_to_device
from warpmuscle.kernels.algebra.spline import curve_value, hermite
from warpmuscle.kernels.structs import Knot


@wp.kernel(enable_backward=False)
def values_of(knots: wp.array2d[Knot], first: int, end: int, x: wp.array[float], y: wp.array2d[float]):
    i, k = wp.tid()
    y[i, k] = curve_value(knots, i, first, end, x[k])


def curve(phase, value, first: int, end: int, x, instances: int = 1) -> np.ndarray:
    """Values (instances, n) of knots first..end-1 at n phases."""
    knots = structs_to_device(Knot, {"phase": np.atleast_2d(phase), "value": np.atleast_2d(value)}, "cpu")
    at = wp.array(x, dtype=float, device="cpu")
    out = wp.zeros((instances, len(x)), dtype=float, device="cpu")
    wp.launch(values_of, dim=out.shape, inputs=[knots, first, end, at], outputs=[out], device="cpu")
    return out.numpy()


X = np.linspace(-0.3, 1.3, 161)


@pytest.mark.parametrize("knots", [1, 2, 3, 7])
def test_curve_through_uneven_knots_follows_the_formula(knots: int):
    rng = np.random.default_rng(knots)
    phase, value = np.sort(rng.random(knots)), rng.normal(size=knots)
    around = [9.0, *phase, -5.0], [7.0, *value, 8.0]  # knots of other curves on both sides
    expected = [oracle.curve(list(phase), list(value), x) for x in X]
    np.testing.assert_allclose(curve(*around, 1, knots + 1, X)[0], expected, atol=2e-5)


def test_curve_without_knots_is_zero():
    assert np.all(curve([0.5], [3.0], 1, 1, X) == 0.0)


def test_curve_goes_through_its_knots_and_stays_constant_beyond_them():
    phase, value = [0.1, 0.35, 0.4, 0.9], [1.0, -2.0, 0.5, 3.0]
    at = [-1.0, *phase, 2.0]
    np.testing.assert_allclose(curve(phase, value, 0, 4, at)[0], [1.0, *value, 3.0], atol=1e-6)


def test_evenly_spaced_knots_on_a_line_give_the_line_between_inner_knots():
    phase = np.linspace(0.0, 1.0, 6)
    x = np.linspace(0.2, 0.8, 50)
    np.testing.assert_allclose(curve(phase, 2.0 * phase - 1.0, 0, 6, x)[0], 2.0 * x - 1.0, atol=1e-6)


def test_instances_may_have_knots_of_their_own():
    values = np.array([[0.0, 1.0, 0.0], [2.0, 5.0, -1.0]])
    both = curve([0.0, 0.5, 1.0], values, 0, 3, X, instances=2)
    for row in (0, 1):
        assert np.array_equal(both[row], curve([0.0, 0.5, 1.0], values[row], 0, 3, X)[0])


def test_hermite_has_the_ends_as_values_and_half_differences_as_slopes():
    before, start, end, after = np.random.default_rng(0).normal(size=(4, 50))
    step = 1e-2
    for s, value, slope in ((0.0, start, 0.5 * (end - before)), (1.0, end, 0.5 * (after - start))):
        np.testing.assert_allclose(evaluate(hermite, before, start, end, after, s), value, atol=1e-6)
        high, low = (evaluate(hermite, before, start, end, after, s + d) for d in (step, -step))
        np.testing.assert_allclose((high - low) / (2.0 * step), slope, atol=5e-3)
