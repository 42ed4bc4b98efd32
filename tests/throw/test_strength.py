"""What muscles lack for a new throw."""

from warpmuscle.throw.goals import Goal
from warpmuscle.throw.job import Job
from warpmuscle.throw.strength import missing_torque
from warpmuscle.throw.synthesis import Thrower


def test_torque_is_lacking_where_muscles_are_too_weak_for_a_throw_and_only_there(job: Job):
    thrower = Thrower(job.follower, job.fitted.individual[0], job.fitted.unknowns)
    made = thrower.throw(Goal(distance=1.5))
    assert missing_torque(thrower, made) == {}
    lacking = missing_torque(thrower.stronger(0.1), made)
    assert lacking  # of which joint is another matter: throws that meet a goal differ between machines
    for needed, available, time in lacking.values():
        assert abs(needed) > abs(available)
        assert 0.0 <= time <= made.release
