"""The adapter for rsl_rl: its runner learns on it, and gets what it asks for."""

import copy

import pytest

pytest.importorskip("rsl_rl", reason="the extra `learn` is not installed")

import torch
from rsl_rl.runners import OnPolicyRunner

from warpmuscle.learning import RolloutEnv, Task
from warpmuscle.learning.rsl_rl import RslRlEnv

NETWORK = {"class_name": "MLPModel", "hidden_dims": [16], "activation": "elu", "obs_normalization": True}
SETTINGS = {
    "num_steps_per_env": 8,
    "save_interval": 100,
    "obs_groups": {"actor": ["policy"], "critic": ["policy", "critic"]},
    "actor": NETWORK | {"distribution_cfg": {"class_name": "GaussianDistribution", "init_std": 0.3}},
    "critic": dict(NETWORK),
    "algorithm": {
        "class_name": "PPO", "num_learning_epochs": 2, "num_mini_batches": 2, "learning_rate": 1e-3, "gamma": 0.99,
        "lam": 0.95, "clip_param": 0.2, "entropy_coef": 0.0, "value_loss_coef": 1.0, "max_grad_norm": 1.0,
        "schedule": "adaptive", "desired_kl": 0.01, "use_clipped_value_loss": True,
    },
}  # fmt: skip


@pytest.fixture(scope="module")
def env() -> RslRlEnv:
    return RslRlEnv(RolloutEnv("reflex_planar", 4, "cpu", Task(episode_time=0.05), threads=1))


def test_a_runner_of_rsl_rl_learns_and_changes_the_policy(env: RslRlEnv):
    runner = OnPolicyRunner(env, copy.deepcopy(SETTINGS), log_dir=None, device="cpu")
    before = [p.clone() for p in runner.alg.get_policy().parameters()]
    runner.learn(2, init_at_random_ep_len=True)
    after = list(runner.alg.get_policy().parameters())
    assert any(not torch.equal(a, b) for a, b in zip(before, after, strict=True))
    assert all(torch.isfinite(p).all() for p in after)


def test_observations_of_a_step_stay_as_they_are_in_the_next_one(env: RslRlEnv):
    before, kept = env.get_observations(), env.env.observation.clone()
    env.step(torch.ones(4, env.num_actions))
    assert torch.equal(before["policy"], kept)
    assert not torch.equal(env.get_observations()["policy"], kept)


def test_ends_by_time_are_told_apart_from_failures(env: RslRlEnv):
    env.env.reset(0)
    for _ in range(4):
        *_, dones, extras = env.step(torch.zeros(4, env.num_actions))
        assert not dones.any()
    *_, dones, extras = env.step(torch.zeros(4, env.num_actions))
    assert dones.all()
    assert extras["time_outs"].all()
    env.episode_length_buf = torch.tensor([3, 4, 0, 0])
    *_, dones, extras = env.step(torch.zeros(4, env.num_actions))
    assert dones.tolist() == [False, True, False, False]
    assert env.episode_length_buf.tolist() == [4, 0, 1, 1]
