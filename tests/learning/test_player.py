"""What is said of policies that are told, or put into, what they have not learnt; PyTorch is not needed."""

import re
from dataclasses import replace

import pytest

from small_policy import learning_curve, random_policy, small_policy
from small_result import no_parameters
from warpmuscle.core.errors import Error, ResultError, RolloutError, SceneError
from warpmuscle.learning import EpisodeBatch, Sense, Task
from warpmuscle.learning.player import Player, beyond, learned_in
from warpmuscle.optimization.best_scene import scene_in
from warpmuscle.results.learned import Learned, PolicyTable
from warpmuscle.results.records import Result
from warpmuscle.results.result import read, write

TASK = Task(speed=(0.8, 1.6))


@pytest.fixture(scope="module")
def policy() -> PolicyTable:
    return replace(random_policy("reflex_planar", TASK).policy, scene="reaching")


def test_commands_beyond_what_was_learnt_are_named_with_what_was():
    task = Task(speed=(0.8, 1.6), pose={"shoulder": (-0.5, 1.5)})
    assert beyond(task, ["speed=1.6", "shoulder=-0.5", "turning_rate=0"]) == []
    said = beyond(task, ["shoulder=2.2", "speed=1", "turning_rate=0.1"])
    assert said == [
        "shoulder = 2.2 rad or m: the policy has learnt -0.5 to 1.5; what it does is anyone's guess",
        "turning_rate = 0.1 rad/s: the policy has learnt 0 alone; what it does is anyone's guess",
    ]
    with pytest.raises(Error, match="of this policy KEY is speed, turning_rate, shoulder"):
        beyond(task, ["hip=1"])


def test_a_policy_in_a_foreign_scene_is_refused_with_the_names_of_both(policy: PolicyTable):
    whose = "the policy was learnt for the scene reaching, not for "
    with pytest.raises(RolloutError, match=whose + r"fwalk: learning\.actions: muscles drive no joint"):
        Player(policy, "fwalk", 1, "cpu", TASK)
    with pytest.raises(RolloutError, match=whose + r"reflex_planar: learning\.pose\.shoulder: there is no coordinate"):
        Player(policy, "reflex_planar", 1, "cpu", Task(pose={"shoulder": (0.0, 1.0)}))
    with pytest.raises(RolloutError, match=whose + "reflex_planar: it observes 'trunk.height', which is not there"):
        Player(policy, "reflex_planar", 1, "cpu", Task(observations={"coordinates": Sense()}))
    with pytest.raises(SceneError, match=r"^learning\.pose\.shoulder: there is no coordinate"):
        Player(replace(policy, scene=""), "reflex_planar", 1, "cpu", Task(pose={"shoulder": (0.0, 1.0)}))


def test_a_file_says_in_which_scene_its_policy_was_learnt(tmp_path):
    learned = random_policy("reflex_planar", TASK)
    write(tmp_path / "p.h5", Result('name = "reaching"\n', "cpu", "", 0, no_parameters(), learned=learned))
    found = read(tmp_path / "p.h5").learned
    assert found is not None
    assert found.policy.scene == "reaching"


def test_what_is_wrong_with_a_task_or_a_scene_in_a_file_is_said_with_the_file(tmp_path):
    path = tmp_path / "p.h5"
    learned = Learned(small_policy(), '{"decision_time": -1.0}', learning_curve(1), {})
    write(path, Result('name = "x"\ngravity = "none"\n', "cpu", "", 0, no_parameters(), learned=learned))
    wrong = r"damaged result file: the task of its policy: learning\.decision_time: must be greater than 0, is -1"
    with pytest.raises(ResultError, match=f"^{re.escape(str(path))}: {wrong}"):
        learned_in(path)
    with pytest.raises(SceneError, match=f"^{re.escape(str(path))}, its scene:2: gravity: expected a number"):
        scene_in(read(path))


def test_what_a_critic_may_know_has_a_name_of_its_own_each():
    senses = EpisodeBatch("reflex_planar", 1, "cpu", TASK, threads=1).senses
    assert len(set(senses.critic_names)) == len(senses.critic_names) == senses.critic.shape[1]
    assert set(senses.names) <= set(senses.critic_names)
    assert "disturbance.push.x" in senses.critic_names
