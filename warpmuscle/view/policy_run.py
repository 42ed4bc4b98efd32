"""A simulation that a learnt policy moves in real time, while it is pushed and told where to go; numbers only."""

from __future__ import annotations

import msgspec
import numpy as np

from warpmuscle.core.status import Status
from warpmuscle.learning.player import Player, commands_of, task_of, undisturbed
from warpmuscle.results.learned import Learned
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.view.live_run import EPISODE, LONGEST, RATE, LiveRun
from warpmuscle.view.track import doll_of


class PolicyRun(LiveRun):
    """One instance of a scene that a policy moves, recorded as it goes; its free parameters stay as they are.

    Attributes:
        asked: what the policy is told, by name, within what it has learnt; it counts from the next decision.
    """

    def __init__(self, scene: Scene, learned: Learned, device: str | None = "cpu") -> None:
        """Prepare a scene; its duration does not count.

        Raises:
            SceneError, RolloutError, ResultError: as of `Player`, or the file's task is damaged.
            Error: the scene fails in its first step, so that there is nothing to see.
        """
        task = msgspec.structs.replace(undisturbed(task_of(learned)), episode_time=EPISODE, command_time=0.0)
        plain = msgspec.structs.replace(scene, duration=EPISODE, commands={}, learning=None)
        self.player = Player(learned.policy, plain, 1, device, task, record=[0], record_rate=RATE)
        batch = self.player.batch
        self.rollout, self.numeric = batch.rollout, batch.rollout.numeric
        self.scene = msgspec.structs.replace(batch.scene, commands=commands_of(task), controller=None)
        self.parameters, self.values = [], np.zeros(0)
        self.asked = {name: one.asked for name, one in self.scene.commands.items()}
        self.faster = self.turned = 0.0
        self._commanded = dict(self.asked)
        self._doll = doll_of(self.numeric, self.rollout.recording().muscle_names)
        self._every = max(round(1.0 / (RATE * scene.time_step)), 1)
        self._seen: Recording | None = None
        self._steps = 0
        self.restart()
        self.window(0.0)

    def restart(self) -> None:
        """Back to the start."""
        self.player.batch.reset(seed=0)
        self._clock, self._steps = 0.0, 0
        self._decide()  # the first frame

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self._steps * self.scene.time_step

    def advance(self, passed: float) -> None:
        """Go on by a time, s, in whole decisions."""
        self._clock = min(self._clock + min(passed, LONGEST), EPISODE)
        every = self.player.batch.decision_steps
        while (self._steps + every) * self.scene.time_step <= self._clock and self.status == Status.RUNNING:
            self._decide()

    def apply(self) -> None:
        """Nothing changes: a policy has learnt with the parameters as they are."""

    def _step_now(self) -> int:
        return self._steps

    def _decide(self) -> None:
        self._commanded = self._asked()
        told = np.array([list(self._commanded.values())], dtype=np.float32)
        self.player.batch.episodes.command.assign(told)  # a reset has drawn others
        self.player.decide(restart=False)
        self._steps += self.player.batch.decision_steps
