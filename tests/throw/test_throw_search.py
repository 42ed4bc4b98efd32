"""Searches for signals of new throws begin with changes that move an arm alike, however many muscles it has."""

from typing import Any

import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.search.directions import directions
from warpmuscle.throw.fit import Settings
from warpmuscle.throw.goals import Goal
from warpmuscle.throw.job import Job, JobOptions
from warpmuscle.throw.signal_search import DEVIATION, MOVED, RANGE, Best, SignalSearch, Way
from warpmuscle.throw.synthesis import Thrower


def test_directions_are_the_root_of_a_covariance_that_bounds_changes_and_what_they_move():
    rng = np.random.default_rng(0)
    slopes = rng.normal(size=(6, 40)) * np.array([1e-3, 1.0, 10.0, 0.0, 5.0, 100.0])[:, None]
    found = directions(slopes, 0.03, 0.1)
    covariance = found @ found.T
    np.testing.assert_allclose(
        covariance @ (6 / 0.1**2 * slopes @ slopes.T + np.eye(6) / 0.03**2), np.eye(6), atol=1e-7
    )
    assert np.linalg.eigvalsh(covariance)[-1] <= 0.03**2 * (1.0 + 1e-9)
    assert np.trace(slopes.T @ covariance @ slopes) <= 0.1**2
    np.testing.assert_allclose(directions(np.zeros((3, 5)), 0.03, 0.1), 0.03 * np.eye(3), atol=1e-12)


@pytest.fixture(scope="module")
def thrower() -> Thrower:
    job = Job(load("throw_ball"), [], JobOptions(threads=1))
    job.settings = Settings(common=False, parameter_steps=3, signal_steps=3, starts=1)
    fitted = job.fit()
    return Thrower(job.follower, fitted.individual[0], fitted.unknowns)


def test_the_first_generation_moves_an_arm_by_degrees_and_not_into_its_stops(thrower: Thrower):
    """Changes of all signals alike by 0.03, as large as the largest here, move it farther."""
    count = thrower.follower.synergies.count
    search = SignalSearch(thrower, Goal(2.0), tuple(range(count)), [])
    size = thrower.hats.shape[1] * count
    drawn = np.random.default_rng(1).normal(size=(48, size))

    def moved(changes: np.ndarray) -> float:
        angle = thrower.simulated(search._signals(changes)).angle - thrower.known.angle
        return float(np.sqrt(np.mean(angle**2)))

    small = 0.1 * drawn  # for which angles are nearly linear in the changes
    likely = moved(small @ directions(search._slopes(), DEVIATION, MOVED))
    assert 0.02 * MOVED < likely < 0.6 * MOVED  # it falls farther than slopes say
    assert moved(DEVIATION * small) > 1.5 * likely
    assert abs(RANGE * DEVIATION - 1.0) < 0.02  # a signal may still change by its whole range


def searched(thrower: Thrower, monkeypatch: pytest.MonkeyPatch, found: list[tuple[float, float]]) -> list[Any]:
    """Ways that a search takes, and whether from the known throw on, whose runs end with misses of limits and ball."""
    taken: list[Any] = []

    def descend(search: SignalSearch, seed: int, way: Way, best: Best) -> Best:
        taken.append((way, search._known is thrower.individual))
        limits, ball = found[len(taken) - 1]
        return Best(thrower.individual + 0.01 * len(taken), 1, limits + ball, limits + ball, ball)

    monkeypatch.setattr(SignalSearch, "_descend", descend)
    monkeypatch.setattr(SignalSearch, "_judged", lambda search, one: one)
    monkeypatch.setattr(SignalSearch, "_follow_through", lambda search, seed, best: best)
    SignalSearch(thrower, Goal(2.0), (0,), []).run(0)
    return taken


def test_limits_count_more_where_nothing_else_is_missed(thrower: Thrower, monkeypatch: pytest.MonkeyPatch):
    first, second = searched(thrower, monkeypatch, [(9.0, 0.1), (0.3, 0.1)])
    assert first[0].weight < second[0].weight
    assert not second[1]


def test_a_search_that_leads_a_ball_astray_begins_anew_by_changing_signals_alike(
    thrower: Thrower, monkeypatch: pytest.MonkeyPatch
):
    first, second, third, last = searched(thrower, monkeypatch, [(0.0, 400.0), (1.0, 7.0), (3.0, 0.1), (0.2, 0.1)])
    assert (first[0].alike, second[0].alike) == ("angles", "signals")
    assert second[1]
    assert not third[1]
    assert last[0].weight > 1.0


def test_a_goal_that_is_met_by_the_first_run_takes_no_other(thrower: Thrower, monkeypatch: pytest.MonkeyPatch):
    assert len(searched(thrower, monkeypatch, [(0.5, 0.2)])) == 1


def test_the_weight_of_limits_raises_the_cost_of_passing_them_and_no_miss(thrower: Thrower):
    count = thrower.follower.synergies.count
    search = SignalSearch(thrower, Goal(2.0), tuple(range(count)), [])
    drawn = 0.1 * np.random.default_rng(2).normal(size=(24, thrower.hats.shape[1] * count))
    cost, miss, ball, frame = search.cost(search._signals(drawn))
    search._weight = 16.0
    dearer, *rest = search.cost(search._signals(drawn))
    for one, other in zip(rest, (miss, ball, frame), strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_allclose(dearer - cost, 15.0 * (miss - ball), rtol=1e-6, atol=1e-6)
    assert np.any(miss > ball)


@pytest.mark.long
def test_eighteen_muscles_throw_a_ball_within_the_limits_of_their_joints():
    """Out of the mean throw of the scene; by wide changes of all signals, every one of these throws missed them."""
    job = Job(load("throw18_ball"), [], JobOptions(threads=1))
    fitted = job.fit()
    thrower = Thrower(job.follower, fitted.individual[0], fitted.unknowns)
    for distance in (2.0, 3.0):
        made = thrower.throw(Goal(distance))
        assert made.met, made.missed
