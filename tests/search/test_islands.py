"""Islands of CMA-ES: the best take the place of the worst."""

import numpy as np
import pytest

from search.functions import FUNCTIONS, rastrigin, run, sphere, start_of
from warpmuscle.core.errors import Error
from warpmuscle.search.cma import CmaSearch
from warpmuscle.search.islands import ENLARGED, EXCHANGE, IslandSearch
from warpmuscle.search.many_cma import usual_size


def test_a_generation_has_as_many_candidates_as_asked_for_in_islands_of_the_usual_size():
    search = IslandSearch(start_of(20), 1, population=ENLARGED * usual_size(20) * 5)
    assert len(search.ask()) == ENLARGED * usual_size(20) * 5
    assert search.state()["sigmas"].shape == (5,)


def test_islands_begin_at_the_start_with_step_sizes_from_the_one_asked_for_down_to_a_25th():
    search = IslandSearch(start_of(20), 1, sigma=0.2)
    np.testing.assert_allclose(search.state()["means"], np.tile(start_of(20), (5, 1)))
    np.testing.assert_allclose(search.state()["sigmas"][[0, -1]], [0.2, 0.008])


@pytest.mark.parametrize("function", FUNCTIONS)
def test_finds_more_than_cma_does_in_as_many_generations(function):
    """That is what they are for: a device computes all of them in the time of one."""
    few = CmaSearch(start_of(20), 1)
    many = IslandSearch(start_of(20), 1)
    run(few, function, 60 * len(few.ask()))
    run(many, function, 60 * len(many.ask()))
    assert many.state()["best_cost"] < 0.85 * few.state()["best_cost"]


def test_worst_islands_give_way_to_the_best():
    """One island's costs are made the worst: after an exchange it stands where another one does."""
    search = IslandSearch(start_of(10), 1, population=200, islands=5)
    for _ in range(EXCHANGE):
        costs = sphere(search.ask()).reshape(5, -1)
        costs[3] += 1e6
        search.tell(costs.ravel())
    means = search.state()["means"]
    others = [k for k in range(5) if k != 3]
    assert any(np.array_equal(means[3], means[k]) for k in others)


def test_an_island_that_has_converged_gives_way_and_the_search_goes_on():
    search = IslandSearch(np.full(3, 0.6), 1, population=60, islands=3)
    run(search, sphere, 60 * 400)
    assert search.finished() == ""
    assert search.state()["best_cost"] < 1e-8
    assert len(search.ask()) == 60


def test_one_island_alone_finishes():
    search = IslandSearch(np.full(3, 0.6), 1, population=20, islands=1)
    run(search, sphere, 20 * 1000)
    assert search.finished() == "converged"
    with pytest.raises(Error, match="finished: converged"):
        search.ask()


def test_what_it_asks_lies_in_the_cube_and_depends_on_the_seed_alone():
    first, again, other = (IslandSearch(start_of(8), seed, sigma=0.5) for seed in (1, 1, 2))
    for _ in range(12):
        assert first.ask().min() >= 0.0
        assert first.ask().max() <= 1.0
        np.testing.assert_array_equal(first.ask(), again.ask())
        assert not np.array_equal(first.ask(), other.ask())
        for search in (first, again, other):
            search.tell(rastrigin(search.ask()))


def test_candidates_of_another_machine_are_taken_in_place_of_its_own():
    """What they learn then is the same but for rounding; what they ask next has other axes to be drawn along."""
    leader, follower = (IslandSearch(np.full(8, 0.55), 1, sigma=0.01) for _ in range(2))  # far from all faces
    for _ in range(8):
        asked = np.clip(leader.ask() + 1e-12, 0.0, 1.0)
        assert follower.follow(asked)
        follower.tell(sphere(asked))
        leader.tell(sphere(leader.ask()))
        for name in ("means", "sigmas", "latest"):
            np.testing.assert_allclose(follower.state()[name], leader.state()[name], rtol=1e-6)


def test_one_parameter_is_refused():
    with pytest.raises(Error, match="at least two parameters"):
        IslandSearch([0.5], 1)
