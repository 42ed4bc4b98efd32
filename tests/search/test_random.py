"""Random search."""

import numpy as np

from warpmuscle.search.random import RandomSearch

START, LOW, HIGH = np.array([0.5, 2.0]), np.array([0.0, 1.0]), np.array([1.0, 5.0])


def test_first_candidate_is_the_start():
    np.testing.assert_array_equal(RandomSearch(START, LOW, HIGH, seed=1).ask(3)[0], START)


def test_candidates_do_not_depend_on_how_many_are_asked_for_at_a_time():
    whole = RandomSearch(START, LOW, HIGH, seed=1).ask(10)
    search = RandomSearch(START, LOW, HIGH, seed=1)
    np.testing.assert_array_equal(np.concatenate([search.ask(3), search.ask(7)]), whole)


def test_candidates_fill_their_intervals_evenly():
    values = RandomSearch(START, LOW, HIGH, seed=1).ask(20_000)[1:]
    counts = np.stack([np.histogram(values[:, i], bins=10, range=(LOW[i], HIGH[i]))[0] for i in range(2)])
    assert counts.sum() == values.size
    assert np.all(np.abs(counts - 2000) < 200)


def test_another_seed_gives_other_candidates():
    first, second = (RandomSearch(START, LOW, HIGH, seed).ask(2)[1] for seed in (1, 2))
    assert not np.array_equal(first, second)
