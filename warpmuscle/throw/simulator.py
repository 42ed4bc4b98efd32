"""Batches of simulated copies of recorded motions, each with its own excitations and parameters."""

from __future__ import annotations

import msgspec
import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Failure, Scene
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.throw.arm import Arm, states
from warpmuscle.throw.motion import MARGIN, RATE, ArmMotions, resample

KEPT = 4  # batches of different sizes that are kept ready
FASTEST = 1e3  # rad/s and m/s, beyond which a copy has diverged


class Simulator:
    """Simulates copies of n recorded motions, from their first sample on.

    Attributes:
        simulations: how many copies so far. steps: how many steps of copies.
    """

    def __init__(
        self,
        arm: Arm,
        motions: ArmMotions,
        *,
        device: str | None = None,
        threads: int | None = None,
        time_step: float | None = None,
    ) -> None:
        """Prepare; `time_step`, s, takes the place of the scene's."""
        self.arm, self.motions = arm, motions
        self.device, self.threads = device, threads
        self.scene = _scene(arm, float(motions.time[-1]), time_step or arm.scene.time_step)
        coordinates, speeds, _ = states(arm, motions)
        self._coordinates, self._speeds = coordinates[:, 0], speeds[:, 0]
        every = Rollout(self.scene, 1, "cpu")
        numbers = [every.coordinate_names.index(name) for name in every.motion_names]
        # Beyond both ends too, so that the splines through these samples have the accelerations of the motions there.
        wider = resample(motions.recorded, until=float(motions.time[-1]), margin=MARGIN)
        self._moved_time, self._moved = wider.time, states(arm, wider)[0][:, :, numbers].transpose(0, 2, 1)
        self._rollouts: dict[int, Rollout] = {}
        self._values: dict[int, Floats] = {}  # parameters that these have
        self.simulations = self.steps = 0

    def run(
        self, which: NDArray[np.intp], time: Floats, excitation: Floats, values: Floats, start: Floats | None = None,
        until: float | None = None,
    ) -> tuple[Floats, Floats]:  # fmt: skip
        """Angles and angular velocities (B, T, J) of all joints at the motions' times.

        A copy that diverges stays where it was last.

        Args:
            which: (B,) motion that a copy starts as and whose prescribed coordinates it follows.
            time: (K,) s, knots. excitation: (B, M, K), straight between them.
            values: of the scene's free parameters, (P,) or (B, P).
            start: (B, M) activations at t = 0; by default the first excitations.
            until: s, up to which it is simulated; what comes later is not there.
        """
        rollout = self.prepared(which, time, excitation, values, start)
        rollout.run(until)
        self.simulations += len(which)
        self.steps += len(which) * rollout.steps_done
        return self._sampled(rollout)

    def load(self) -> None:
        """Have the kernel ready, compiled now unless Warp has it in its cache."""
        self._rollout(1).load()

    def prepared(
        self, which: NDArray[np.intp], time: Floats, excitation: Floats, values: Floats, start: Floats | None = None
    ) -> Rollout:
        """The same copies at their start; theirs until the next call for as many."""
        count = len(which)
        rollout = self._rollout(count)
        if not np.array_equal(self._values.get(count, ()), values):  # a model takes as long to build as to simulate
            self._values.pop(count, None)
            rollout.set_parameters(values)
            self._values[count] = np.array(values)
        self._begin(rollout, which, time, excitation, start)
        return rollout

    def recordings(
        self, which: NDArray[np.intp], time: Floats, excitation: Floats, values: Floats, start: Floats | None = None
    ) -> list[Recording]:
        """The same copies with all that there is to know of their motions; see `run`."""
        count = len(which)
        rollout = Rollout(self.scene, count, self.device, record=range(count), record_rate=RATE, threads=self.threads)
        rollout.set_parameters(values)
        self._begin(rollout, which, time, excitation, start)
        rollout.run()
        return [rollout.recording(number) for number in range(count)]

    def _begin(
        self, rollout: Rollout, which: NDArray[np.intp], time: Floats, excitation: Floats, start: Floats | None
    ) -> None:
        if self._moved.shape[1]:
            rollout.set_motion(self._moved_time, self._moved, which)
        rollout.set_excitations(time, excitation)
        activation = excitation[:, :, 0] if start is None else start
        rollout.set_initial(self._coordinates[which], self._speeds[which], activation)

    def _rollout(self, count: int) -> Rollout:
        rollout = self._rollouts.pop(count, None)
        if rollout is None:
            while len(self._rollouts) >= KEPT:
                oldest = next(iter(self._rollouts))
                del self._rollouts[oldest]
                self._values.pop(oldest, None)
            rollout = Rollout(
                self.scene, count, self.device, record=range(count), record_rate=RATE, threads=self.threads,
                quantities=["coordinates", "speeds"],
            )  # fmt: skip
        self._rollouts[count] = rollout
        return rollout

    def _sampled(self, rollout: Rollout) -> tuple[Floats, Floats]:
        arm = self.arm
        parts = []
        for name, places in (("coordinates", arm.coordinate_places), ("speeds", arm.speed_places)):
            frames = rollout.recorded(name)[:, :, places]
            last = getattr(rollout.state, name).numpy()[:, places]
            parts.append(np.concatenate([frames, last[:, None]], axis=1).astype(np.float64))
        ended = np.floor(rollout.end_time() * RATE + 1e-6).astype(int)
        for row in np.flatnonzero(ended < parts[0].shape[1] - 1):
            for part in parts:
                part[row, ended[row] + 1 :] = part[row, ended[row]]
        return parts[0], parts[1]


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


def _scene(arm: Arm, duration: float, time_step: float) -> Scene:
    """The scene for so long, s, in which nothing but divergence ends a copy."""
    return msgspec.structs.replace(
        arm.simulated,
        duration=duration,
        time_step=time_step,
        failure=Failure(com_height=0.0, heading=0.0, max_speed=FASTEST, max_com_speed=FASTEST),
    )
