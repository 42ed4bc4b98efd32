"""The adapter for Stable-Baselines3: its algorithms learn on it, and it gives what the batch gives."""

import subprocess
import sys

import msgspec
import numpy as np
import pytest

from warpmuscle.core.errors import Error
from warpmuscle.formats import load
from warpmuscle.gym.biped import BipedVectorEnv
from warpmuscle.learning import Task

LASTING = 5  # decisions of an episode


def batch(count: int = 4, **more: object) -> BipedVectorEnv:
    scene = msgspec.structs.replace(load("reflex_planar"), learning=Task(episode_time=0.01 * LASTING))
    return BipedVectorEnv(count, scene, "cpu", **more)


def test_its_algorithms_learn_on_the_batch():
    pytest.importorskip("stable_baselines3", reason="stable_baselines3 is not installed")
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecMonitor, VecNormalize

    from warpmuscle.gym.sb3 import Sb3Env

    env = VecNormalize(VecMonitor(Sb3Env(batch())))
    model = PPO("MlpPolicy", env, n_steps=8, batch_size=16, n_epochs=2, seed=1, device="cpu")
    before = [p.detach().clone() for p in model.policy.parameters()]
    model.learn(64)
    after = list(model.policy.parameters())
    assert any(not torch.equal(a, b) for a, b in zip(before, after, strict=True))
    assert all(torch.isfinite(p).all() for p in after)
    assert [episode["l"] for episode in model.ep_info_buffer] == [LASTING] * (4 * (16 // LASTING))


def test_it_gives_the_numbers_of_the_batch_and_the_last_observation_of_an_episode():
    pytest.importorskip("stable_baselines3", reason="stable_baselines3 is not installed")
    from warpmuscle.gym.sb3 import Sb3Env

    env, other = Sb3Env(batch(2)), batch(2)
    env.seed(7)
    np.testing.assert_array_equal(env.reset(), other.reset(seed=7)[0])
    for k, action in enumerate(np.random.default_rng(1).normal(size=(LASTING + 1, 2, 14))):
        observed, reward, ended, infos = env.step(action)
        expected = other.step(action)
        np.testing.assert_array_equal(observed, expected[0])
        np.testing.assert_array_equal(reward, expected[1])
        assert ended.all() == (k == LASTING - 1)
        for instance, info in enumerate(infos):
            assert set(info) == ({"terminal_observation", "TimeLimit.truncated"} if ended[instance] else set())
            if ended[instance]:
                assert info["TimeLimit.truncated"]
                np.testing.assert_array_equal(info["terminal_observation"], expected[4]["final_obs"][instance])
    assert env.get_attr("num_envs", [0]) == [2]
    assert env.get_images() == (None,)
    with pytest.raises(Error, match='autoreset_mode="same_step" alone'):
        Sb3Env(batch(1, autoreset_mode="next_step"))


def test_who_has_it_not_is_told_what_to_install():
    code = "import sys; sys.modules['stable_baselines3'] = None; import warpmuscle.gym.sb3"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False).stderr
    assert 'learning with Stable-Baselines3 needs it: pip install "warpmuscle[sb3]"' in said
