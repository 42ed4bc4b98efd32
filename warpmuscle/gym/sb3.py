"""The batch as Stable-Baselines3 wants it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from warpmuscle.core.errors import Error
from warpmuscle.gym.biped import Array, BipedVectorEnv

try:
    from stable_baselines3.common.vec_env import VecEnv
except ModuleNotFoundError as error:
    raise Error('learning with Stable-Baselines3 needs it: pip install "warpmuscle[sb3]"') from error


class Sb3Env(VecEnv):  # type: ignore[misc]
    """A batch for algorithms of Stable-Baselines3: `PPO("MlpPolicy", Sb3Env(BipedVectorEnv(64, "walk56")))`.

    An episode that ends begins again in the same step. Its last observation is `infos[k]["terminal_observation"]`, and
    `infos[k]["TimeLimit.truncated"]` says whether it was just long enough.

    Attributes:
        env: the batch.
    """

    def __init__(self, env: BipedVectorEnv) -> None:
        """Take a batch, whose episodes begin anew by `reset`.

        Raises:
            Error: it begins episodes in the step after they have ended.
        """
        if env.metadata["autoreset_mode"] is not AutoresetMode.SAME_STEP:
            raise Error('Stable-Baselines3 takes environments with autoreset_mode="same_step" alone')
        self.env = env
        self._actions: Any = None
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)

    def reset(self) -> Array:
        """Begin all episodes anew; by the first seed of `seed`, if it has been called since the last time."""
        observed, _ = self.env.reset(seed=self._seeds[0])
        self.reset_infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        self._reset_seeds()
        self._reset_options()
        return observed

    def step_async(self, actions: Array) -> None:
        """Keep the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[Array, Array, NDArray[np.bool_], list[dict[str, Any]]]:
        """Act: observations, rewards, whose episodes ended, and what Stable-Baselines3 wants to know of that."""
        observed, reward, terminated, truncated, info = self.env.step(self._actions)
        ended = terminated | truncated
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for k in np.flatnonzero(ended):
            late = bool(truncated[k] and not terminated[k])
            infos[k] = {"terminal_observation": info["final_obs"][k], "TimeLimit.truncated": late}
        return observed, reward, ended, infos

    def close(self) -> None:
        """Let the batch go."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute of the batch, once for each instance asked for."""
        return [getattr(self.env, attr_name) for _ in self._chosen(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute of the batch, for all instances.

        Raises:
            Error: it is asked for of some instances alone.
        """
        if len(list(self._chosen(indices))) != self.num_envs:
            raise Error(f"{attr_name} is of the whole batch; it cannot be set for some instances")
        setattr(self.env, attr_name, value)

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        """What a method of the batch gives, called once, for each instance asked for."""
        value = getattr(self.env, method_name)(*method_args, **method_kwargs)
        return [value for _ in self._chosen(indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """No instance is wrapped."""
        return [False for _ in self._chosen(indices)]

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """The first instance as it stands, if pictures were asked for."""
        return self.env.render() or (None,)

    def _chosen(self, indices: Any) -> Iterable[int]:
        chosen: Iterable[int] = self._get_indices(indices)
        return chosen
