"""Many short windows of a simulation without muscles, each from its own state, and how their ends depend on that."""

from __future__ import annotations

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.tracking.driven_body import DrivenBody
from warpmuscle.inverse.tracking.state_difference import difference, moved_by
from warpmuscle.scene import Scene

ON_CPU, ON_GPU = 16384, 131072  # windows that are simulated at once
SHIFTED, SPED, PUSHED = 1.0e-3, 1.0e-2, 1.0  # rad or m, rad/s or m/s, N m or N: steps of differences


class Windows:
    """Windows of a scene under constant efforts of its joints.

    Attributes:
        body: the model on the ground, whose muscles play no part. window: s.
        speeds: S. efforts: m, along the speeds behind the root's.
    """

    def __init__(self, scene: Scene, device: str, window: float) -> None:
        """Args: window: s, rounded to whole steps."""
        bare = msgspec.structs.replace(scene.character, muscles={})
        self.body = BodyModel(msgspec.structs.replace(scene, character=bare), device)
        self.window = max(round(window / scene.time_step), 1) * scene.time_step
        self.speeds = self.body.topology.speeds
        self.efforts = self.speeds - self.body.topology.speed_start[1]
        self._batches: dict[int, DrivenBody] = {}

    def run(self, q: Floats, v: Floats, effort: Floats) -> tuple[Floats, Floats]:
        """States (n, C) and (n, S) at the ends of windows that begin in others, under efforts (n, m)."""
        most = ON_CPU if self.body.device.is_cpu else ON_GPU
        ends = [self._run(q[k : k + most], v[k : k + most], effort[k : k + most]) for k in range(0, len(q), most)]
        return np.concatenate([end[0] for end in ends]), np.concatenate([end[1] for end in ends])

    def _run(self, q: Floats, v: Floats, effort: Floats) -> tuple[Floats, Floats]:
        n = len(q)
        if n not in self._batches:
            if len(self._batches) > 3:
                self._batches.pop(next(iter(self._batches)))
            self._batches[n] = DrivenBody(self.body, n, self.window, [], self.window)
        batch = self._batches[n]
        batch.rollout.set_initial(np.asarray(q, np.float32), np.asarray(v, np.float32))
        batch.tell(np.concatenate([np.zeros((n, self.speeds - self.efforts)), effort], axis=1))
        batch.rollout.step(batch.window_steps)
        return batch.state()

    def derivatives(self, q: Floats, v: Floats, effort: Floats, end: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
        """How the ends of n windows change with their starts (n, 2S, 2S), and with efforts (n, 2S, m).

        Args:
            end: where these windows end; all are ways to there, see `state_difference.difference`.
        """
        n, speeds, efforts = len(q), self.speeds, self.efforts
        count = 2 * speeds + efforts
        size = np.repeat([SHIFTED, SPED, PUSHED], [speeds, speeds, efforts])
        change = np.tile(np.diag(size), (n, 1))
        from_q = moved_by(self.body, np.repeat(q, count, axis=0), change[:, :speeds])
        from_v = np.repeat(v, count, axis=0) + change[:, speeds : 2 * speeds]
        under = np.repeat(effort, count, axis=0) + change[:, 2 * speeds :]
        to_q, to_v = self.run(from_q, from_v, under)
        away = difference(self.body, np.repeat(end[0], count, axis=0), to_q)
        ends = np.concatenate([away, to_v - np.repeat(end[1], count, axis=0)], axis=1).reshape(n, count, 2 * speeds)
        found = np.swapaxes(ends / size[:, None], 1, 2)
        return found[..., : 2 * speeds], found[..., 2 * speeds :]
