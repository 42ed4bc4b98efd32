"""Symmetric matrices of a programme that lanes share: the lower half, row by row, of which a lane has rows."""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.program.lanes import inverse_root, synchronize
from warpmuscle.kernels.program.reduction import place


@func
def lane_cholesky(lane: int, lanes: int, n: int, least: float, a: wp.array[wp.float64]):
    """The lower factor of a symmetric matrix, its diagonal inverted, in place; `least` pivots of diagonal entries."""
    for j in range(n):
        own = place(j, 0)
        for i in range(j + lane, n, lanes):
            at = place(i, 0)
            s = a[at + j]
            for q in range(j):
                s -= a[at + q] * a[own + q]
            if i == j:
                a[own + j] = inverse_root(wp.max(s, a[own + j] * wp.float64(least)))
            else:
                a[at + j] = s
        synchronize()
        inverse = a[own + j]
        for i in range(j + 1 + lane, n, lanes):
            at = place(i, j)
            a[at] = a[at] * inverse
        synchronize()


@func
def lane_solve(lane: int, lanes: int, n: int, factor: wp.array[wp.float64], x: wp.array[wp.float64]):
    """The solution of a system with such a factor, in place of its right side, column by column."""
    for q in range(n):
        known = x[q] * factor[place(q, q)]
        for i in range(q + 1 + lane, n, lanes):
            x[i] = x[i] - factor[place(i, q)] * known
        synchronize()
        if lane == 0:
            x[q] = known  # nobody looks at it before all others are known
    synchronize()
    for back in range(n):
        q = n - 1 - back
        at = place(q, 0)
        known = x[q] * factor[at + q]
        for i in range(lane, q, lanes):
            x[i] = x[i] - factor[at + i] * known
        synchronize()
        if lane == 0:
            x[q] = known
    synchronize()


@func
def lane_product(
    lane: int, lanes: int, n: int, a: wp.array[wp.float64], x: wp.array[wp.float64], start: wp.array[wp.float64],
    result: wp.array[wp.float64],
):  # fmt: skip
    """A x - start, of a symmetric A."""
    for i in range(lane, n, lanes):
        total = wp.float64(0.0)
        at = place(i, 0)
        for q in range(i):
            total += a[at + q] * x[q]
        s = -start[i] + total + a[at + i] * x[i]
        for q in range(i + 1, n):
            s += a[place(q, i)] * x[q]
        result[i] = s
