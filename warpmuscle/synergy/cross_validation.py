"""How many synergies predict activations that they were not fitted to.

Stretches of single muscles are left out of the factorisation, each as long as the signals remember, and are then
compared with what it says of them. Too few synergies miss what muscles have in common; too many follow the noise of
those that are left in. A synergy that only one muscle has says nothing of that muscle's gaps, so that one muscle by
itself hardly asks for it (Wold 1978, Technometrics 20:397; Owen and Perry 2009, Ann. Appl. Stat. 3:564).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats, Integers

FOLDS = 8  # parts of which one is left out at a time
REPEATS = 2  # partitions
STEPS = 200  # of the factorisation, at most
PRECISION = 1e-5  # relative change of W C at which it ends
RIDGE = 0.2  # price of a squared coefficient: what nothing tells of is 0
FORGOTTEN = 0.5  # autocorrelation below which a signal has forgotten
TINY = 1e-12


@dataclass(frozen=True)
class Prediction:
    """How well 1, 2, ..., K synergies predict what they have not seen."""

    error: Floats  # (K,) squared error of what was left out, over its power; mean of the partitions
    spread: Floats  # (K,) standard error of its difference from the least

    @property
    def count(self) -> int:
        """The fewest synergies whose error is within one standard error of the least (Breiman et al. 1984)."""
        enough = self.error <= self.error.min() + self.spread
        return int(np.argmax(enough)) + 1


def cross_validate(
    activations: Floats, most: int, seed: int = 0, progress: Callable[[int], None] = lambda count: None
) -> Prediction:
    """The error of prediction of 1 to `most` synergies, of activations (T, M)."""
    rng = np.random.default_rng(seed)
    length = memory(activations)
    parts = [_partition(activations.shape, length, rng) for _ in range(REPEATS)]
    squares = np.zeros((most, REPEATS * FOLDS))
    power = np.zeros(REPEATS * FOLDS)
    for count in range(1, most + 1):
        progress(count)
        for number in range(REPEATS * FOLDS):
            left_out = parts[number // FOLDS] == number % FOLDS
            start = np.random.default_rng([seed, count, number])
            rest = activations - fill_gaps(activations, left_out, count, start)
            squares[count - 1, number] = np.sum(rest[left_out] ** 2)
            power[number] = np.sum(activations[left_out] ** 2)
    part = squares / max(power.mean(), TINY)
    error = part.mean(axis=1)
    spread = np.std(part - part[error.argmin()], axis=1, ddof=1) / np.sqrt(FOLDS)
    return Prediction(error, spread)


def memory(activations: Floats) -> int:
    """Samples after which the autocorrelation of activations (samples, muscles), on average, is below one half."""
    centred = activations - activations.mean(axis=0)
    power = np.sum(centred**2)
    for lag in range(1, len(activations) // 4):
        if np.sum(centred[lag:] * centred[:-lag]) < FORGOTTEN * power:
            return lag
    return max(len(activations) // 8, 1)


def _partition(shape: tuple[int, ...], length: int, rng: np.random.Generator) -> Integers:
    """A number of its part, 0..FOLDS - 1, for each sample of each muscle (T, M): stretches of so many samples."""
    samples, muscles = shape
    rounds = -(-samples // (length * FOLDS)) + 1
    parts = np.empty((samples, muscles), np.int64)
    for muscle in range(muscles):
        offset = int(rng.integers(length))
        order = np.concatenate([rng.permutation(FOLDS) for _ in range(rounds)])
        parts[:, muscle] = np.repeat(order, length)[offset : offset + samples]
    return parts


def fill_gaps(activations: Floats, gaps: NDArray[np.bool_], count: int, rng: np.random.Generator) -> Floats:
    """W C (T, M) of as many synergies, fitted to activations (T, M) but for gaps (T, M) of them.

    Multiplicative steps (Lee and Seung 2001) of |known (A - W C)|^2 + ridge |C|^2 with the greatest weight of each
    synergy 1.
    """
    known = ~gaps
    seen = np.where(known, activations, 0.0)
    samples, muscles = activations.shape
    level = np.sqrt(seen.mean() / count)
    coefficients = level * rng.uniform(0.1, 2.0, (samples, count))
    weights = level * rng.uniform(0.1, 2.0, (count, muscles))
    before = np.zeros_like(seen)
    for step in range(STEPS):
        scale = np.maximum(weights.max(axis=1), TINY)
        weights, coefficients = weights / scale[:, None], coefficients * scale
        made = known * (coefficients @ weights)
        coefficients *= (seen @ weights.T) / (made @ weights.T + RIDGE * coefficients + TINY)
        made = known * (coefficients @ weights)
        weights *= (coefficients.T @ seen) / (coefficients.T @ made + TINY)
        if step % 20 == 19:
            if np.sum((made - before) ** 2) < PRECISION * np.sum(made**2):
                break
            before = made
    return np.asarray(coefficients @ weights)
