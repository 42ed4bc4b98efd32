"""The shipped policies move their scenes, without PyTorch."""

import msgspec
import pytest

from warpmuscle.core.status import Status
from warpmuscle.examples import write
from warpmuscle.formats import load
from warpmuscle.learning.player import commanded, learned_in, replay, task_of

NAMES = [
    "walk56_by_command",
    "walk56_like_people",
    "walk56_tasks",
    pytest.param("gait2392_by_policy", marks=pytest.mark.long),
]


@pytest.mark.parametrize("name", NAMES)
def test_a_shipped_policy_walks(name, tmp_path):
    write("policies", tmp_path)
    scene = msgspec.structs.replace(load(str(tmp_path / f"{name}.toml")), duration=2.0)
    learned = learned_in(tmp_path / f"{name}.h5")
    task = commanded(task_of(learned), ["speed=1.2", "turning_rate=0"])
    recording, status = replay(learned.policy, scene, "cpu", msgspec.structs.replace(task, episode_time=2.0))
    assert status == Status.COMPLETED
    assert recording.com_velocity[:, 2].mean() == pytest.approx(1.2, abs=0.15)
    assert (tmp_path / f"{name}.h5").stat().st_size < 600_000
