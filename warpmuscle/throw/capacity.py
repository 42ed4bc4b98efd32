"""Whether muscles are strong enough for a motion: what it needs beyond a part of their strength.

A fit that follows some motions may leave muscles too weak for a few frames of them: others then make up for it before
and after, at signals that nobody extracted. So all fits of parameters count what is lacking.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.studies.muscle_table import MuscleTable
from warpmuscle.throw.arm import Arm, needed_torques
from warpmuscle.throw.motion import Motions

SPARE, ALL = 0.7, 0.95  # of its strength a muscle may need at most: before simulations, and in them
HINGE = 3.0  # weight of what it needs beyond, against an error of torque
STRIDE = 5  # samples


def shortfall(table: MuscleTable, angle: Floats, speed: Floats, needed: Floats, free: list[int], part: float) -> Floats:
    """Torques (Z, S, J), N m, that are needed (S, J) about the free joints beyond a part of the muscles' strength."""
    most = table.torques(1.0, angle, speed)[..., free]
    passive = table.torques(0.0, angle, speed)[..., free]
    active, wanted = part * (most - passive), needed - passive.sum(axis=-2)
    upper, lower = np.maximum(active, 0.0).sum(axis=-2), np.minimum(active, 0.0).sum(axis=-2)
    return np.asarray(np.maximum(wanted - upper, 0.0) + np.minimum(wanted - lower, 0.0))


class Capacity:
    """What n motions need beyond the strength of muscles, for many sets of parameters."""

    def __init__(self, arm: Arm, motions: Motions) -> None:
        self._arm = arm
        self._angle, self._speed = (part[:, ::STRIDE] for part in motions.angles[:2])
        self._needed = needed_torques(arm, motions)[:, ::STRIDE, arm.free]
        inside = motions.valid[:, ::STRIDE, None]
        count = inside.sum(axis=1, keepdims=True)
        mean = (inside * self._needed).sum(axis=1, keepdims=True) / count
        spread = np.sqrt((inside * (self._needed - mean) ** 2).sum(axis=1, keepdims=True))
        self._weight = HINGE * inside / np.maximum(spread, 1e-6)

    def residuals(self, which: NDArray[np.intp], unknowns: Floats) -> Floats:
        """(B, R) for motions (B,) and parameters (B, P), see `Arm.unknowns`; in parts of what the torques vary by."""
        sets, of = np.unique(unknowns, axis=0, return_inverse=True)
        rows, of_row = np.unique(which, return_inverse=True)
        angle, speed, needed = (
            part[rows].reshape(-1, part.shape[2]) for part in (self._angle, self._speed, self._needed)
        )
        beyond = shortfall(self._arm.muscle_table(sets), angle, speed, needed, self._arm.free, ALL)
        beyond = beyond.reshape(len(sets), len(rows), *self._needed.shape[1:])
        return np.asarray((beyond[of.ravel(), of_row] * self._weight[which]).reshape(len(which), -1))
