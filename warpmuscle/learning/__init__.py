"""Learning on a device: episodes of many instances at once, with observations, actions and rewards of a task.

`EpisodeBatch` needs Warp alone; `RolloutEnv` shows it as tensors of PyTorch, which the extra `learn` brings.

May import: core, kernels, scene, results, model, formats, gait, simulation.
To add: an observation to `senses`, and to `kernels.learning.senses`, which computes it; a reward to
`kernels.objective.objective_terms`, and its value to `kernels.learning.rewards.task_terms`; a way to act to `actions`;
what differs between episodes to `starts`; another library's interface to a file of its name.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from warpmuscle.scene.learning import Imitation, Rewards, Sense, Task, Tightening, Variation

if TYPE_CHECKING:
    from warpmuscle.learning.env import RolloutEnv
    from warpmuscle.learning.episodes import EpisodeBatch

__all__ = ["EpisodeBatch", "Imitation", "Rewards", "RolloutEnv", "Sense", "Task", "Tightening", "Variation"]

_HOMES = {"EpisodeBatch": "episodes", "RolloutEnv": "env"}


def __getattr__(name: str) -> Any:
    """Import what is asked for; a task alone needs neither Warp nor PyTorch."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
