"""A simulation that a learnt policy moves in real time, while it is pushed and steered; numbers only."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
import numpy as np

from warpmuscle.core.status import Status
from warpmuscle.learning.player import Player, commands_of, task_of, undisturbed
from warpmuscle.results.learned import Learned
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.commands import place_of_root, turned_below
from warpmuscle.view.live_run import COMMAND_RATE, EPISODE, LONGEST, RATE, STEERING_INTERVAL, LiveRun, parts_that_follow
from warpmuscle.view.track import doll_of


class PolicyRun(LiveRun):
    """One instance of a scene that a policy moves, recorded as it goes; its free parameters stay as they are.

    Attributes:
        asked: commands of the policy, by name, within what it has learnt, which count from the next decision; and
            what the scene's other commands are to be, such as a slope, which get there as ramps.
    """

    def __init__(self, scene: Scene, learned: Learned, device: str | None = "cpu") -> None:
        """Prepare a scene; its duration does not count.

        Raises:
            SceneError, RolloutError, ResultError: as of `Player`, or the file's task is damaged.
            Error: the scene fails in its first step, so that there is nothing to see.
        """
        task = msgspec.structs.replace(undisturbed(task_of(learned)), episode_time=EPISODE, command_time=0.0)
        self._plain = msgspec.structs.replace(scene, duration=EPISODE, learning=None)
        self._start = start_values(self._plain)
        self._following = parts_that_follow(scene)
        others = scene.commands if self._following is not None else {}
        self._own = {name: one for name, one in others.items() if name not in task.command_names}
        self.player = Player(learned.policy, self._plain, 1, device, task, record=[0], record_rate=RATE)
        batch = self.player.batch
        self.rollout, self.numeric = batch.rollout, batch.rollout.numeric
        self._given, self._duration = scene, EPISODE
        self.scene = msgspec.structs.replace(batch.scene, commands=commands_of(task) | self._own, controller=None)
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
        """Back to the start, with the commands as they are now."""
        self._commanded = self._asked()
        if self._own:
            self.numeric = self._as_commanded()
            self.player.batch.change_parts(self.numeric, self._following or ())
        self.player.batch.reset(seed=0)
        self._clock, self._steps, self._changed_at = 0.0, 0, 0.0
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

    @property
    def given(self) -> None:
        """No numbers are to be changed: a policy has learnt with them as they are."""
        return None

    def apply(self, parts: Sequence[str] | None = None) -> None:
        """Nothing changes: a policy has learnt with the parameters as they are."""

    def _step_now(self) -> int:
        return self._steps

    def _as_commanded(self) -> Scene:
        """The scene in numbers, as its own commands are now."""
        return substitute(self._plain, self._start, {name: self._commanded[name] for name in self._own})

    def _change_scene(self, asked: dict[str, float]) -> None:
        """Bring the scene's own commands nearer to what is asked for, by as much as is due."""
        before, most = dict(self._commanded), COMMAND_RATE * (self.time - self._changed_at)
        self._changed_at = self.time
        for name, one in self._own.items():
            step = float(np.clip(asked[name] - before[name], -most * (one.max - one.min), most * (one.max - one.min)))
            self._commanded[name] = before[name] + step
        if self._commanded == before:
            return
        chosen = self._as_commanded()
        place = place_of_root(self.rollout.coordinate_names, self.rollout.state.coordinates.numpy())
        ground = turned_below(self.numeric.ground, chosen.ground, place)
        self.numeric = msgspec.structs.replace(chosen, ground=ground)
        self.player.batch.change_parts(self.numeric, self._following or ())

    def _decide(self) -> None:
        asked = self._asked()
        self._commanded |= {name: value for name, value in asked.items() if name not in self._own}
        if self.time - self._changed_at > STEERING_INTERVAL - 1e-9:
            self._change_scene(asked)
        row = np.array([[self._commanded[name] for name in self.player.batch.command_names]], dtype=np.float32)
        self.player.batch.episodes.command.assign(row)  # a reset has drawn others
        self.player.decide(restart=False)
        self._steps += self.player.batch.decision_steps
