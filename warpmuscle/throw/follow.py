"""Simulated copies of recorded motions: how far they are from what was recorded, for fits and for reports."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.throw.arm import Arm, hand_position, states
from warpmuscle.throw.metrics import Agreement, correlation, determination, null
from warpmuscle.throw.motion import ArmMotions
from warpmuscle.throw.signals import Knots, Synergies
from warpmuscle.throw.simulator import Simulator

VELOCITY_WEIGHT = 0.05  # of an error of velocity over its deviation, against one of angle over its
ROUGH_STEP = 0.005  # s
CLOSE = np.array([1e-4, 1e-2])  # 1 - r2 of angles and of velocities, below which no signal need change any more
FAR = 10.0  # rad and rad/s: errors beyond it count as this much, so that one wild copy does not decide all


@dataclass(frozen=True)
class Replay:
    """Simulated motions: angles and angular velocities of all joints, (n, T, J)."""

    angle: Floats
    speed: Floats


class Follower:
    """Simulates copies of n motions under signals of synergies, and compares them with the recordings.

    Attributes:
        horizon: s, up to which residuals count.
    """

    def __init__(
        self,
        arm: Arm,
        motions: ArmMotions,
        synergies: Synergies,
        knots: Knots,
        *,
        device: str | None = None,
        threads: int | None = None,
        velocity_weight: float = VELOCITY_WEIGHT,
    ) -> None:
        self.arm, self.motions, self.synergies, self.knots = arm, motions, synergies, knots
        self.horizon = float(motions.time[-1])
        self.simulator = Simulator(arm, motions, device=device, threads=threads)
        step = max(ROUGH_STEP, arm.scene.time_step)
        self.rough_simulator = Simulator(arm, motions, device=device, threads=threads, time_step=step)
        inside = motions.valid[:, 1:, None]
        length = np.sqrt(motions.valid[:, 1:].sum(axis=1))[:, None, None]
        angle, speed = (motions.angles[order][:, :, arm.free] for order in (0, 1))
        self._velocity_weight = velocity_weight
        self._weight = tuple(
            factor * inside / (_deviation(values, motions.valid) * length)
            for factor, values in ((1.0, angle), (velocity_weight, speed))
        )

    def load(self) -> None:
        """Have the kernels ready, compiled now unless Warp has them in its cache."""
        self.simulator.load()
        self.rough_simulator.load()

    @property
    def size(self) -> int:
        """Number of values of a motion's signals: at their knots, and those that the activations start by."""
        return self.synergies.count * (len(self.knots) + 1)

    @property
    def extracted(self) -> Floats:
        """The extracted signals as rows of `size` values, (n, size)."""
        knots = self.knots.fitted(self.synergies.signals)
        return np.concatenate([knots.reshape(len(knots), -1), self.synergies.start], axis=1)

    def shaped(self, individual: Floats) -> Floats:
        """Values at the knots (B, N, K) of rows of `size` values."""
        count = self.synergies.count
        return individual[:, :-count].reshape(len(individual), count, len(self.knots))

    def excitation(self, individual: Floats) -> Floats:
        """Excitations (B, M, K) at the knots by signals (B, size)."""
        return self.synergies.excitation(self.shaped(individual).transpose(0, 2, 1)).transpose(0, 2, 1)

    def start(self, individual: Floats) -> Floats:
        """Activations (B, M) at t = 0 by signals (B, size)."""
        return self.synergies.excitation(individual[:, -self.synergies.count :])

    def replay(
        self,
        which: NDArray[np.intp],
        individual: Floats,
        shared: Floats,
        rough: bool = False,
        until: float | None = None,
    ) -> Replay:
        """Copies (B,) of motions under signals (B, size), with parameters (B, P) or (P,) as `Arm.unknowns`.

        Rough ones take longer time steps: good enough for derivatives. What comes after `until`, s, is not there.
        """
        simulator = self.rough_simulator if rough else self.simulator
        values = self.arm.values(shared)
        if values.ndim == 2 and np.all(values == values[0]):
            values = values[0]
        angle, speed = simulator.run(
            which, self.knots.time, self.excitation(individual), values, self.start(individual), until=until
        )
        return Replay(angle, speed)

    def residuals(self, which: NDArray[np.intp], individual: Floats, shared: Floats, rough: bool = False) -> Floats:
        """(B, R); their squares sum up to 1 - r2 of all angles, and a part of that of velocities, up to the horizon."""
        samples = slice(1, int(np.sum(self.motions.time <= self.horizon + 1e-9)))
        until = self.horizon if samples.stop < len(self.motions.time) else None
        replay = self.replay(which, individual, shared, rough, until)
        parts = []
        for order, simulated in ((0, replay.angle), (1, replay.speed)):
            recorded = self.motions.angles[order][which][:, samples, self.arm.free]
            error = np.clip(simulated[:, samples, self.arm.free] - recorded, -FAR, FAR)
            parts.append((error * self._weight[order][which][:, : samples.stop - 1]).reshape(len(which), -1))
        return np.concatenate(parts, axis=1)

    def followed(self, residuals: Floats) -> NDArray[np.bool_]:
        """Which motions (n,) are followed far better than the bars ask for, by their residuals (n, R)."""
        parts = residuals.reshape(len(residuals), 2, -1, len(self.arm.free))
        missed = np.sum(parts**2, axis=2) / np.array([1.0, self._velocity_weight**2])[:, None]
        return np.asarray(np.all(missed <= CLOSE[:, None], axis=(1, 2)))

    def agreement(self, individual: Floats, shared: Floats) -> tuple[Agreement, Replay]:
        """How well every motion is followed."""
        motions, free = self.motions, self.arm.free
        replay = self.replay(np.arange(len(motions)), individual, shared)
        signals = self.knots.sampled(self.shaped(individual)), self.synergies.signals, motions.valid
        together, single = correlation(*signals)
        r2, velocity_r2 = (
            determination(simulated[:, 1:, free], motions.angles[order][:, 1:, free], motions.valid[:, 1:])
            for order, simulated in ((0, replay.angle), (1, replay.speed))
        )
        error = hand_error(self.arm, motions, replay.angle)
        return Agreement(r2, velocity_r2, error, together, single, *null(*signals)), replay


def hand_error(arm: Arm, motions: ArmMotions, angle: Floats) -> Floats:
    """Greatest distance (n,), m, of the hand's tip from where it was, the trunk moving as recorded."""
    recorded, _, _ = states(arm, motions)
    simulated = recorded.copy()
    simulated[:, :, arm.coordinate_places] = angle
    count, samples = recorded.shape[:2]
    ends = [
        hand_position(arm, q.reshape(count * samples, -1)).reshape(count, samples, 3) for q in (recorded, simulated)
    ]
    distance = np.linalg.norm(ends[1] - ends[0], axis=-1) * motions.valid
    return np.asarray(distance.max(axis=1))


def _deviation(values: Floats, valid: Floats) -> Floats:
    """Standard deviations (n, 1, J) of (n, T, J) over valid samples."""
    w = valid[:, :, None]
    total = w.sum(axis=1, keepdims=True)
    mean = (values * w).sum(axis=1, keepdims=True) / total
    variance = (w * (values - mean) ** 2).sum(axis=1, keepdims=True) / total
    return np.asarray(np.maximum(np.sqrt(variance), 1e-3))
