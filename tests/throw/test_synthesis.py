"""New throws out of a fitted one, on real simulations."""

from dataclasses import replace

import numpy as np
import pytest

from warpmuscle.core.errors import Error
from warpmuscle.formats import load
from warpmuscle.throw.goals import Goal
from warpmuscle.throw.job import Job
from warpmuscle.throw.synthesis import Thrower


@pytest.mark.parametrize("distance", [1.5, 2.0])
def test_a_ball_lands_on_its_target_by_a_few_synergies_alone(job: Job, distance: float):
    thrower = Thrower(job.follower, job.fitted.individual[0], job.fitted.unknowns)
    made = thrower.throw(Goal(distance=distance), synergies=(0, 1, 3))
    assert made.met
    assert made.clearance > 0.0
    changed = job.follower.shaped((made.individual != job.fitted.individual[0])[None])[0].any(axis=1)
    assert set(np.flatnonzero(changed)) <= set(made.synergies)
    free = made.flight.position[0] + made.flight.velocity[0] * made.flight.duration[0]
    assert free[1] - 0.5 * thrower.gravity * made.flight.duration[0] ** 2 == pytest.approx(0.0, abs=1e-6)


def test_no_joint_of_a_new_throw_passes_its_limits_before_the_release_and_one_that_does_misses(job: Job):
    """Measured from the angles themselves: limits as the scene's joints have them, in radians."""
    made = Thrower(job.follower, job.fitted.individual[0], job.fitted.unknowns).throw(Goal(distance=2.0))
    joints = load("throw").character.joints
    for column, name in enumerate(job.arm.joints):
        low, high = joints[name].limits[0]
        angle = made.replay.angle[0, : round(made.release / 0.01) + 1, column]
        assert max(low - angle.min(), angle.max() - high) <= np.radians(1.0), name
    assert made.met
    beyond = replace(made, past_limits={"elbow": np.radians(7.0)})
    assert (beyond.met, list(beyond.missed)) == (False, ["limits"])


def test_stronger_muscles_are_not_tried_where_limits_alone_are_missed(job: Job, monkeypatch: pytest.MonkeyPatch):
    thrower = Thrower(job.follower, job.fitted.individual[0], job.fitted.unknowns)
    made = replace(thrower.throw(Goal(distance=1.5)), past_limits={"elbow": np.radians(7.0)})
    monkeypatch.setattr(job, "throws", [])
    monkeypatch.setattr(Thrower, "throws", lambda *_: [made])
    monkeypatch.setattr("warpmuscle.throw.job.what_lacks", lambda *_: pytest.fail("tried"))
    assert [one.lack for one in job.throw([Goal(distance=1.5)])] == [""]


def test_a_goal_is_met_only_if_all_that_it_names_is(job: Job):
    made = Thrower(job.follower, job.fitted.individual[0], job.fitted.unknowns).throw(Goal(distance=1.5))
    speed = float(made.flight.speed[0])
    assert made.met
    assert replace(made, goal=Goal(distance=1.5, speed=speed)).met
    assert not replace(made, goal=Goal(distance=1.5, speed=speed + 1.0)).met
    assert not replace(made, goal=Goal(angle=float(made.flight.angle[0]) + 0.1)).met
    nowhere = replace(made.flight, distance=np.array([np.nan]))
    assert not replace(made, flight=nowhere).met


def test_solutions_of_a_goal_are_unlike_each_other(job: Job):
    first, second = Thrower(job.follower, job.fitted.individual[0], job.fitted.unknowns).throws(Goal(distance=1.5), 2)
    assert first.met
    assert second.met
    assert np.sqrt(np.mean((first.individual - second.individual) ** 2)) > 0.14


def test_a_release_beyond_the_throw_is_refused(job: Job):
    with pytest.raises(Error, match="within the throw"):
        Thrower(job.follower, job.fitted.individual[0], job.fitted.unknowns, release=9.0)
