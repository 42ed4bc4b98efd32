"""The learning environment as rsl_rl wants it."""

from __future__ import annotations

from typing import Any

from warpmuscle.core.errors import Error
from warpmuscle.learning.env import RolloutEnv

try:
    from rsl_rl.env import VecEnv
    from tensordict import TensorDict
except ModuleNotFoundError as error:
    raise Error('learning with rsl_rl needs it: pip install "warpmuscle[learn]"') from error

LOG_EVERY = 24  # decisions; what is logged are means over episodes, which change slowly


class RslRlEnv(VecEnv):  # type: ignore[misc]
    """A `RolloutEnv` for runners of rsl_rl 5: `OnPolicyRunner(RslRlEnv(RolloutEnv("walk56", 4096)), ...)`.

    Groups of observations are `policy`, and `critic`, what only the simulation knows. Episodes that were long enough
    are told by `extras["time_outs"]`, means over episodes by `extras["log"]`.

    Attributes:
        env: the environment. num_envs, num_actions, max_episode_length, device: its own. cfg: its task, as a table.
    """

    def __init__(self, env: RolloutEnv) -> None:
        """Take an environment, whose episodes go on from where they are."""
        self.env, self.cfg = env, env.settings
        self.num_envs, self.num_actions, self.device = env.num_envs, env.num_actions, env.device
        self.max_episode_length = env.max_episode_length
        self._decisions = 0

    @property
    def episode_length_buf(self) -> Any:
        """Decisions of the present episodes, (num_envs,)."""
        return self.env.episode_length

    @episode_length_buf.setter
    def episode_length_buf(self, values: Any) -> None:
        self.env.episode_length.copy_(values)

    def get_observations(self) -> TensorDict:
        """What is observed now, in tensors of its own."""
        groups = {"policy": self.env.observation.clone(), "critic": self.env.critic_observation.clone()}
        return TensorDict(groups, batch_size=[self.num_envs], device=self.device)

    def step(self, actions: Any) -> tuple[TensorDict, Any, Any, dict[str, Any]]:
        """Make a decision: observations, rewards, whether episodes ended, and what else rsl_rl asks for."""
        _, reward, terminated, truncated = self.env.step(actions)
        extras: dict[str, Any] = {"time_outs": truncated.clone()}
        if self._decisions % LOG_EVERY == 0:
            extras["log"] = {f"/{name}": value for name, value in self.env.log.items()}
        self._decisions += 1
        return self.get_observations(), reward.clone(), terminated | truncated, extras
