"""Levenberg-Marquardt for many fits that share parameters, against scipy's least squares and closed forms."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from warpmuscle.throw.least_squares import Prior, Unknowns, fit

TIME = np.linspace(0.0, 2.0, 40)


def unknowns(start, low, high, **more) -> Unknowns:
    start = np.array(start, dtype=float)
    size = start.shape[-1]
    return Unknowns(start, np.full(size, low), np.full(size, high), 1e-6, **more)


def decays(which, individual, shared):
    """a exp(-k t) + b with a and b of every fit, k shared, against a known one."""
    known = np.array([[1.0, 0.2], [2.0, -0.3], [0.5, 0.0]])[which]
    model = individual[:, :1] * np.exp(-shared[:, :1] * TIME) + individual[:, 1:]
    return model - (known[:, :1] * np.exp(-1.7 * TIME) + known[:, 1:])


@pytest.mark.parametrize("damping", [1e-3, 10.0])
def test_own_and_shared_unknowns_are_found_together(damping: float):
    result = fit(
        decays, unknowns(np.ones((3, 2)), -5.0, 5.0), unknowns([0.5], 0.0, 9.0), damping=damping, iterations=60
    )
    np.testing.assert_allclose(result.shared, 1.7, rtol=1e-4)
    np.testing.assert_allclose(result.individual, [[1.0, 0.2], [2.0, -0.3], [0.5, 0.0]], atol=1e-3)


def test_only_shared_or_only_own_unknowns_may_be_free():
    right = np.array([[1.0, 0.2], [2.0, -0.3], [0.5, 0.0]])
    result = fit(decays, unknowns(right, -5.0, 5.0, free=False), unknowns([0.5], 0.0, 9.0), iterations=40)
    np.testing.assert_allclose(result.shared, 1.7, rtol=1e-5)
    assert np.array_equal(result.individual, right)
    result = fit(decays, unknowns(np.ones((3, 2)), -5.0, 5.0), unknowns([1.7], 0.0, 9.0, free=False), iterations=40)
    np.testing.assert_allclose(result.individual, right, atol=1e-5)


def test_bounds_are_kept_and_the_minimum_on_them_is_that_of_scipy():
    matrix = np.random.default_rng(0).normal(size=(30, 6))
    wanted = np.random.default_rng(1).normal(size=(30,)) * 3.0
    result = fit(
        lambda which, individual, shared: individual @ matrix.T - wanted,
        unknowns(np.full((1, 6), 0.5), 0.0, 1.0), unknowns([0.0], 0.0, 1.0, free=False), iterations=60, tolerance=0.0,
    )  # fmt: skip
    expected = least_squares(lambda x: matrix @ x - wanted, np.full(6, 0.5), bounds=(0.0, 1.0))
    assert result.individual.min() >= 0.0
    assert result.individual.max() <= 1.0
    np.testing.assert_allclose(result.cost[0], 2.0 * expected.cost, rtol=1e-5)


def test_priors_pull_towards_their_references():
    def residuals(which, individual, shared):
        return individual - 1.0

    prior = Prior(np.eye(2) * 3.0, np.zeros((2, 2)))
    result = fit(residuals, unknowns(np.zeros((2, 2)), -5.0, 5.0, priors=[prior]), unknowns([0.0], 0, 1, free=False))
    np.testing.assert_allclose(result.individual, 0.25, atol=1e-5)


def test_a_fit_that_is_hopeless_does_not_hold_up_the_others():
    def residuals(which, individual, shared):
        wild = 50.0 * np.sin(200.0 * individual) + 60.0
        return np.where(which[:, None] == 0, wild, individual - 0.3)

    result = fit(residuals, unknowns(np.full((2, 1), 0.9), 0.0, 1.0), unknowns([0.0], 0, 1, free=False))
    np.testing.assert_allclose(result.individual[1], 0.3, atol=1e-4)


def test_fits_that_are_good_enough_leave_the_batch():
    seen = []

    def residuals(which, individual, shared):
        seen.append(set(which.tolist()))
        return individual - np.array([0.5, 0.3])[which][:, None]

    fit(
        residuals, unknowns([[0.5], [0.9]], 0.0, 1.0), unknowns([0.0], 0, 1, free=False),
        enough=lambda r: np.abs(r).max(axis=1) < 1e-9, iterations=3,
    )  # fmt: skip
    assert seen[0] == {0, 1}
    assert all(0 not in later for later in seen[1:])
