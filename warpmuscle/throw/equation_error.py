"""Muscle parameters from a recorded motion without simulation: the equations of motion along it, in error.

Muscles under the extracted activations must make the torques that the motion needs; and they must be able to make
them at all, with some strength to spare (a hinge on capacity), however wrong the activations are. Without the second
condition no later fit of the signals can follow the motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from warpmuscle.core.array_types import Floats
from warpmuscle.throw.arm import Arm, needed_torques
from warpmuscle.throw.capacity import HINGE, SPARE, STRIDE, shortfall
from warpmuscle.throw.motion import Motions

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
    arm: Arm, motions: Motions, activation: Floats, start: Floats, *, starts: int = STARTS, seed: int = 0
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

    def __init__(self, arm: Arm, motions: Motions, activation: Floats, start: Floats) -> None:
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
