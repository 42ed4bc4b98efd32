"""The adapter for skrl: its runner learns on it."""

import pytest

pytest.importorskip("skrl", reason="skrl is not installed")
torch = pytest.importorskip("torch", reason="the extra `learn` is not installed")

from skrl.utils.runner.torch import Runner  # noqa: E402

from warpmuscle.learning import RolloutEnv, Task  # noqa: E402
from warpmuscle.learning.skrl import SkrlEnv  # noqa: E402

NETWORK = [{"name": "net", "input": "OBSERVATIONS", "layers": [16], "activations": "elu"}]
SETTINGS = {
    "seed": 1,
    "models": {
        "separate": True,
        "policy": {"class": "GaussianMixin", "initial_log_std": -1.0, "network": NETWORK, "output": "ACTIONS"},
        "value": {"class": "DeterministicMixin", "network": NETWORK, "output": "ONE"},
    },
    "memory": {"class": "RandomMemory", "memory_size": -1},
    "agent": {
        "class": "PPO", "rollouts": 8, "learning_epochs": 2, "mini_batches": 2, "learning_rate": 1e-3,
        "experiment": {"write_interval": 0, "checkpoint_interval": 0},
    },
    "trainer": {"class": "SequentialTrainer", "timesteps": 16, "disable_progressbar": True},
}  # fmt: skip


def test_a_runner_of_skrl_learns_and_changes_the_policy(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # where it keeps its logs
    env = SkrlEnv(RolloutEnv("reflex_planar", 4, "cpu", Task(episode_time=0.05), threads=1))
    runner = Runner(env, SETTINGS)
    policy = runner.agent.models["policy"]
    before = [p.detach().clone() for p in policy.parameters()]
    runner.run("train")
    after = list(policy.parameters())
    assert any(not torch.equal(a, b) for a, b in zip(before, after, strict=True))
    assert all(torch.isfinite(p).all() for p in after)


def test_a_step_gives_columns_and_what_a_critic_may_know():
    env = SkrlEnv(RolloutEnv("reflex_planar", 3, "cpu", Task(episode_time=0.02), threads=1))
    env.reset()
    observation, reward, terminated, truncated, _ = env.step(torch.zeros(3, 14))
    assert observation.shape == (3, *env.observation_space.shape)
    assert env.state().shape == (3, *env.state_space.shape)
    assert reward.shape == terminated.shape == truncated.shape == (3, 1)
    assert not truncated.any()
    *_, truncated, info = env.step(torch.zeros(3, 14))
    assert truncated.all()
    assert info["episode"]["completed"] == 1.0
