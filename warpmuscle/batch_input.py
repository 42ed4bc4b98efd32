"""What a batch is asked for, checked: how many instances, which of them to record, values, noise, and times."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.arrays import Floats
from warpmuscle.errors import RolloutError
from warpmuscle.scene import Scene

CHUNK_TIME = 0.1  # s of simulated time between two looks at which instances still run
LINEAR_SPEEDS = {"free": 3, "planar": 2, "fixed": 0}  # of the root, by its joint


def positive(value: int, what: str) -> int:
    """A positive whole number; RolloutError if it is none."""
    if value != int(value) or value < 1:
        raise RolloutError(f"{what} must be a positive whole number, not {value}")
    return int(value)


def chosen(record: Sequence[int], instances: int) -> list[int]:
    """Instances to record, each once; RolloutError if there is no such instance."""
    wrong = [i for i in record if not 0 <= i < instances]
    if wrong:
        raise RolloutError(f"cannot record instance {wrong[0]} of {instances}")
    return list(dict.fromkeys(record))


def checked_values(values: ArrayLike, instances: int, count: int) -> Floats:
    """Parameter values as (instances, count) or (count,); RolloutError if they are not, or not finite."""
    array = np.asarray(values, dtype=np.float64)
    if array.shape not in ((count,), (instances, count)):
        raise RolloutError(
            f"parameters have shape {array.shape}; this rollout takes ({instances}, {count}) or ({count},)"
        )
    if not np.isfinite(array).all():
        raise RolloutError("a parameter value is not a finite number")
    return array


def root_noise(scene: Scene, instances: int, deviation: float, seed: int) -> Floats:
    """Noise for the linear speeds of the root, m/s: a row an instance, or one row of zeros if there is none."""
    linear = LINEAR_SPEEDS[scene.character.root_joint]
    if not deviation:
        return np.zeros((1, linear))
    return np.random.default_rng(seed).normal(0.0, deviation, (instances, linear))


def chunk_steps(scene: Scene) -> int:
    """Steps between two looks at which instances still run."""
    return max(round(CHUNK_TIME / scene.time_step), 1)


def end_step(batch: Any, duration: float | None) -> int:
    """The step at which a batch that runs on for a duration, s, ends; RolloutError if that is no time."""
    if duration is None:
        return int(batch.steps)
    if not 0.0 <= duration < math.inf:
        raise RolloutError(f"duration must be a finite number of seconds, not {duration}")
    return int(min(batch.steps_done + round(duration / batch.scene.time_step), batch.steps))
