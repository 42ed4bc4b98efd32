"""An arm fitted to the mean throw of its own scene, a file of it, and what arms are fitted to."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from warpmuscle.formats import load
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.throw import simulator
from warpmuscle.throw.arm import Arm
from warpmuscle.throw.fit import Settings
from warpmuscle.throw.goals import Goal
from warpmuscle.throw.job import Job, JobOptions
from warpmuscle.throw.motion import ArmMotion
from warpmuscle.throw.recordings.arm_motions import motion_of
from warpmuscle.throw.synthesis import Thrower


@pytest.fixture(scope="module", autouse=True)
def one_kernel_of_throw_ball() -> Iterator[None]:
    """Record all of `throw_ball` in fits, too, so that they and what is kept of them share a kernel.

    Fits of `throw`, in the next fixture, record coordinates and speeds alone, as those of users.
    """

    def recording_all(scene: Any, *given: Any, **named: Any) -> Rollout:
        if scene.name.startswith("throw_ball"):
            named.pop("quantities", None)
        return Rollout(scene, *given, **named)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(simulator, "Rollout", recording_all)
        yield


@pytest.fixture(scope="session")
def job() -> Job:
    """Fitted from literature parameters to signals computed with others."""
    made = Job(load("throw"), [], JobOptions())
    made.settings = Settings(common_steps=4, early_steps=3, signal_steps=6)
    made.fit()
    return made


@pytest.fixture(scope="session")
def kept(job: Job, tmp_path_factory) -> Path:
    """The file of the fit and of a new throw."""
    path = tmp_path_factory.mktemp("kept") / "throw.h5"
    thrower = Thrower(job.follower, job.fitted.individual[0], job.fitted.unknowns)
    job.throws = [thrower.throw(Goal(distance=1.5), synergies=(0, 1, 3))]
    job.write(path, {"command": "warpmuscle throw", "seed": 3})
    return path


@pytest.fixture
def arm_and_motion() -> tuple[Arm, ArmMotion]:
    scene = load("throw")
    arm = Arm(scene)
    return arm, motion_of(scene, arm)
