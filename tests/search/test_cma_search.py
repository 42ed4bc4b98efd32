"""CMA-ES against the package it is made with."""

import warnings
from itertools import product

import cma
import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from search.functions import FUNCTIONS, rastrigin, run, sphere, start_of
from warpmuscle.core.errors import Error
from warpmuscle.search.cma import CmaSearch
from warpmuscle.search.restarts import Restarts


def reference(function, dimensions, seed, evaluations):
    """Least cost that the package reaches alone, with its own handling of bounds."""
    generator = np.random.default_rng(seed)
    options = {
        "randn": lambda n, p: generator.standard_normal((n, p)),
        "seed": np.nan,
        "bounds": [0.0, 1.0],
        "verbose": -10,
        "verb_log": 0,
    }
    strategy = cma.CMAEvolutionStrategy(start_of(dimensions), 0.25, options)
    used = 0
    while not strategy.stop() and used < evaluations:
        candidates = strategy.ask()
        strategy.tell(candidates, function(np.array(candidates)).tolist())
        used += len(candidates)
    return strategy.best.f


def until_found(search, function, evaluations):
    """Search until the optimum is found, or so many evaluations were made; sizes of its generations."""
    sizes = []
    while not search.finished() and search.state()["best_cost"] > 1e-8 and sum(sizes) < evaluations:
        sizes.append(len(search.ask()))
        search.tell(function(search.ask()))
    return sizes


@pytest.mark.long
def test_reaches_what_the_package_reaches_as_often_as_not():
    """Rounding, which differs between processors, separates the two after many generations, and luck decides then."""
    reached = []
    for function, dimensions, seed in product(FUNCTIONS, (10, 30), range(2)):
        search = CmaSearch(start_of(dimensions), seed)
        run(search, function, 4000)
        theirs = reference(function, dimensions, seed, 4000)
        reached.append(search.state()["best_cost"] <= max(1.7 * theirs, 1e-9))
    assert np.mean(reached) >= 0.5


def test_first_generations_are_those_of_the_package():
    generator, search = np.random.default_rng(3), CmaSearch(start_of(10), 3)
    options = {"randn": lambda n, p: generator.standard_normal((n, p)), "seed": np.nan, "verbose": -10, "verb_log": 0}
    options |= {"bounds": [0.0, 1.0], "CMA_mirrors": 0.16}
    strategy = cma.CMAEvolutionStrategy(start_of(10), 0.25, options)
    for _ in range(10):
        candidates = strategy.ask()
        np.testing.assert_allclose(search.ask(), candidates, rtol=0, atol=1e-9)
        costs = sphere(np.array(candidates))
        strategy.tell(candidates, costs.tolist())
        search.tell(costs)


@pytest.mark.parametrize("dimensions", [10, 300])  # from 300 on the package would draw from the global generator
def test_global_random_numbers_are_left_alone(dimensions):
    np.random.seed(1)  # noqa: NPY002
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    run(CmaSearch(start_of(dimensions), 1), sphere, 200)
    np.testing.assert_array_equal(np.random.get_state()[1], before)  # noqa: NPY002


def test_prints_nothing_writes_nothing_and_warns_of_nothing(capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run(CmaSearch(start_of(5), 1, population=6, restarts="ipop"), sphere, 5000)
    assert capfd.readouterr() == ("", "")
    assert list(tmp_path.iterdir()) == []


def test_finds_a_corner_of_the_cube():
    search = CmaSearch(np.full(10, 0.5), 1)
    run(search, lambda x: np.sum(x, axis=-1), 4000)
    assert search.state()["best_cost"] < 1e-9
    assert "tol" in search.finished()


def test_best_is_apart_from_the_mean():
    search = CmaSearch(start_of(10), 1)
    batches = np.concatenate(run(search, rastrigin, 300))
    state = search.state()
    np.testing.assert_array_equal(state["best"], batches[np.argmin(rastrigin(batches))])
    assert not np.array_equal(state["best"], state["mean"])
    assert state["C"].shape == (10, 10)
    assert state["path_c"].shape == state["path_sigma"].shape == (10,)
    assert state["evaluations"] == len(batches)


def test_flat_costs_end_a_run():
    search = CmaSearch(start_of(10), 1)
    run(search, lambda x: np.ones(len(x)), 2000)
    assert search.finished()


@pytest.mark.parametrize("restarts", ["ipop", "bipop"])
def test_restarts_find_the_global_optimum_that_single_runs_miss(restarts):
    found = {"none": 0, restarts: 0}
    for seed in range(6):
        costs = {}
        for kind in found:
            search = CmaSearch(start_of(2), seed, restarts=kind)
            sizes = until_found(search, rastrigin, 20000)
            costs[kind] = float(search.state()["best_cost"])
            found[kind] += costs[kind] < 1e-8
            assert (max(sizes) > min(sizes)) == (search.state()["restarts"] > 0)  # the second run is a large one
        assert costs[restarts] <= costs["none"]  # for any seed: the first run is the single one
    assert found[restarts] > max(3, found["none"])


def test_bipop_shares_the_budget_between_large_and_small_runs():
    generator, restarts = np.random.default_rng(1), Restarts("bipop", 10, 0.25)
    used, spent, largest = 1000, {False: 1000, True: 0}, 10
    while (run := restarts.next(used, generator)) is not None:
        assert run.large == (spent[True] <= spent[False])
        if run.large:
            largest *= 2
            assert (run.population, run.sigma) == (largest, 0.25)
            used = last = 100 * largest
        else:
            assert 10 <= run.population <= largest / 2
            assert 0.0025 <= run.sigma <= 0.25
            assert run.evaluations == last / 2
            used = int(run.evaluations)
        spent[run.large] += used
    assert largest == 10 * 2**9


def test_without_restarts_there_is_one_run():
    assert Restarts("none", 10, 0.25).next(1000, np.random.default_rng(1)) is None


@pytest.mark.parametrize(
    ("settings", "text"),
    [
        ({"population": 3}, "at least 4"),
        ({"sigma": 0.0}, "sigma must be above 0"),
        ({"sigma": 2.0}, "at most 1"),
        ({"restarts": "often"}, "none, ipop, bipop"),
        ({"start": [0.5, 1.5]}, "coordinate 1 of its start is 1.5"),
        ({"start": [0.5]}, "at least two"),
        ({"start": [[0.5]]}, "vector"),
    ],
)
def test_settings_that_cannot_be_used(settings, text):
    with pytest.raises(Error, match=text):
        CmaSearch(settings.pop("start", [0.5, 0.5]), 1, **settings)


def test_candidates_do_not_depend_on_the_number_of_blas_threads():
    def last_generation(threads):
        with threadpool_limits(threads, user_api="blas"):
            search = CmaSearch(np.full(150, 0.5), 1, population=600)
            for _ in range(3):
                search.tell(np.sum((search.ask() - 0.3) ** 2, axis=1))
            return search.ask()

    np.testing.assert_array_equal(last_generation(1), last_generation(2))
