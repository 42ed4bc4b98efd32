"""How well a policy does: how many instances last, and how near they keep to the speed that is wanted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.formats import SceneLike
from warpmuscle.kernels.learning.rewards import COMPLETED, COUNT, DECISIONS, FORWARD
from warpmuscle.learning.player import Player
from warpmuscle.results.learned import PolicyTable
from warpmuscle.scene.joints import root_type
from warpmuscle.scene.learning import Task

NEAR = 0.1  # m/s, from the speed that is wanted


@dataclass(frozen=True)
class Evaluation:
    """How the first episodes of n instances went, whose actions were the policy's, without noise."""

    instances: int
    duration: float  # s, of a whole episode
    completed: float  # share that lasted it
    arrived: float  # share that did so with a mean speed within `NEAR` of the wanted one; as `completed` for no walkers
    speed: float  # m/s, mean over time and those that lasted it; 0 if none did
    speed_deviation: float  # m/s, standard deviation over them
    gain: float  # rewards of an episode, mean
    goes: bool  # whether there is a speed

    def __str__(self) -> str:
        lasted = round(self.completed * self.instances)
        text = f"{lasted} of {self.instances} last {self.duration:g} s, return {self.gain:.4g}"
        if not self.goes or not lasted:
            return text
        near = f"{100.0 * self.arrived:.1f} % within {NEAR:g} m/s of the speed wanted"
        return f"{text}, at {self.speed:.2f} ± {self.speed_deviation:.2f} m/s; {near}"


def evaluate(
    policy: PolicyTable,
    scene: SceneLike,
    instances: int,
    device: str | None = None,
    task: Task | None = None,
    seed: int = 1_000_003,
    threads: int | None = None,
) -> Evaluation:
    """Let a policy act in one episode of each instance.

    Args:
        seed: of starts, commands and disturbances; another one than that of training.

    Raises:
        SceneError, RolloutError: as `Player`.
    """
    player = Player(policy, scene, instances, device, task, seed, threads=threads)
    batch = player.batch
    wanted = np.zeros(instances)
    changes = batch.task.command_time > 0.0
    first = batch.episodes.command.numpy()[:, 0].astype(np.float64)
    for _ in range(batch.longest):
        if changes:
            wanted += batch.episodes.command.numpy()[:, 0] / batch.longest
        player.decide()
    finished = batch.judge.gains.finished.numpy().astype(np.float64)
    gained = finished[:, :COUNT].sum(axis=1) + batch.judge.gains.custom_finished.numpy().astype(np.float64).sum(axis=1)
    lasted = finished[:, COMPLETED] > 0.0  # who failed has begun again, too late to last
    speed = finished[:, FORWARD] / np.maximum(finished[:, DECISIONS], 1.0)
    goes = root_type(batch.scene.character).forward is not None
    near = np.abs(speed - (wanted if changes else first)) <= NEAR if goes else lasted
    walked = speed[lasted] if goes and lasted.any() else np.zeros(1)
    return Evaluation(
        instances, batch.longest * batch.dt, float(lasted.mean()), float((lasted & near).mean()),
        float(walked.mean()), float(walked.std()), float(gained.mean()), goes,
    )  # fmt: skip
