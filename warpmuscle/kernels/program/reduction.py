"""How wanted accelerations and their weights become the reserve of a balance of forces, and accelerations again.

With W = L L^T, K = L^-1 M: accelerations that give way by W^-1 M x to a multiplier x of forces need R x = K^T K x.
"""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.program.lanes import inverse_root

LEAST_PIVOT = 1.0e-12  # of a diagonal entry of W


@func
def place(i: int, j: int) -> int:
    """Where a lower half keeps the entry of row i and column j <= i."""
    return (i * (i + 1) >> 1) + j


@func
def cholesky(n: int, least: float, a: wp.array[wp.float64]):
    """The lower factor of a symmetric matrix, its diagonal inverted, in place; `least` pivots of diagonal entries."""
    for i in range(n):
        for j in range(i):
            s = a[place(i, j)]
            for q in range(j):
                s -= a[place(i, q)] * a[place(j, q)]
            a[place(i, j)] = s * a[place(j, j)]
        diagonal = a[place(i, i)]
        s = diagonal
        for q in range(i):
            s -= a[place(i, q)] * a[place(i, q)]
        a[place(i, i)] = inverse_root(wp.max(s, diagonal * wp.float64(least)))


@func
def solve(n: int, factor: wp.array[wp.float64], x: wp.array[wp.float64]):
    """The solution of a system with such a factor, in place of its right side."""
    for i in range(n):
        total = x[i]
        for q in range(i):
            total -= factor[place(i, q)] * x[q]
        x[i] = total * factor[place(i, i)]
    for back in range(n):
        i = n - 1 - back
        total = x[i]
        for q in range(i + 1, n):
            total -= factor[place(q, i)] * x[q]
        x[i] = total * factor[place(i, i)]


@func
def factorize(n: int, weight: wp.array[float], factor: wp.array[wp.float64]):
    """The Cholesky factor of W, its diagonal inverted."""
    for i in range(n):
        for j in range(i + 1):
            factor[place(i, j)] = wp.float64(weight[i * n + j])
    cholesky(n, LEAST_PIVOT, factor)


@func
def needed_forces(
    n: int, mass: wp.array[float], bias: wp.array[float], wanted: wp.array[float], needed: wp.array[wp.float64]
):
    """Forces of wanted accelerations, M wanted + h."""
    for i in range(n):
        total = wp.float64(bias[i])
        for s in range(n):
            total += wp.float64(mass[i * n + s]) * wp.float64(wanted[s])
        needed[i] = total


@func
def reserve_of(
    n: int, mass: wp.array[float], factor: wp.array[wp.float64], square: wp.array[wp.float64],
    reserve: wp.array[wp.float64],
):  # fmt: skip
    """R = M W^-1 M; `square` has room for L^-1 M."""
    for s in range(n):
        for i in range(n):
            value = wp.float64(mass[i * n + s])
            for q in range(i):
                value -= factor[place(i, q)] * square[q * n + s]
            square[i * n + s] = value * factor[place(i, i)]
    for i in range(n):
        for s in range(i + 1):
            total = wp.float64(0.0)
            for q in range(n):
                total += square[q * n + i] * square[q * n + s]
            reserve[place(i, s)] = total


@func
def accelerations(
    n: int, mass: wp.array[float], wanted: wp.array[float], factor: wp.array[wp.float64], x: wp.array[wp.float64],
    work: wp.array[wp.float64], acceleration: wp.array[float],
):  # fmt: skip
    """Accelerations wanted - W^-1 M x; `work` has room for n numbers."""
    for i in range(n):
        total = wp.float64(0.0)
        for s in range(n):
            total += wp.float64(mass[i * n + s]) * x[s]
        work[i] = total
    solve(n, factor, work)
    for i in range(n):
        acceleration[i] = wp.float32(wp.float64(wanted[i]) - work[i])


@func
def solve_weights(
    n: int, pull: wp.array[float], factor: wp.array[wp.float64], work: wp.array[wp.float64], wanted: wp.array[float]
):
    """Wanted accelerations W^-1 pull; `work` has room for n numbers."""
    for i in range(n):
        work[i] = wp.float64(pull[i])
    solve(n, factor, work)
    for i in range(n):
        wanted[i] = wp.float32(work[i])
