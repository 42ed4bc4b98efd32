"""The shipped policies move their scenes, without PyTorch."""

import msgspec
import pytest

from warpmuscle.core.status import Status
from warpmuscle.examples import write
from warpmuscle.formats import load
from warpmuscle.gait.quality import gait_measures
from warpmuscle.learning.imitation import choice
from warpmuscle.learning.imitation.kept_gaits import digest_of
from warpmuscle.learning.player import commanded, commands_in_words, lasting, learned_in, replay, task_of

NAMES = [
    "walk56_by_command",
    "walk56_like_people",
    "walk56_tasks",
    pytest.param("gait2392_by_policy", marks=pytest.mark.long),
    pytest.param("gait2392_arms_by_policy", marks=pytest.mark.long),
    pytest.param("gait2392_arms_like_people", marks=pytest.mark.long),
    pytest.param("gait2392_arms_feet", marks=pytest.mark.long),
]


@pytest.fixture(autouse=True)
def no_gait_of_the_controller(monkeypatch):
    """Files keep the gaits that policies imitate, so that none compiles the controller to be played."""
    monkeypatch.delattr(choice, "controller_gait")


@pytest.mark.parametrize("name", NAMES)
def test_a_shipped_policy_walks(name, tmp_path):
    write("policies", tmp_path)
    scene = msgspec.structs.replace(load(str(tmp_path / f"{name}.toml")), duration=2.0)
    learned = learned_in(tmp_path / f"{name}.h5")
    task = commanded(task_of(learned), ["speed=1.2", "turning_rate=0"])
    recording, status = replay(learned.policy, scene, "cpu", msgspec.structs.replace(task, episode_time=2.0))
    assert status == Status.COMPLETED
    assert recording.com_velocity[:, 2].mean() == pytest.approx(1.2, abs=0.15)
    assert (tmp_path / f"{name}.h5").stat().st_size < 700_000


@pytest.mark.parametrize("name", ["gait2392_by_policy", "gait2392_arms_feet"])
def test_files_keep_the_gait_of_a_scene_from_an_opensim_model(name, tmp_path):
    write("policies", tmp_path)
    scene, learned = load(str(tmp_path / f"{name}.toml")), learned_in(tmp_path / f"{name}.h5")
    imitation = task_of(learned).imitation
    assert imitation is not None
    assert learned.policy.gait is not None
    assert learned.policy.gait.scene == digest_of(scene, imitation)


@pytest.mark.long
@pytest.mark.parametrize("told", [0.8, 1.6])
def test_the_policy_on_peoples_feet_walks_as_fast_as_it_is_told(told, tmp_path):
    write("policies", tmp_path)
    scene = msgspec.structs.replace(load(str(tmp_path / "gait2392_arms_feet.toml")), duration=6.0)
    learned = learned_in(tmp_path / "gait2392_arms_feet.h5")
    task = lasting(commanded(task_of(learned), [f"speed={told}", "turning_rate=0"]))
    recording, status = replay(learned.policy, scene, "cpu", task)
    assert status == Status.COMPLETED
    assert recording.com_velocity[recording.time >= 2.0, 2].mean() == pytest.approx(told, abs=0.06)


@pytest.mark.long
def test_the_policy_that_runs_flies_twice_a_stride_and_bends_its_knees_as_runners_do(tmp_path):
    write("policies", tmp_path)
    scene = msgspec.structs.replace(load(str(tmp_path / "gait2392_run_by_policy.toml")), duration=4.0)
    learned = learned_in(tmp_path / "gait2392_run_by_policy.h5")
    task = lasting(commanded(task_of(learned), ["speed=3", "turning_rate=0"]))
    recording, status = replay(learned.policy, scene, "cpu", task)
    assert status == Status.COMPLETED
    measures = gait_measures(recording, scene)
    assert measures["speed"] == pytest.approx(2.97, abs=0.1)
    assert measures["flight"] > 19.0
    assert 1.8 < measures["maximum vertical force"] < 2.9
    assert measures["knee, maximum in swing"] > 80.0
    assert (tmp_path / "gait2392_run_by_policy.h5").stat().st_size < 800_000


def test_the_policy_for_stairs_walks_over_bumps_of_five_centimetres(tmp_path):
    write("course", tmp_path)
    scene = msgspec.structs.replace(load(str(tmp_path / "walk56_stairs.toml")), duration=3.0)
    scene.commands["height"].value, scene.commands["kind"].value, scene.commands["place"].value = 1.0, 4.0, 2.1
    learned = learned_in(tmp_path / "walk56_stairs.h5")
    task = lasting(commanded(task_of(learned), ["speed=1", "turning_rate=0"]))
    recording, status = replay(learned.policy, scene, "cpu", task)
    assert status == Status.COMPLETED
    assert recording.com_velocity[100:, 2].mean() == pytest.approx(1.0, abs=0.15)
    assert (tmp_path / "walk56_stairs.h5").stat().st_size < 600_000


def test_the_policy_for_the_course_climbs_three_stairs_of_seventeen_centimetres(tmp_path):
    write("course", tmp_path)
    scene = msgspec.structs.replace(load(str(tmp_path / "walk56_course.toml"), trust=True), duration=2.8)
    scene.commands["height"].value, scene.commands["kind"].value, scene.commands["place"].value = 1.0, 0.0, 0.5
    learned = learned_in(tmp_path / "walk56_course.h5")
    task = lasting(commanded(task_of(learned), ["speed=0.8", "turning_rate=0"]))
    recording, status = replay(learned.policy, scene, "cpu", task)
    assert status == Status.COMPLETED
    assert recording.com[-1, 1] - recording.com[0, 1] == pytest.approx(3 * 0.17, abs=0.06)
    assert (tmp_path / "walk56_course.h5").stat().st_size < 600_000


def test_a_policy_moves_a_scene_as_long_as_the_scene_lasts(tmp_path):
    write("policies", tmp_path)
    scene = msgspec.structs.replace(load(str(tmp_path / "walk56_tasks.toml")), duration=2.0)
    learned = learned_in(tmp_path / "walk56_tasks.h5")
    task = msgspec.structs.replace(commanded(task_of(learned), ["speed=1.2", "turning_rate=0"]), episode_time=1.0)
    short, long = (replay(learned.policy, scene, "cpu", one)[0] for one in (task, lasting(task)))
    assert short.time[-1] == pytest.approx(1.0, abs=0.02)
    assert long.time[-1] == pytest.approx(2.0, abs=0.02)


def test_what_a_policy_is_told_is_said_in_words(tmp_path):
    write("policies", tmp_path)
    task = task_of(learned_in(tmp_path / "walk56_tasks.h5"))
    assert commands_in_words(task) == "speed drawn every 5 s from 0.7 to 1.8 m/s, turning_rate 0 rad/s"
    assert commands_in_words(commanded(task, ["speed=1.3"])) == "speed 1.3 m/s, turning_rate 0 rad/s"


def test_a_policy_that_learnt_by_symmetry_moves_a_body_with_a_weak_muscle(tmp_path):
    write("policies", tmp_path)
    scene = msgspec.structs.replace(load(str(tmp_path / "walk56_by_command.toml")), duration=1.0)
    scene.character.muscles["lVAS"].f_max *= 0.5
    learned = learned_in(tmp_path / "walk56_by_command.h5")
    task = commanded(task_of(learned), ["speed=1.2", "turning_rate=0"])
    assert task.symmetric
    recording, _ = replay(learned.policy, scene, "cpu", task)
    assert recording.time[-1] > 0.5
