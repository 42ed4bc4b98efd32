"""How well a simulated motion follows a recorded one, and signals those that were extracted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats, Integers

# What counts as followed, all at once.
LEAST_R2, LEAST_VELOCITY_R2, MOST_HAND_ERROR, LEAST_CORRELATION = 0.999, 0.97, 0.02, 0.9
BARS = 4


@dataclass(frozen=True)
class Agreement:
    """Of n motions with J joints."""

    r2: Floats  # (n, J) of the angles
    velocity_r2: Floats  # (n, J) of the angular velocities
    hand_error: Floats  # (n,) m, the greatest distance of the hand's tip
    correlation: Floats  # (n,) of the fitted with the extracted signals, of all synergies together
    by_synergy: Floats  # (n, N) the same of each synergy; NaN where one of the two does not change

    def good(self) -> NDArray[np.bool_]:
        """Which motions meet all bars."""
        return np.asarray(self.met() == BARS)

    def met(self) -> Integers:
        """How many bars each motion meets."""
        bars = (
            self.r2.min(axis=1) >= LEAST_R2, self.velocity_r2.min(axis=1) >= LEAST_VELOCITY_R2,
            self.hand_error <= MOST_HAND_ERROR, self.correlation >= LEAST_CORRELATION,
        )  # fmt: skip
        return np.asarray(np.sum(bars, axis=0))


def determination(simulated: Floats, recorded: Floats, valid: Floats) -> Floats:
    """Coefficients of determination r2 (n, J) of (n, T, J); samples where `valid` (n, T) is 0 do not count."""
    w = valid[:, :, None]
    mean = np.sum(recorded * w, axis=1, keepdims=True) / np.sum(w, axis=1, keepdims=True)
    spread = np.sum(w * (recorded - mean) ** 2, axis=1)
    error = np.sum(w * (simulated - recorded) ** 2, axis=1)
    return np.asarray(1.0 - error / np.maximum(spread, 1e-12))


def correlation(fitted: Floats, extracted: Floats, valid: Floats) -> tuple[Floats, Floats]:
    """Pearson correlation of signals (n, T, N): of all N together (n,), and of each (n, N)."""
    together, single = np.empty(len(fitted)), np.full((len(fitted), fitted.shape[2]), np.nan)
    for i in range(len(fitted)):
        inside = valid[i] > 0.0
        a, b = fitted[i, inside], extracted[i, inside]
        together[i] = _pearson(a.ravel(), b.ravel())
        single[i] = [_pearson(a[:, k], b[:, k]) for k in range(a.shape[1])]
    return together, single


def _pearson(a: Floats, b: Floats) -> float:
    x, y = a - a.mean(), b - b.mean()
    size = float(np.sqrt(np.sum(x * x) * np.sum(y * y)))
    return float(np.sum(x * y) / size) if size > 1e-12 else float("nan")


def leave_one_out(recorded: Floats, valid: Floats) -> Floats:
    """r2 (n, J) of the trivial baseline: the mean of the other motions in place of each."""
    count = len(recorded)
    if count < 2:
        return np.full((count, recorded.shape[2]), np.nan)
    mean = (recorded.sum(axis=0, keepdims=True) - recorded) / (count - 1)
    return determination(mean, recorded, valid)
