"""Searches for signals of new throws begin with changes that move an arm alike, however many muscles it has."""

import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.search.directions import directions
from warpmuscle.throw.fit import Settings
from warpmuscle.throw.goals import Goal
from warpmuscle.throw.job import Job, Options
from warpmuscle.throw.synthesis import DEVIATION, MOVED, RANGE, Thrower, _Search


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


def test_the_first_generation_moves_an_arm_by_degrees_and_not_into_its_stops():
    """Changes of all signals alike by 0.03, as large as the largest here, move it farther."""
    job = Job(load("throw_ball"), [], Options(threads=1))
    job.settings = Settings(common=False, parameter_steps=3, signal_steps=3, starts=1)
    fitted = job.fit()
    thrower = Thrower(job.follower, fitted.own[0], fitted.unknowns)
    count = job.follower.synergies.count
    search = _Search(thrower, Goal(2.0), tuple(range(count)), [])
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


@pytest.mark.long
def test_eighteen_muscles_throw_a_ball_within_the_limits_of_their_joints():
    """Out of the mean throw of the scene; by wide changes of all signals, every one of these throws missed them."""
    job = Job(load("throw18_ball"), [], Options(threads=1))
    fitted = job.fit()
    thrower = Thrower(job.follower, fitted.own[0], fitted.unknowns)
    for distance in (2.0, 3.0):
        made = thrower.throw(Goal(distance))
        assert made.met, made.missed
