"""The learning environment as skrl wants it."""

from __future__ import annotations

from typing import Any

import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.learning.env import RolloutEnv

try:
    from gymnasium.spaces import Box
    from skrl.envs.wrappers.torch import Wrapper
except ModuleNotFoundError as error:
    raise Error("learning with skrl needs it: pip install skrl") from error


class SkrlEnv(Wrapper):  # type: ignore[misc]
    """A `RolloutEnv` for agents and trainers of skrl 2: `SkrlEnv(RolloutEnv("walk56", 4096))`, already wrapped.

    Attributes:
        env: the environment.
    """

    def __init__(self, env: RolloutEnv) -> None:
        """Take an environment, whose episodes go on from where they are."""
        super().__init__(env)
        self.env = env

    @property
    def num_envs(self) -> int:
        return self.env.num_envs

    @property
    def num_agents(self) -> int:
        return 1

    @property
    def observation_space(self) -> Any:
        return _box(self.env.num_observations)

    @property
    def state_space(self) -> Any:
        return _box(len(self.env.critic_names))

    @property
    def action_space(self) -> Any:
        return _box(self.env.num_actions)

    def reset(self) -> tuple[Any, dict[str, Any]]:
        """Begin all episodes anew."""
        return self.env.reset().clone(), {}

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Make a decision: observations, then rewards, terminated and truncated as columns, and what is logged."""
        observation, reward, terminated, truncated = self.env.step(actions)
        columns = (one.clone()[:, None] for one in (reward, terminated, truncated))
        return observation.clone(), *columns, {"episode": self.env.log}

    def state(self) -> Any:
        """What a critic may know."""
        return self.env.critic_observation.clone()

    def render(self, *args: Any, **kwargs: Any) -> None:
        """Draw nothing; `warpmuscle view` shows policies."""

    def close(self) -> None:
        """Nothing is held that would have to be closed."""


def _box(numbers: int) -> Any:
    return Box(-np.inf, np.inf, (numbers,), np.float32)
