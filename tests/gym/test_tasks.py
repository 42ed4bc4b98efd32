"""Environments of scenes with `[learning]`: the numbers of the batch that learns, and of `RolloutEnv`, to the bit."""

import gymnasium
import msgspec
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

from warpmuscle.core.errors import Error
from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.gym.biped import BipedEnv, BipedVectorEnv
from warpmuscle.gym.tasks import TaskBatch, action_ends
from warpmuscle.learning import EpisodeBatch, Sense, Task, Variation
from warpmuscle.scene import Scene

SENSES = {
    "trunk": Sense(),
    "trunk_speed": Sense(),
    "command": Sense(),
    "speeds": Sense(delay=0.017, noise=0.1),
    "tendon_force": Sense(),
}
TASK = Task(
    speed=(0.8, 1.6), command_time=0.03, episode_time=0.07, observations=SENSES, variation=Variation(velocity_noise=0.2)
)
LASTING = 7  # decisions of an episode
MUSCLES = 14


def scene(task: Task | None = TASK) -> Scene:
    return msgspec.structs.replace(load("reflex_planar"), learning=task)


def told(decisions: int, count: int) -> np.ndarray:
    return np.random.default_rng(3).normal(0.0, 1.0, (decisions, count, MUSCLES)).astype(np.float32)


def test_what_is_seen_and_rewarded_is_that_of_the_episodes_step_for_step():
    env, batch = BipedVectorEnv(3, scene(), "cpu"), EpisodeBatch(scene(), 3, "cpu", threads=1)
    batch.reset(5)
    np.testing.assert_array_equal(env.reset(seed=5)[0], batch.senses.observation.numpy())
    assert env.bipeds.dt == batch.dt
    ends = 0
    for action in told(2 * LASTING + 2, 3):
        observed, reward, terminated, truncated, info = env.step(action)
        batch.actions.requested.assign(action)
        batch.step()
        gains = batch.judge.gains
        np.testing.assert_array_equal(observed, batch.senses.observation.numpy())
        np.testing.assert_array_equal(reward, gains.reward.numpy())
        np.testing.assert_array_equal(terminated, gains.terminated.numpy())
        np.testing.assert_array_equal(truncated, gains.truncated.numpy())
        for k in np.flatnonzero(terminated | truncated):
            np.testing.assert_array_equal(info["final_obs"][k], batch.final_observation.numpy()[k])
            assert info["final_info"]["status"][k] == Status.COMPLETED
            ends += 1
    assert ends == 6


def test_the_numbers_are_those_of_the_environment_of_pytorch():
    torch = pytest.importorskip("torch", reason="the extra `learn` is not installed")
    from warpmuscle.learning import RolloutEnv

    env, other = BipedVectorEnv(2, scene(), "cpu"), RolloutEnv(scene(), 2, "cpu", threads=1)
    np.testing.assert_array_equal(env.reset(seed=9)[0], other.reset(9).numpy())
    for action in told(LASTING + 2, 2):
        ours, theirs = env.step(action), other.step(torch.from_numpy(action))
        for one, another in zip(ours[:4], theirs, strict=True):
            np.testing.assert_array_equal(one, another.numpy())
    assert tuple(env.bipeds.observation_names) == other.observation_names


def test_a_single_one_ends_and_waits_and_passes_gymnasiums_checker():
    env, batch = BipedEnv(scene(), "cpu"), EpisodeBatch(scene(), 1, "cpu", threads=1)
    check_env(env, skip_render_check=True)
    batch.reset(2)
    np.testing.assert_array_equal(env.reset(seed=2)[0], batch.senses.observation.numpy()[0])
    for k, action in enumerate(told(LASTING, 1)):
        observed, _, terminated, truncated, info = env.step(action[0])
        assert (terminated, truncated) == (False, k == LASTING - 1)
        batch.actions.requested.assign(action)
        batch.step()
    np.testing.assert_array_equal(observed, batch.final_observation.numpy()[0])
    assert info["status"] == "COMPLETED"


def test_a_scene_without_a_task_is_as_before_and_so_is_one_whose_task_is_ignored():
    plain = BipedVectorEnv(1, scene(None), "cpu", frame_skip=10)
    ignored = BipedVectorEnv(1, scene(), "cpu", task=False, frame_skip=10)
    assert not isinstance(plain.bipeds, TaskBatch)
    np.testing.assert_array_equal(plain.reset(seed=1)[0], ignored.reset(seed=1)[0])
    given = BipedVectorEnv(1, scene(None), "cpu", task=TASK)
    assert given.bipeds.batch.command_names == ("speed", "turning_rate")


def test_settings_beside_a_task_are_refused_in_one_line():
    with pytest.raises(Error, match=r"frame_skip means nothing here: \[learning\] of reflex_planar says"):
        BipedEnv(scene(), "cpu", frame_skip=10)
    with pytest.raises(Error, match="speed_weight means nothing here: the task that is given"):
        BipedEnv(scene(None), "cpu", task=TASK, speed_weight=1.0)
    with pytest.raises(Error, match=r"actions have shape \(2,\); this environment takes \(1, 14\)"):
        BipedVectorEnv(1, scene(), "cpu").step(np.zeros(2))


@pytest.mark.usefixtures("unoptimized_test")
def test_the_space_of_actions_is_finite_and_reaches_as_far_as_actions_do_anything():
    box = BipedEnv(scene(), "cpu").action_space
    np.testing.assert_allclose([box.low[0], box.high[0]], [-0.25, 2.25], rtol=1e-6)  # clip(0.1 + 0.4 a, 0, 1)
    aimed = BipedEnv(scene(Task(actions="joint_targets")), "cpu").action_space
    assert (aimed.low[0], aimed.high[0]) == (-3.0, 3.0)


@pytest.mark.parametrize(
    ("known", "ends"),
    [
        (None, (-3.0, 3.0)),
        ((-10.0, 90.0), (-10.0, 90.0)),  # of excitations at a small scale
        ((-0.25, 1e6), (-0.25, 3.0)),  # of synergies
        ((5.0, 1e6), (5.0, 8.0)),
        ((-1e6, -5.0), (-8.0, -5.0)),
    ],
)
def test_ends_of_the_space_are_finite_and_in_order(known: tuple | None, ends: tuple):
    assert action_ends(known) == ends


def test_a_batch_with_a_task_is_drawn_as_it_stands():
    pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    env = BipedVectorEnv(1, scene(), "cpu", render_mode="rgb_array")
    env.reset(seed=1)
    env.step(told(1, 1)[0])
    (picture,) = env.render()
    assert picture.shape == (480, 640, 3)
    assert np.ptp(picture) > 0


@pytest.mark.parametrize("task", [TASK, None])
def test_in_the_next_step_many_begin_again_as_gymnasiums_own_do(task: Task | None):
    """But for what is drawn, which is one stream for all of them."""
    still = (
        None if task is None else msgspec.structs.replace(TASK, variation=Variation(velocity_noise=0.0), speed=(1, 1))
    )
    still = (
        None if still is None else msgspec.structs.replace(still, observations=SENSES | {"speeds": Sense(delay=0.017)})
    )
    given = msgspec.structs.replace(scene(still), duration=LASTING * 0.01)
    settings = {} if task else {"frame_skip": 10, "velocity_noise": 0.0}
    many = BipedVectorEnv(2, given, "cpu", autoreset_mode="next_step", **settings)
    singles = gymnasium.vector.SyncVectorEnv([lambda: BipedEnv(given, "cpu", **settings)] * 2)
    assert many.metadata["autoreset_mode"] == singles.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    np.testing.assert_array_equal(many.reset(seed=1)[0], singles.reset(seed=1)[0])
    ends = []
    for step, action in enumerate(told(2 * LASTING + 4, 2)):
        action = np.clip(action, -1.0, 1.0)
        ours, theirs = many.step(action), singles.step(action)
        for one, other in zip(ours[:4], theirs[:4], strict=True):
            np.testing.assert_allclose(one, other, atol=1e-7)
        ends += [step] if ours[3].all() else []
        assert "final_obs" not in ours[4]
    assert ends == [LASTING - 1, 2 * LASTING]


def test_wrappers_that_want_the_next_step_take_it():
    env = gymnasium.make_vec(
        "warpmuscle.gym:warpmuscle/Biped-v0", num_envs=3, scene=scene(), device="cpu", autoreset_mode="next_step"
    )
    env = gymnasium.wrappers.vector.NormalizeObservation(gymnasium.wrappers.vector.RecordEpisodeStatistics(env))
    env = gymnasium.wrappers.vector.NormalizeReward(env)
    env.reset(seed=1)
    for step, action in enumerate(told(LASTING + 2, 3)):
        observed, reward, _, _, info = env.step(action)
        assert np.isfinite(observed).all()
        assert np.isfinite(reward).all()
        if step == LASTING - 1:
            assert info["episode"]["l"].tolist() == [LASTING] * 3
    with pytest.raises(Error, match="there is no autoreset_mode 'later' here; known: same_step, next_step"):
        BipedVectorEnv(1, scene(), "cpu", autoreset_mode="later")


def test_others_are_drawn_without_a_seed_and_the_same_with_one():
    env = BipedVectorEnv(2, scene(), "cpu")
    one, again, other = env.reset(seed=2**40 + 3)[0], env.reset(seed=2**40 + 3)[0], env.reset()[0]
    np.testing.assert_array_equal(one, again)
    assert not np.array_equal(one, other)
    assert not np.array_equal(one[0], one[1])
