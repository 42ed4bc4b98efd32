"""Signals that are fitted window by window make a motion, whatever it hangs on."""

import numpy as np

from warpmuscle.formats import load
from warpmuscle.throw.job import Job, JobOptions
from warpmuscle.throw.windows import by_windows


def test_signals_found_in_windows_follow_a_throw_from_parameters_that_lose_it():
    job = Job(load("throw_groups"), [], JobOptions())
    follower, distance = job.follower, 1e-3 * np.eye(job.follower.size)
    lost = follower.agreement(follower.extracted, job.start)[0]
    individual, simulations = by_windows(follower, np.array([0]), job.start, distance)
    found = follower.agreement(individual, job.start)[0]
    assert lost.r2.min() < 0.9
    assert found.good().all(), found
    assert simulations > 0
    assert follower.horizon == job.motions.time[-1]
    assert np.all((individual >= 0.0) & (individual <= 1.0))
