"""A batch that acts, and is observed and rewarded, as the `[learning]` of its scene says; what environments show of it.

The numbers are those of `learning.RolloutEnv`, to the bit: observations with their delays and noise, rewards, and ends
of episodes. They come without PyTorch, as arrays of NumPy.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from gymnasium.spaces import Box
from numpy.typing import NDArray

from warpmuscle.core.errors import Error
from warpmuscle.core.status import Status
from warpmuscle.gym.pictures import Pictures
from warpmuscle.learning.actions import HUGE_ACTION
from warpmuscle.learning.episodes import LARGEST_SEED, EpisodeBatch
from warpmuscle.scene import Scene
from warpmuscle.scene.learning import Task

WIDEST = 3.0  # of the space of actions where more always does more

Array = NDArray[np.float32]
Flags = NDArray[np.bool_]


class TaskBatch:
    """Episodes of a task in a scene, as both environments want them; see `biped.Bipeds`, which has none.

    Attributes:
        batch: the episodes. rollout: its own. dt: s, that a decision lasts.
        action_space: as far as actions do anything, or -3 to 3; beyond it they count as they are.
        observation_space: of any size. observation_names, action_names: of the numbers.
    """

    def __init__(self, count: int, scene: Scene, device: str | None, threads: int | None, task: Task) -> None:
        """Prepare the batch; raises as `EpisodeBatch`."""
        self.batch = batch = EpisodeBatch(scene, count, device, task, threads=threads)
        self.rollout, self.dt = batch.rollout, batch.dt
        self.observation_names, self.action_names = tuple(batch.senses.names), batch.actions.names
        low, high = action_ends(batch.actions.range)
        self.action_space = Box(low, high, (len(self.action_names),), np.float32)
        self.observation_space = Box(-np.inf, np.inf, (len(self.observation_names),), np.float32)
        self._shape = (count, len(self.action_names))
        self._seeded = False
        self._pictures: Pictures | None = None

    def reset(self, seed: int | None, random: np.random.Generator) -> None:
        """Begin all episodes: with a seed those of `RolloutEnv.reset(seed)`, else others each time."""
        if seed is None and not self._seeded:
            seed = int(random.integers(LARGEST_SEED))
        self._seeded = True
        self.batch.reset(None if seed is None else int(seed) % (LARGEST_SEED + 1))

    def start(self, mask: Flags, random: np.random.Generator) -> None:
        """Begin the next episode of instances."""
        self.batch.begin(mask)

    def observed(self) -> Array:
        """(instances, numbers) float32, an array of its own."""
        return np.array(self.batch.senses.observation.numpy())

    def act(self, actions: Any) -> tuple[Array, Flags, Flags]:
        """Rewards, terminated and truncated, (instances,), of a decision; raises Error for another shape."""
        values = np.asarray(actions, dtype=np.float32)
        if values.shape != self._shape:
            raise Error(f"actions have shape {values.shape}; this environment takes {self._shape}")
        batch, gains = self.batch, self.batch.judge.gains
        wp.copy(batch.actions.requested, wp.array(values, dtype=float, device="cpu"))
        batch.step(restart=False)
        reward, terminated, truncated = (np.array(a.numpy()) for a in (gains.reward, gains.terminated, gains.truncated))
        return reward, terminated, truncated

    def status(self) -> NDArray[np.int32]:
        """How every instance is, see `Status`; who has lasted for its whole episode has completed it."""
        status = np.array(self.rollout.state.status.numpy())
        late = self.batch.judge.gains.truncated.numpy()
        return np.asarray(np.where(late & (status == Status.RUNNING), Status.COMPLETED, status), dtype=np.int32)

    def picture(self) -> NDArray[np.uint8]:
        """The first instance as it stands, (480, 640, 3); raises Error without the extra `video`."""
        self._pictures = self._pictures or Pictures(self.rollout)
        return self._pictures.of(self.rollout)


def action_ends(known: tuple[float, float] | None) -> tuple[float, float]:
    """Ends of the space of actions that do nothing more beyond these two, if there are any."""
    low, high = known or (-HUGE_ACTION, HUGE_ACTION)
    reaches_down, reaches_up = low <= -HUGE_ACTION, high >= HUGE_ACTION
    return (
        -WIDEST + (0.0 if reaches_up else min(high, 0.0)) if reaches_down else low,
        WIDEST + (0.0 if reaches_down else max(low, 0.0)) if reaches_up else high,
    )
