"""Copies of motions stepped from sample to sample, with as many attempts at each step as are wanted."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.throw.motion import RATE
from warpmuscle.throw.simulator import Simulator


class Stepper:
    """n motions with the same number of copies each, all at the same time and in the same state.

    Attributes:
        angle, speed: (n, copies, J) of the joints, now. tried: how many copies have been stepped.
    """

    def __init__(self, simulator: Simulator, values: Floats, copies: int) -> None:
        """Begin at the motions' first samples, with parameters (n, P)."""
        self._simulator, self.copies = simulator, copies
        self._count = len(simulator.motions)
        which = np.repeat(np.arange(self._count), copies)
        nothing = np.zeros((len(which), len(simulator.arm.muscles), 1))
        self._rollout = simulator.prepared(which, np.zeros(1), nothing, values[which])
        self._every = round(1.0 / (RATE * simulator.scene.time_step))
        self.tried = 0
        self._held = self._rollout.snapshot()
        self.angle, self.speed = self._now()

    def attempt(self, excitation: Floats) -> tuple[Floats, Floats]:
        """Angles and speeds (n, copies, J) a sample later under constant excitations (n, copies, M)."""
        self._rollout.restore(self._held)
        values = excitation.reshape(-1, excitation.shape[2], 1)
        self._rollout.set_excitations(np.zeros(1), values, restart=False)
        self._rollout.advance(self._rollout.steps_done + self._every)
        self.tried += len(excitation) * self.copies
        return self._now()

    def commit(self, excitation: Floats) -> None:
        """Go on by a sample under excitations (n, M)."""
        self.angle, self.speed = self.attempt(np.repeat(excitation[:, None], self.copies, axis=1))
        self._held = self._rollout.snapshot()

    def _now(self) -> tuple[Floats, Floats]:
        arm, state = self._simulator.arm, self._rollout.state
        return tuple(
            getattr(state, name).numpy()[:, places].astype(np.float64).reshape(self._count, self.copies, -1)
            for name, places in (("coordinates", arm.coordinate_places), ("speeds", arm.speed_places))
        )
