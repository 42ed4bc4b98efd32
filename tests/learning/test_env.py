"""The learning environment as tensors: shapes, ends of episodes, the same bits in every slot and batch."""

from functools import cache

import msgspec
import pytest

torch = pytest.importorskip("torch", reason="the extra `learn` is not installed")

from warpmuscle.core.errors import RolloutError  # noqa: E402
from warpmuscle.formats import load  # noqa: E402
from warpmuscle.learning import RolloutEnv, Task, Variation  # noqa: E402
from warpmuscle.learning.episodes import PARTS  # noqa: E402

STILL = Task(variation=Variation(velocity_noise=0.0), episode_time=0.1)


@cache
def env_of(count: int) -> RolloutEnv:
    return RolloutEnv("reflex_planar", count, "cpu", STILL, threads=1)


def actions(steps: int, count: int) -> torch.Tensor:
    return torch.randn((steps, count, env_of(3).num_actions), generator=torch.Generator().manual_seed(3))


def test_a_decision_gives_the_same_tensors_of_the_sizes_that_are_told():
    env = env_of(3)
    observation = env.reset(0)
    again, reward, terminated, truncated = env.step(actions(1, 3)[0])
    assert again is observation
    assert observation.shape == (3, env.num_observations) == (3, len(env.observation_names))
    assert reward.shape == terminated.shape == truncated.shape == (3,)
    assert terminated.dtype == truncated.dtype == torch.bool
    assert env.critic_observation.shape == (3, len(env.critic_names))
    assert env.dt == pytest.approx(0.01)


def test_actions_of_another_shape_are_refused_in_one_line():
    with pytest.raises(RolloutError, match=r"actions have shape \(3, 2\); this environment takes \(3, 14\)"):
        env_of(3).step(torch.zeros(3, 2))


def test_an_episode_that_is_long_enough_is_truncated_and_the_next_one_begins_within_the_step():
    env = env_of(3)
    first = env.reset(0).clone()
    for step in range(1, 11):
        observation, _, terminated, truncated = env.step(actions(10, 3)[step - 1])
        assert not terminated.any()
        assert truncated.all() == (step == 10)
    assert torch.equal(observation, first)  # of the next episode
    assert not torch.equal(env.final_observation, first)  # of the one that ended
    assert (env.episode_length == 0).all()
    assert env.log["time"] == pytest.approx(0.1)
    assert env.log["completed"] == 1.0


def test_the_same_actions_give_the_same_bits_in_every_slot_and_batch():
    one = actions(15, 1)
    seen = []
    for count in (1, 3):
        env = env_of(count)
        env.reset(0)
        rows = []
        for action in one:
            observation, reward, _, _ = env.step(action.expand(count, -1))
            rows.append(torch.cat([observation, reward[:, None]], dim=1).clone())
        seen.append(torch.stack(rows))
    assert torch.equal(seen[1][:, 0], seen[1][:, 2])
    assert torch.equal(seen[0][:, 0], seen[1][:, 1])


def test_a_state_that_is_put_back_goes_on_in_the_same_way():
    env = env_of(3)
    told = actions(20, 3)
    env.reset(5)
    for action in told[:5]:
        env.step(action)
    state = env.state_dict()
    expected = [env.step(action)[0].clone() for action in told[5:]]
    env.reset(9)
    env.load_state_dict(state)
    for action, observation in zip(told[5:], expected, strict=True):
        assert torch.equal(env.step(action)[0], observation)
    with pytest.raises(RolloutError, match="another scene, task or number of instances"):
        env_of(1).load_state_dict(state)


def test_the_parts_of_a_decision_are_told_as_they_end():
    env, ended = env_of(3), []
    env.batch.step(mark=ended.append)
    assert list(dict.fromkeys(ended)) == list(PARTS)


def test_a_scene_says_what_is_learned_in_it_unless_another_task_is_given():
    scene = msgspec.structs.replace(load("reflex_planar"), learning=Task(speed=(0.5, 0.5), variation=STILL.variation))
    env = RolloutEnv(scene, 1, "cpu", threads=1)
    assert env.commands.tolist() == [[0.5, 0.0]]
    assert env.scene.learning == env.task
    assert RolloutEnv(scene, 1, "cpu", STILL, threads=1).commands[0, 0] == pytest.approx(1.2)
