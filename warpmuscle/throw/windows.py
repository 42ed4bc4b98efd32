"""Signals of motions that are unstable, fitted in short windows, each given those before it.

An arm above the shoulder falls by itself, so that late errors hang on early signals by powers of ten, and no step that
single precision allows is small enough to fit all signals at once. Within a window they do not: its signals make up
for what those before it left, as a feedback would, but are replayed without any.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.throw.follow import Follower
from warpmuscle.throw.least_squares import Prior, Unknowns, fit

WINDOW, MOVE = 0.25, 0.05  # s, how long windows are and by how much they move on
STEPS = 4  # of Levenberg-Marquardt in each
FINE_STEP = 2e-4  # of difference quotients
TOLERANCE = 0.02  # relative gain of a step, below which it is enough


def by_windows(follower: Follower, which: NDArray[np.intp], shared: Floats, distance: Floats) -> tuple[Floats, int]:
    """Signals (B, size) of some motions (B,), from the extracted ones on, and how many simulations that took.

    Args:
        shared: (P,) parameters. distance: (size, size) price of squared distances from the extracted signals.
    """
    individual, end, simulations = follower.extracted[which], follower.horizon, 0
    for until in [*np.arange(WINDOW, end - 0.5 * MOVE, MOVE).tolist(), end]:
        follower.horizon = until
        simulations += _window(follower, which, individual, shared, distance)
    return individual, simulations


def _window(follower: Follower, which: NDArray[np.intp], individual: Floats, shared: Floats, distance: Floats) -> int:
    """Fit the signals of the window that ends with the follower's horizon, in place."""
    until, time, count = follower.horizon, follower.knots.time, follower.synergies.count
    near = (time > until - WINDOW - 1e-9) & (time < until + MOVE - 1e-9)
    chosen = np.concatenate([np.tile(near, count), np.full(count, until <= WINDOW + 1e-9)])
    free, others = np.flatnonzero(chosen), np.flatnonzero(~chosen)
    extracted = follower.extracted[which]
    block, away = distance[np.ix_(free, free)], (individual - extracted)[:, others]
    reference = extracted[:, free] - np.linalg.solve(block, distance[np.ix_(free, others)] @ away.T).T

    def residuals(rows: NDArray[np.intp], x: Floats, z: Floats) -> Floats:
        whole = individual[rows]
        whole[:, free] = x
        return follower.residuals(which[rows], whole, np.tile(shared, (len(rows), 1)))

    size = len(free)
    signals = Unknowns(individual[:, free], np.zeros(size), np.ones(size), FINE_STEP, None, [Prior(block, reference)])
    nothing = Unknowns(np.zeros(1), np.zeros(1), np.ones(1), 1.0, free=False)
    found = fit(residuals, signals, nothing, iterations=STEPS, tolerance=TOLERANCE)
    individual[:, free] = found.individual
    return found.simulations
