"""Signals of synergies over time: straight between knots, and computed from a motion where nobody recorded any.

Computed signals come from static optimisation; they are no EMG and are never called that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number
from warpmuscle.synergy.static_optimization import StaticOptimization, static_optimization
from warpmuscle.throw.arm import Arm, needed_torques
from warpmuscle.throw.motion import RATE, ArmMotions

KNOT_SPACING = 0.05  # s
RIDGE = 1e-3  # so that a knot that few samples tell of stays near 0


@dataclass(frozen=True)
class Synergies:
    """M muscles by N synergies, and their signals along n motions.

    What excited muscles before a recording began is not in it, but their activations still have it in them; so these
    start by signals of their own rather than at the first excitation.
    """

    weights: Floats  # (M, N), the greatest of each synergy 1
    signals: Floats  # (n, T, N), 0..1
    start: Floats  # (n, N), 0..1: signals whose excitations are the activations at t = 0
    explained: float  # variance accounted for, 0..1
    source: str  # "computed", or the file of the measured ones

    @property
    def count(self) -> int:
        return int(self.weights.shape[1])

    def excitation(self, signals: Floats) -> Floats:
        """Excitations (..., M) of signals (..., N)."""
        return np.asarray(np.clip(signals @ self.weights.T, 0.0, 1.0))


class Knots:
    """Knots in time between which signals are straight."""

    def __init__(self, time: Floats, spacing: float = KNOT_SPACING) -> None:
        """Knots over the samples' times (T,), evenly about so far apart, s."""
        count = max(round(time[-1] / spacing), 1) + 1
        self.time = np.linspace(0.0, time[-1], count)
        self.hats = np.maximum(0.0, 1.0 - np.abs(time[:, None] - self.time) / self.time[1])  # (T, K)

    def __len__(self) -> int:
        return len(self.time)

    def fitted(self, signals: Floats) -> Floats:
        """Values (n, N, K) within 0..1 whose lines are closest to signals (n, T, N)."""
        normal = self.hats.T @ self.hats + RIDGE * np.eye(len(self))
        values = np.linalg.solve(normal, self.hats.T @ signals)
        return np.asarray(np.clip(values.transpose(0, 2, 1), 0.0, 1.0))

    def sampled(self, values: Floats) -> Floats:
        """Signals (n, T, N) of values (n, N, K)."""
        return np.asarray(self.hats @ values.transpose(0, 2, 1))


def computed_activation(arm: Arm, motions: ArmMotions, unknowns: Floats) -> tuple[Floats, StaticOptimization]:
    """Activations (n, T, M) of least sum of squares that make a motion, and what the muscles lack for it.

    Muscles of prescribed joints stay at 0; samples beyond a motion's end need nothing.
    """
    table = arm.muscle_table(unknowns[None])
    count, samples = motions.pitch[0].shape
    angle, speed = (motions.angles[k].reshape(count * samples, -1) for k in (0, 1))
    passive = table.forces(0.0, angle, speed)[0]
    active = np.maximum(table.forces(1.0, angle, speed)[0] - passive, 0.0)
    moment_arm = table.paths(angle)[1][0][:, :, arm.free].transpose(0, 2, 1)
    torque = needed_torques(arm, motions)[:, :, arm.free].reshape(count * samples, -1)
    inside = motions.valid.reshape(-1, 1)
    torque = inside * torque + (1.0 - inside) * np.einsum("tjm,tm->tj", moment_arm, passive)
    found = static_optimization(torque, moment_arm, active, passive)
    return found.activation.reshape(count, samples, -1), found


def time_constants(arm: Arm) -> tuple[float, float]:
    """Of activation and deactivation, s."""
    model = arm.plain.muscle_model
    return first_number(model.rise_time), first_number(model.fall_time)


def to_excitation(arm: Arm, activation: Floats) -> Floats:
    """Excitations (n, T, M) that lead to activations: eq. 11 of Cruz Ruiz 2015 backwards, kept within 0..1."""
    rise, fall = time_constants(arm)
    slope = np.gradient(activation, 1.0 / RATE, axis=1)
    lag = np.where(slope >= 0.0, rise, fall)
    return np.asarray(np.clip(activation + lag * slope, 0.0, 1.0))


def to_activation(arm: Arm, excitation: Floats, start: Floats) -> Floats:
    """Activations (n, T, M) after excitations: eq. 11, exact for excitations that step from sample to sample.

    Args:
        start: (n, M) activations at t = 0.
    """
    rise, fall = (1.0 - np.exp(-1.0 / (RATE * max(constant, 1e-6))) for constant in time_constants(arm))
    activation = excitation.copy()
    activation[:, 0] = start
    for k in range(1, excitation.shape[1]):
        gap = excitation[:, k - 1] - activation[:, k - 1]
        activation[:, k] = activation[:, k - 1] + np.where(gap >= 0.0, rise, fall) * gap
    return activation
