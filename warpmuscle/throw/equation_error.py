"""Muscle parameters from a recorded motion without simulation: the equations of motion along it, in error.

Muscles under the extracted activations must make the torques that the motion needs; and they must be able to make
them at all, with some strength to spare (a hinge on capacity), however wrong the activations are. Without the second
condition no later fit of the signals can follow the motion.

A fit that follows some motions may leave muscles too weak for a few frames of them: others then make up for it before
and after, at signals that nobody extracted. So fits by simulation count what is lacking, too (`Capacity`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from warpmuscle.core.array_types import Floats
from warpmuscle.studies.muscle_table import MuscleTable
from warpmuscle.throw.arm import Arm, needed_torques
from warpmuscle.throw.motion import ArmMotions

SPARE, ALL = 0.7, 0.95  # of its strength a muscle may need at most: before simulations, and in them
HINGE = 3.0  # weight of what it needs beyond, against an error of torque
STRIDE = 5  # samples
# Weight of a parameter's distance from its start, in parts of its interval. The valley of the error is flat: far along
# it, parameters suit the motions that they are fitted to as well, but others less.
PRIOR = 1.0
SCATTER = 0.1  # of the starts, in the same parts
STARTS = 3
TOLERANCE = 1e-8  # relative, of cost and parameters
STEP = 1e-3  # of the difference quotients, wide enough for forces in single precision


@dataclass(frozen=True)
class EquationError:
    """Parameters that suit a motion's equations."""

    unknowns: Floats  # (P,) see `Arm.unknowns`
    cost: float
    starts: int


def fit_equations(
    arm: Arm, motions: ArmMotions, activation: Floats, start: Floats, *, starts: int = STARTS, seed: int = 0
) -> EquationError:
    """Parameters by bounded least squares from several starts, the first of them `start` (P,).

    Args:
        activation: (n, T, M) as extracted.
    """
    problem = _Problem(arm, motions, activation, start)
    rng = np.random.default_rng(seed)
    best = None
    for number in range(starts):
        x = start if number == 0 else start + rng.normal(size=start.shape) * SCATTER
        found = least_squares(
            problem.residuals, np.clip(x, 1e-6, 1.0 - 1e-6), problem.jacobian, (0.0, 1.0),
            max_nfev=100, ftol=TOLERANCE, xtol=TOLERANCE,
        )  # fmt: skip
        if best is None or found.cost < best.cost:
            best = found
    assert best is not None
    return EquationError(np.asarray(best.x), float(best.cost), starts)


class _Problem:
    """Residuals of the equations of motion for sets of parameters."""

    def __init__(self, arm: Arm, motions: ArmMotions, activation: Floats, start: Floats) -> None:
        counted = motions.valid > 0.0
        counted[:, np.arange(counted.shape[1]) % STRIDE != 0] = False

        def samples(values: Floats) -> Floats:
            return np.asarray(values[counted])

        self._arm, self._start = arm, start
        self._angle, self._speed = samples(motions.angles[0]), samples(motions.angles[1])
        self._needed = samples(needed_torques(arm, motions))[:, arm.free]
        self._activation = samples(activation)
        self._scale = np.maximum(self._needed.std(axis=0), 1e-6) * np.sqrt(self._needed.shape[0])

    def residuals(self, unknowns: Floats) -> Floats:
        """(R,) of one set of parameters."""
        return np.asarray(self._batch(unknowns[None])[0])

    def jacobian(self, unknowns: Floats) -> Floats:
        """(R, P) by differences, all at once."""
        step = np.where(unknowns > 0.5, -STEP, STEP)
        moved = np.concatenate([unknowns[None], unknowns + np.diag(step)])
        values = self._batch(moved)
        return np.asarray(((values[1:] - values[0]) / step[:, None]).T)

    def _batch(self, unknowns: Floats) -> Floats:
        table, free = self._arm.muscle_table(unknowns), self._arm.free
        made = table.torques(self._activation, self._angle, self._speed)[..., free]
        error = (made.sum(axis=-2) - self._needed) / self._scale
        beyond = shortfall(table, self._angle, self._speed, self._needed, free, SPARE) / self._scale
        count = len(unknowns)
        prior = PRIOR * (unknowns - self._start)
        return np.concatenate([error.reshape(count, -1), HINGE * beyond.reshape(count, -1), prior], axis=1)


def shortfall(table: MuscleTable, angle: Floats, speed: Floats, needed: Floats, free: list[int], part: float) -> Floats:
    """Torques (Z, S, J), N m, that are needed (S, J) about the free joints beyond a part of the muscles' strength."""
    most = table.torques(1.0, angle, speed)[..., free]
    passive = table.torques(0.0, angle, speed)[..., free]
    active, wanted = part * (most - passive), needed - passive.sum(axis=-2)
    upper, lower = np.maximum(active, 0.0).sum(axis=-2), np.minimum(active, 0.0).sum(axis=-2)
    return np.asarray(np.maximum(wanted - upper, 0.0) + np.minimum(wanted - lower, 0.0))


class Capacity:
    """What n motions need beyond the strength of muscles, for many sets of parameters."""

    def __init__(self, arm: Arm, motions: ArmMotions) -> None:
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
