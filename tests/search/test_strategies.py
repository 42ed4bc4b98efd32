"""Searches by name, what all have in common, and many at once."""

import numpy as np
import pytest

from search.functions import rastrigin, rosenbrock, run, sphere, start_of
from warpmuscle.core.errors import Error
from warpmuscle.search.batched import ask_all, tell_all
from warpmuscle.search.bounds import into_cube, out_of_cube, scattered
from warpmuscle.search.random import RandomGenerations, RandomSearch
from warpmuscle.search.strategies import make_search, make_searches

NAMES = ("islands", "random", "cma", "cma:ipop", "cma:bipop", "nlopt:LN_BOBYQA", "nlopt:GN_ISRES", "nlopt:LD_LBFGS")


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("dimensions", [8, 60])
def test_a_fresh_search_told_the_same_costs_asks_the_same(name, dimensions):
    first = make_search(name, dimensions, start_of(dimensions), 11)
    asked = run(first, rastrigin, 3000 if dimensions == 8 else 600)
    costs = [rastrigin(batch) for batch in asked]
    again = make_search(name, dimensions, start_of(dimensions), 11)
    bystander = make_search(name, dimensions, None, 12)
    for batch, cost in zip(asked, costs, strict=True):
        np.random.rand(3)  # noqa: NPY002
        np.testing.assert_array_equal(again.ask(), batch)
        assert again.ask() is again.ask()
        again.tell(cost)
        if not bystander.finished():
            bystander.tell(sphere(bystander.ask()))
    assert again.finished() == first.finished()
    for key, value in first.state().items():
        np.testing.assert_array_equal(again.state()[key], value)


def test_replay_at_300_parameters_to_the_last_bit():
    asked = run(make_search("cma", 300, None, 1, population=50), rosenbrock, 600)
    again = run(make_search("cma", 300, None, 1, population=50), rosenbrock, 600)
    np.testing.assert_array_equal(again, asked)


@pytest.mark.parametrize("name", NAMES)
def test_candidates_lie_within_the_cube(name):
    candidates = np.concatenate(run(make_search(name, 6, np.zeros(6), 1, sigma=0.5), rastrigin, 600))
    assert candidates.min() >= 0.0
    assert candidates.max() <= 1.0


@pytest.mark.parametrize("name", NAMES)
def test_another_seed_or_none_for_deterministic_ones(name):
    first, second = (np.concatenate(run(make_search(name, 6, None, seed), sphere, 100)) for seed in (1, 2))
    deterministic = name in ("nlopt:LN_BOBYQA", "nlopt:LD_LBFGS")
    assert np.array_equal(first, second) == deterministic


@pytest.mark.parametrize("name", NAMES)
def test_costs_that_cannot_be_used_leave_the_search_as_it_is(name):
    search = make_search(name, 4, None, 1)
    asked = search.ask().copy()
    with pytest.raises(Error, match="asked for"):
        search.tell(np.zeros(len(asked) + 1))
    with pytest.raises(Error, match="candidate 0 is nan"):
        search.tell(np.full(len(asked), np.nan))
    with pytest.raises(ValueError, match="read-only"):
        search.ask()[0, 0] = 0.0
    np.testing.assert_array_equal(search.ask(), asked)
    assert search.state()["evaluations"] == 0


@pytest.mark.parametrize("name", ["cma", "nlopt:LN_BOBYQA"])
def test_a_finished_search_asks_no_more(name):
    search = make_search(name, 4, None, 1)
    run(search, sphere, 10_000)
    assert search.finished()
    with pytest.raises(Error, match=f"finished: {search.finished()}"):
        search.ask()
    with pytest.raises(Error, match="finished"):
        search.tell([1.0])


@pytest.mark.parametrize("name", ["cma", "islands", "nlopt:LN_SBPLX", "random"])
def test_64_searches_share_their_batches_and_do_as_they_would_alone(name):
    searches = make_searches(name, 10, start_of(10), 5, 64, population=None if name != "random" else 4)
    parts = [[] for _ in searches]
    for _ in range(20):
        batch = ask_all(searches)
        assert np.all(np.diff(batch.owner) >= 0)
        for i, part in enumerate(parts):
            part.append(batch.candidates[batch.owner == i])
        tell_all(searches, batch, rosenbrock(batch.candidates))
    alone = make_searches(name, 10, start_of(10), 5, 64, population=None if name != "random" else 4)
    for search, part in zip(alone, parts, strict=True):
        for batch in part:
            np.testing.assert_array_equal(search.ask(), batch)
            search.tell(rosenbrock(batch))
    assert len({float(search.state()["best_cost"]) for search in searches}) == 64


def test_finished_searches_are_left_out_of_the_batch():
    searches = [make_search("cma", 3, None, 1), make_search("random", 3, None, 1, population=7)]
    while not searches[0].finished():
        batch = ask_all(searches)
        tell_all(searches, batch, sphere(batch.candidates))
    batch = ask_all(searches)
    assert set(batch.owner) == {1}
    assert len(batch.candidates) == 7
    with pytest.raises(Error, match="all searches"):
        ask_all(searches[:1])


def test_the_first_of_many_is_the_one_alone_and_the_others_do_not_depend_on_their_number():
    few, many = (make_searches("cma", 5, start_of(5), 3, count, sigma=0.2) for count in (3, 6))
    np.testing.assert_array_equal(few[0].ask(), make_search("cma", 5, start_of(5), 3, sigma=0.2).ask())
    for a, b in zip(few, many[:3], strict=True):
        np.testing.assert_array_equal(a.ask(), b.ask())
    sigmas = [float(search.state()["sigma"]) for search in many]
    assert sigmas[0] == 0.2
    assert len(set(sigmas)) == 6
    assert min(sigmas) >= 0.02
    assert max(sigmas) <= 0.2


def test_random_generations_are_those_of_random_search():
    search = RandomGenerations(start_of(3), 4, population=5)
    stream = RandomSearch(start_of(3), np.zeros(3), np.ones(3), 4).ask(15)
    np.testing.assert_array_equal(np.concatenate(run(search, sphere, 15)), stream)
    assert search.state()["best_cost"] == sphere(stream).min()


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("CMA", "nearest are cma"),
        ("cma:bipo", "cma:bipop"),
        ("randm", "random"),
        ("nlopt:LN_BOBYKA", "nlopt:LN_BOBYQA"),
        ("nlopt:ln_sbplx", "nlopt:LN_SBPLX"),
        ("LN_BOBYQA", "nlopt:LN_BOBYQA"),
        ("nlopt", "needs an algorithm, such as nlopt:LN_BOBYQA"),
        ("NLopt:", "needs an algorithm"),
        ("random:GD_STOGO", "nlopt:GD_MLSL"),
        ("", "random"),
    ],
)
def test_an_unknown_name_is_answered_with_the_nearest(name, text):
    with pytest.raises(Error, match=text):
        make_search(name, 3, None, 1)


def test_other_requests_that_cannot_be_used():
    with pytest.raises(Error, match="2 coordinates for 3"):
        make_search("cma", 3, [0.5, 0.5], 1)
    with pytest.raises(Error, match="no restarts"):
        make_search("random", 3, None, 1, restarts="ipop")
    with pytest.raises(Error, match="restarts 'ipop' as well"):
        make_search("cma:bipop", 3, None, 1, restarts="ipop")
    with pytest.raises(Error, match="number of searches"):
        make_searches("cma", 3, None, 1, 0)


def test_the_map_into_the_cube_is_smooth_and_has_an_inverse():
    x = np.linspace(-3.0, 4.0, 70_001)
    y = into_cube(x)
    assert y.min() == 0.0
    assert y.max() == 1.0
    slope = np.diff(y) / np.diff(x)
    assert np.abs(slope).max() <= 1.0 + 1e-9
    assert np.abs(np.diff(slope)).max() < 2e-3  # no kinks
    middle = (x >= 0.05) & (x <= 0.95)
    np.testing.assert_array_equal(y[middle], x[middle])
    cube = np.linspace(0.0, 1.0, 1001)
    np.testing.assert_allclose(into_cube(out_of_cube(cube)), cube, atol=1e-15)


def test_scattered_points_lie_about_their_center():
    generator = np.random.default_rng(1)
    points = np.array([scattered(np.array([0.5, 0.0]), 0.1, generator) for _ in range(4000)])
    assert points.min() >= 0.0
    np.testing.assert_allclose(points[:, 0].mean(), 0.5, atol=0.01)
    np.testing.assert_allclose(points[:, 0].std(), 0.1, atol=0.01)
    np.testing.assert_allclose(points[:, 1].mean(), 0.1 * np.sqrt(2.0 / np.pi), atol=0.01)
