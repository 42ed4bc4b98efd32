"""The linear-quadratic problem: least quadratic costs of a linear system over N steps, by Riccati's recursion.

A step leads from x to A x + B u + d. Its cost is 1/2 x Q x + q x + 1/2 u R u + r u + u S x, and 1/2 x Q_N x + q_N x at
the end (Bertsekas 2005, Dynamic Programming and Optimal Control, section 4.1). The first x is free.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats


class Costs(NamedTuple):
    """What N steps cost."""

    state: Floats  # Q (X, X)
    last: Floats  # Q_N (X, X)
    control: Floats  # R (U, U)
    cross: Floats  # S (U, X)
    slope: Floats  # q (N + 1, X)
    push: Floats  # r (N, U)


class Solution(NamedTuple):
    """The least costs' way, and the controls' answers to states beside it."""

    state: Floats  # (N + 1, X)
    control: Floats  # (N, U)
    gain: Floats  # (N, U, X)


def solve(a: Floats, b: Floats, d: Floats, costs: Costs) -> Solution:
    """The way of N steps, a (N, X, X), b (N, X, U), d (N, X), of least cost."""
    steps, size, controls = b.shape
    gain, constant = np.zeros((steps, controls, size)), np.zeros((steps, controls))
    slope, bend = costs.slope[steps], costs.last
    for k in range(steps - 1, -1, -1):
        ahead = slope + bend @ d[k]
        of_state, of_control = costs.slope[k] + a[k].T @ ahead, costs.push[k] + b[k].T @ ahead
        by_a = bend @ a[k]
        crossed = costs.cross + b[k].T @ by_a
        answer = np.linalg.solve(costs.control + b[k].T @ bend @ b[k], np.column_stack([crossed, of_control]))
        gain[k], constant[k] = -answer[:, :-1], -answer[:, -1]
        slope = of_state + crossed.T @ constant[k]
        bend = costs.state + a[k].T @ by_a + crossed.T @ gain[k]
        bend = 0.5 * (bend + bend.T)
    state, control = np.zeros((steps + 1, size)), np.zeros((steps, controls))
    state[0] = -np.linalg.solve(bend, slope)
    for k in range(steps):
        control[k] = gain[k] @ state[k] + constant[k]
        state[k + 1] = a[k] @ state[k] + b[k] @ control[k] + d[k]
    return Solution(state, control, gain)
