"""How well a simulated motion follows a recorded one, and signals those that were extracted."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats, Integers

# What counts as followed, all at once.
LEAST_R2, LEAST_VELOCITY_R2, MOST_HAND_ERROR, LEAST_CORRELATION = 0.999, 0.97, 0.02, 0.9
LEAST_LEAD = 0.0  # of any synergy, see `Agreement.lead`
BARS = 4


@dataclass(frozen=True)
class Agreement:
    """Of n motions with J joints."""

    r2: Floats  # (n, J) of the angles
    velocity_r2: Floats  # (n, J) of the angular velocities
    hand_error: Floats  # (n,) m, the greatest distance of the hand's tip
    correlation: Floats  # (n,) of the fitted with the extracted signals, of all synergies together
    by_synergy: Floats  # (n, N) the same of each synergy; NaN where one of the two does not change
    null: Floats | None = None  # (n,), (n, N): what these are with the extracted signals of another motion, see `null`;
    null_by_synergy: Floats | None = None  # None of a single motion

    @property
    def lead(self) -> Floats:
        """By how much each synergy's signal is nearer to the extracted one than to another motion's, (n, N); or NaN.

        Motions that are alike have signals that are alike, so that a high correlation alone says little.
        """
        if self.null_by_synergy is None:
            return np.full(self.by_synergy.shape, np.nan)
        return self.by_synergy - self.null_by_synergy

    def signals_kept(self) -> NDArray[np.bool_]:
        """Which motions' signals are near the extracted ones: all together, and each more so than to another motion's.

        A synergy that cannot be compared does not count.
        """
        return np.asarray((self.correlation >= LEAST_CORRELATION) & ~np.any(self.lead < LEAST_LEAD, axis=1))

    def with_signals_kept(self) -> Agreement:
        """The same with signals that are the extracted ones."""
        return replace(self, correlation=np.ones(len(self.r2)), null=None, null_by_synergy=None)

    def good(self) -> NDArray[np.bool_]:
        """Which motions meet all bars."""
        return np.asarray(self.met() == BARS)

    def met(self) -> Integers:
        """How many bars each motion meets."""
        bars = (
            self.r2.min(axis=1) >= LEAST_R2, self.velocity_r2.min(axis=1) >= LEAST_VELOCITY_R2,
            self.hand_error <= MOST_HAND_ERROR, self.signals_kept(),
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


def null(fitted: Floats, extracted: Floats, valid: Floats) -> tuple[Floats, Floats] | tuple[None, None]:
    """As `correlation`, with the extracted signals of a different motion: medians over all others; None of one motion.

    What this comes to is owed to motions being alike, not to a fit that stays with its own signals.
    """
    count = len(fitted)
    if count < 2:
        return None, None
    together, single = np.full((count, count), np.nan), np.full((count, count, fitted.shape[2]), np.nan)
    for shift in range(1, count):
        other = (np.arange(count) + shift) % count
        together[:, shift], single[:, shift] = correlation(fitted, extracted[other], valid * valid[other])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a synergy that changes in no other motion has none
        return np.nanmedian(together, axis=1), np.nanmedian(single, axis=1)


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
