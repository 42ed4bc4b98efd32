"""Muscle synergies by non-negative matrix factorisation: A(t) = W C(t) (Cruz Ruiz et al. 2015, eq. 1 and 2).

Conventions: A is (T, M) here, a row a sample; W is (M, N), a column a synergy; C is (N, T). The greatest weight of each
synergy is 1, so that C has the scale of the activations, about 0..1 where these are normalised by their maxima.
Synergies stand in the order of what they explain, |w_i|^2 |c_i|^2, the greatest first.

Variance accounted for is VAF = 1 - |A - W C|^2 / |A|^2, without the mean subtracted; of a muscle, the same of its row.
r2 = 1 - |A - W C|^2 / |A - mean(A)|^2, with one mean of the whole matrix, as in Santuz et al. 2017.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment, nnls

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SignalError
from warpmuscle.core.extras import imported
from warpmuscle.core.limits import check_size
from warpmuscle.core.plain_text import number_of

RESTARTS = 10
ITERATIONS = 1000
PRECISION = 1e-4  # relative change at which a factorisation ends; a hundredth of it changes VAF by 1e-5


@dataclass(frozen=True)
class Account:
    """How well N synergies account for the activations of M muscles."""

    count: int  # N
    vaf: float
    muscle_vaf: Floats  # (M,)
    r2: float
    restart_vaf: Floats  # (R,), of each restart; the best one was taken


@dataclass(frozen=True)
class Synergies:
    """N synergies of M muscles over T samples."""

    weights: Floats  # (M, N), W, the greatest of each column 1
    coefficients: Floats  # (N, T), C
    account: Account

    def ordered(self, order: Sequence[int]) -> Synergies:
        """The same synergies in another order."""
        return Synergies(self.weights[:, order], self.coefficients[list(order)], self.account)


def factorize(activations: Floats, count: int, restarts: int = RESTARTS, seed: int = 0) -> Synergies:
    """The best of several factorisations from different starts: by singular vectors the first, by chance the others.

    The same input and seed give the same synergies, however many others are computed.

    Args:
        activations: (T, M), not negative.

    Raises:
        SignalError: negative or not finite activations, or more synergies than muscles or samples.
        Error: scikit-learn is not installed.
    """
    _check(activations, count, restarts)
    decomposition = imported("sklearn.decomposition", "synergies need")
    from sklearn.exceptions import ConvergenceWarning

    best: tuple[float, Floats, Floats] | None = None
    power, reached = float(np.sum(activations**2)), []
    for restart in range(restarts):
        start = int(np.random.SeedSequence([seed, count, restart]).generate_state(1)[0])
        model = decomposition.NMF(
            count, init="random" if restart else "nndsvda", tol=PRECISION, max_iter=ITERATIONS, random_state=start
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)  # what it reached is compared with other restarts
            coefficients = model.fit_transform(activations)
        vaf = 1.0 - float(np.sum((activations - coefficients @ model.components_) ** 2)) / power
        reached.append(vaf)
        if best is None or vaf > best[0]:
            best = vaf, model.components_.T, coefficients.T
    assert best is not None
    return _described(activations, best[1], best[2], np.array(reached))


def reconstruct(activations: Floats, weights: Floats) -> Floats:
    """Coefficients C (N, T), not negative, of given synergies (M, N) that come nearest to activations (T, M)."""
    return np.array([nnls(weights, row)[0] for row in activations]).T


def _check(activations: Floats, count: int, restarts: int) -> None:
    samples, muscles = activations.shape
    if not np.isfinite(activations).all() or np.any(activations < 0.0) or not np.any(activations):
        raise SignalError("activations must be finite, not negative, and not all 0")
    if count < 1 or restarts < 1:
        raise SignalError(f"at least one synergy and one restart are needed, not {count} and {restarts}")
    check_size("restarts", restarts, SignalError)
    if count > min(samples, muscles):
        raise SignalError(
            f"{number_of(count, 'synergy')} are more than the {number_of(muscles, 'channel')} with "
            f"{number_of(samples, 'sample')} allow"
        )


def _described(activations: Floats, weights: Floats, coefficients: Floats, reached: Floats) -> Synergies:
    """The synergies in their order and scale, with what they account for."""
    scale = weights.max(axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    weights, coefficients = weights / scale, coefficients * scale[:, None]
    explained = np.sum(weights**2, axis=0) * np.sum(coefficients**2, axis=1)
    order = np.argsort(-explained, kind="stable")
    weights, coefficients = weights[:, order], coefficients[order]
    error = activations - (weights @ coefficients).T
    power = np.sum(activations**2, axis=0)
    muscle_vaf = 1.0 - np.sum(error**2, axis=0) / np.where(power > 0.0, power, 1.0)
    total = float(np.sum(error**2))
    r2 = 1.0 - total / float(np.sum((activations - activations.mean()) ** 2))
    account = Account(weights.shape[1], 1.0 - total / float(power.sum()), muscle_vaf, r2, reached)
    return Synergies(weights, coefficients, account)


def similarity(first: Floats, second: Floats) -> Floats:
    """Cosines (N, K) of the angles between the columns of W (M, N) and of another W (M, K)."""
    lengths = np.linalg.norm(first, axis=0)[:, None] * np.linalg.norm(second, axis=0)
    return np.asarray(first.T @ second / np.where(lengths > 0.0, lengths, 1.0))


def match(reference: Floats, weights: Floats) -> tuple[list[int], Floats]:
    """Which columns of W (M, K) go with those of a reference (M, N), and the cosines of these pairs.

    Pairs have the greatest sum of cosines (Hungarian method). Columns of W beyond N follow in their own order.

    Returns:
        order (K,) of the columns of W, and cosines (min(N, K),) of its first ones with the reference's.

    Raises:
        SignalError: not of as many muscles.
    """
    if reference.shape[0] != weights.shape[0]:
        raise SignalError(
            f"synergies of {reference.shape[0]} and of {number_of(weights.shape[0], 'muscle')} cannot be matched"
        )
    cosines = similarity(reference, weights)
    rows, columns = linear_sum_assignment(cosines, maximize=True)
    rest = [k for k in range(weights.shape[1]) if k not in columns]
    return [*columns.tolist(), *rest], cosines[rows, columns]
