"""Lets a policy act in an environment, and keeps what it meets with on the device."""

from __future__ import annotations

from typing import Any, Protocol

import torch
from torch import Tensor

from warpmuscle.learning.networks.actor_critic import ActorCritic
from warpmuscle.learning.networks.ppo import Experience
from warpmuscle.learning.options import PPOOptions
from warpmuscle.learning.symmetry import Images

COUNTED = ("episodes", "reward")
LOGGED = ("time", "completed", "speed", "return", "hardness", "push_hardness")  # of the environment's log


class Environment(Protocol):
    """What learning needs of an environment, whose arrays stay on the device; see `env.RolloutEnv`."""

    num_envs: int
    num_observations: int
    num_actions: int
    dt: float  # s, that a decision takes
    observation_names: tuple[str, ...]
    action_names: tuple[str, ...]
    critic_names: tuple[str, ...]
    action_range: tuple[float, float] | None  # beyond which actions do what its ends do; None: nowhere
    muscle_shares: Tensor | None  # (actions,) of muscles in the mass of all, where actions excite them
    images: Images | None  # of observations and actions in a mirror

    @property
    def critic_observation(self) -> Tensor:
        """(n, C) what the critic sees."""

    @property
    def log(self) -> dict[str, Tensor]:
        """Means over the last episodes, by name; those of `LOGGED` among them."""

    def reset(self) -> Tensor:
        """Start all episodes; (n, O) the first observations."""

    def tighten(self, decisions: int) -> None:
        """Let limits of failure be those after so many decisions of all instances together."""

    def step(self, actions: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Observations, rewards, and who has failed and whose time is up; those start again."""

    def state_dict(self) -> dict[str, Any]:
        """Where all instances stand."""

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Go on from where they stood."""


class Collector:
    """Lets a policy act for some steps.

    Attributes:
        experience: of the last `collect`. last: (n,) the critic's value of the states after it.
        noise: (T, n, actions) of unit deviation, to be drawn before `collect`.
        counted: sums over the last `collect`, in the order of `COUNTED`: of episodes that ended, and of rewards.
        logged: what the environment's log says after it, in the order of `LOGGED`.
    """

    def __init__(self, env: Environment, networks: ActorCritic, options: PPOOptions) -> None:
        """Begin all episodes."""
        self.env, self.networks = env, networks
        self._discount, steps = options.discount, options.steps
        self._scale = options.reward_time / env.dt * (1.0 - options.discount)
        self.observation = env.reset()
        device, n = self.observation.device, env.num_envs
        privileged = env.critic_observation.shape[1]
        self.experience = Experience.empty(steps, n, env.num_observations, privileged, env.num_actions, device)
        self.noise = torch.zeros_like(self.experience.action)
        self.last = torch.zeros(n, device=device)
        self.counted = torch.zeros(len(COUNTED), device=device)
        self.logged = torch.zeros(len(LOGGED), device=device)

    def collect(self) -> None:
        """Act for the steps of the experience."""
        with torch.no_grad():
            self.counted.zero_()
            for t in range(len(self.noise)):
                self._act(t)
            self._end()

    def _end(self) -> None:
        """What is known after the last step."""
        self.last.copy_(self.networks.judge(self.env.critic_observation))
        log = self.env.log
        self.logged.copy_(torch.stack([log[name] for name in LOGGED]))

    def _act(self, t: int) -> None:
        seen, networks = self.experience, self.networks
        seen.observation[t].copy_(self.observation)
        seen.privileged[t].copy_(self.env.critic_observation)
        mean = networks.act(seen.observation[t])
        action = mean + torch.exp(networks.log_deviation) * self.noise[t]
        value = networks.judge(seen.privileged[t])
        seen.mean[t].copy_(mean)
        seen.action[t].copy_(action)
        seen.value[t].copy_(value)
        seen.likelihood[t].copy_(networks.log_likelihood(mean, action))
        self.observation, reward, failed, ended = self.env.step(seen.action[t])
        done, whole = (failed | ended).float(), (ended & ~failed).float()
        seen.done[t].copy_(done)
        # What would have come after an episode whose time was up is about what was expected before its last step.
        seen.reward[t].copy_(reward * self._scale + self._discount * value * whole)
        self.counted.add_(torch.stack([done.sum(), reward.sum()]))
