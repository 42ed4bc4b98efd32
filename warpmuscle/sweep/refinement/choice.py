"""Where between limits to look next: where results change most for the distance to what is known.

In the manner of sequential designs that weigh how far a place is from all points by how much its neighbours differ
(Crombecq, Gorissen, Deschrijver, Dhaene 2011, SIAM J. Sci. Comput. 33:1948-1974).
"""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats, Integers

CANDIDATES = 1024  # places, of which one is chosen
FLOOR = 0.1  # of the whole range of results: neighbours count as so different at least, so that no gap stays


def next_points(points: Floats, values: Floats, count: int, seed: int) -> Floats:
    """So many further points (count, d) of the unit cube; fewer are the first of these.

    Args:
        points: (n, d) that are known. values: (n, m) what came of them under m conditions, NaN where nothing did.
        seed: of the places that are looked at.
    """
    from scipy.spatial.distance import cdist  # not needed by other sweeps

    known, own = np.array(points, dtype=np.float64), _scaled(np.array(values, dtype=np.float64))
    for _ in range(count):
        places = np.random.default_rng([seed, len(known)]).random((CANDIDATES, known.shape[1]))
        away = cdist(places, known)
        near = _neighbours(away, own, known.shape[1] + 1)
        spread = np.ptp(own[near], axis=1).mean(axis=1) if near.size else np.zeros(CANDIDATES)
        best = int(np.argmax(away.min(axis=1) * (FLOOR + spread)))
        weight = 1.0 / np.maximum(away[best, near[best]], 1e-12)
        expected = weight @ own[near[best]] / weight.sum() if near.size else np.full(own.shape[1], np.nan)
        known, own = np.vstack([known, places[best]]), np.vstack([own, expected])
    return known[len(points) :]


def _neighbours(away: Floats, values: Floats, most: int) -> Integers:
    """The nearest points with results of each place, (c, k)."""
    sound = np.flatnonzero(np.isfinite(values).all(axis=1))
    order = np.argsort(away[:, sound], axis=1, kind="stable")
    return np.asarray(sound[order[:, :most]])


def _scaled(values: Floats) -> Floats:
    """Results over their range, condition by condition."""
    sound = values[np.isfinite(values).all(axis=1)]
    if not len(sound):
        return values
    low, high = sound.min(axis=0), sound.max(axis=0)
    return np.asarray((values - low) / np.where(high > low, high - low, 1.0))
