"""Many populations of CMA-ES in arrays, against the package and against what CMA-ES is known to do."""

import cma
import numpy as np
import pytest
from cma.recombination_weights import RecombinationWeights

from warpmuscle.search.many_cma import ManyCma, Rates, usual_size


@pytest.mark.parametrize(("population", "parameters"), [(10, 10), (17, 86), (136, 86), (640, 40)])
def test_rates_are_those_of_the_package(population, parameters):
    theirs = cma.CMAEvolutionStrategy(
        np.zeros(parameters), 0.1, {"popsize": population, "verbose": -10, "verb_log": 0, "verb_disp": 0}
    ).sp
    weights = RecombinationWeights(population)
    weights.finalize_negative_weights(parameters, theirs.c1, theirs.cmu)
    ours = Rates.of(population, parameters)
    assert ours.mass == pytest.approx(weights.mueff)
    assert ours.path_c == pytest.approx(theirs.cc, rel=1e-6)
    assert ours.rank_one == pytest.approx(theirs.c1, rel=1e-6)
    assert ours.rank_mu == pytest.approx(theirs.cmu, rel=1e-6)
    np.testing.assert_allclose(ours.weights, weights, rtol=1e-6, atol=1e-9)


def test_usual_size_is_hansens():
    """4 + 3 ln n, rounded down (Hansen, arXiv:1604.00772, eq. 48)."""
    assert [usual_size(n) for n in (2, 10, 86)] == [6, 10, 17]


def told(generations, sigma=0.1, seed=0, populations=3):
    """Populations that have minimised an ellipsoid about 0.3, with weights of 1 to 1e4, for some generations."""
    weight = np.logspace(0.0, 4.0, 6)
    islands, generator = ManyCma(np.full(6, 0.5), np.full(populations, sigma), 12), np.random.default_rng(seed)
    for _ in range(generations):
        asked = islands.ask(generator)
        islands.tell(asked, (weight * (asked - 0.3) ** 2).sum(axis=2))
    return islands, weight


def test_finds_the_optimum_of_an_ill_conditioned_ellipsoid():
    islands, _ = told(250)
    np.testing.assert_allclose(islands.mean, 0.3, atol=1e-5)


def test_covariance_becomes_the_inverse_of_the_hessian():
    islands, weight = told(120)
    for covariance in islands.covariance:
        variance = np.diag(covariance) * weight
        assert variance.max() / variance.min() < 20.0  # 1e4 at the beginning
        np.testing.assert_array_equal(covariance, covariance.T)


def test_populations_do_not_know_of_each_other():
    weight, generators = np.logspace(0.0, 2.0, 6), [np.random.default_rng(seed) for seed in (4, 5)]
    both = ManyCma(np.full(6, 0.5), np.array([0.1, 0.02]), 12)
    alone = [ManyCma(np.full(6, 0.5), np.array([sigma]), 12) for sigma in (0.1, 0.02)]
    for _ in range(20):
        asked = [one.ask(generator) for one, generator in zip(alone, generators, strict=True)]
        costs = [(weight * (one - 0.3) ** 2).sum(axis=2) for one in asked]
        for one, points, values in zip(alone, asked, costs, strict=True):
            one.tell(points, values)
        both.tell(np.concatenate(asked), np.concatenate(costs))
    for index, one in enumerate(alone):
        np.testing.assert_allclose(both.mean[index], one.mean[0], rtol=1e-9)
        np.testing.assert_allclose(both.sigma[index], one.sigma[0], rtol=1e-9)


def test_step_size_grows_on_a_slope_until_it_spans_a_third_of_the_cube():
    islands, generator = ManyCma(np.full(6, 0.5), np.array([1e-3]), 12), np.random.default_rng(1)
    for _ in range(300):
        asked = islands.ask(generator)
        islands.tell(asked, asked.sum(axis=2))
    widest = islands.sigma * np.sqrt(np.einsum("kpp->kp", islands.covariance).max(axis=1))
    np.testing.assert_allclose(widest, 1.0 / 3.0, rtol=0.05)


def test_equal_costs_leave_everything_finite():
    islands, generator = ManyCma(np.full(4, 0.5), np.full(2, 0.1), 4), np.random.default_rng(1)
    for _ in range(50):
        islands.tell(islands.ask(generator), np.ones((2, 4)))
    assert np.isfinite(islands.covariance).all()
    assert np.isfinite(islands.sigma).all()


def test_a_copy_goes_on_where_the_other_stands():
    islands, _ = told(20)
    islands.copy(0, 2, 2.0)
    np.testing.assert_array_equal(islands.mean[2], islands.mean[0])
    np.testing.assert_array_equal(islands.covariance[2], islands.covariance[0])
    assert islands.sigma[2] == 2.0 * islands.sigma[0]
