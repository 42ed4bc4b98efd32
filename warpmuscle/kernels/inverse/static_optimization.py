"""Static optimisation of many frames: the activations of least cost that make given generalised forces.

Of each frame, with B the generalised forces of muscles at full activation, D strengths of reserves, tau what is needed:

    minimise  sum of c_j(a_j) + sum of |r_i|^p / p    so that  B a + D r = tau,  low <= a <= high

where p is 2, or the power of c_j where that is greater. The unknown is one multiplier m a *coordinate*: a(m) minimises
c_j(a) - (B^T m)_j a within its bounds, and r = D m, or its (p - 1)th root. So what is left is
h(m) = B a(m) + D r(m) - tau = 0, the slope of a convex function, which Newton's method solves with the
exact zero of the slope along each step: H d = -h with H = B diag(da/dy) B^T + D diag(dr/dm).

Muscles of different limbs share no coordinate. What is solved is a group of coordinates that muscles connect, so the
matrices are small. A group of a run of frames is a thread's; within a run, bounds of a frame may follow from the one
before.

Where muscles do not suffice, multipliers of reserves are so large that single precision does not tell how muscles
balance each other: such frames stop coming closer, and are solved again in double precision, from where they are.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.functions import build_options
from warpmuscle.kernels.inverse.static_optimization_steps import LINEAR as LINEAR
from warpmuscle.kernels.inverse.static_optimization_steps import POWER as POWER
from warpmuscle.kernels.inverse.static_optimization_steps import (
    Cost,
    Frames,
    Group,
    Groups,
    balance_of,
    begin_of,
    step_length_of,
)

ITERATIONS = 60  # of Newton's method at most
BALANCED = 2.0e-5  # of what a coordinate's muscles can make, (sum B^2 + D^2)^1/2, that the balance may miss
LEAST_PIVOT = 1.0e-7  # of a diagonal entry
CLOSE, STALLED = 1.0e-3, 2  # a balance that is missed by less, and is not halved so often, is rounding


@cache
def newton_step_of(real: Any) -> Any:
    """The Warp function (n, H, h, d) of d = -H^-1 h by Cholesky's factors, in place of the lower half of H."""

    @wp.func
    def newton_step(n: int, hessian: wp.array2d[real], h: wp.array[real], d: wp.array[real]):
        for i in range(n):
            diagonal = hessian[i, i]
            for j in range(i):
                s = hessian[i, j]
                for q in range(j):
                    s -= hessian[i, q] * hessian[j, q]
                hessian[i, j] = s * hessian[j, j]
            s = diagonal
            for q in range(i):
                s -= hessian[i, q] * hessian[i, q]
            hessian[i, i] = real(1.0) / wp.sqrt(wp.max(s, diagonal * real(LEAST_PIVOT)))  # 1 over the factor's entry
            s = -h[i]
            for q in range(i):
                s -= hessian[i, q] * d[q]
            d[i] = s * hessian[i, i]
        for back in range(n):
            i = n - 1 - back
            s = d[i]
            for q in range(i + 1, n):
                s -= hessian[q, i] * d[q]
            d[i] = s * hessian[i, i]

    return newton_step


@cache
def static_optimization_of(
    law: int, coordinates: int, muscles: int, rates: bool = False, real: Any = wp.float32
) -> Any:
    """The kernel (groups, frames, cost, runs, activation, multiplier, iterations); launch with (groups, runs).

    Args:
        law: see `activation_of`. coordinates, muscles: most that a group has. rates: whether a frame's bounds follow
            from the one before in its run. real: wp.float32 or wp.float64, in which it is solved.

    What the kernel takes and gives:
        runs: (2, runs) first frames of runs, and those after their last. activation: (frames, muscles).
        multiplier: (frames, speeds); in double precision also where the search begins.
        iterations: (frames, groups), -1 where the balance was not reached.
    """
    begin, balance, newton_step = begin_of(rates, real), balance_of(law, rates, real), newton_step_of(real)
    step_length, single = step_length_of(law, rates, real), real is wp.float32
    n, m = max(coordinates, 1), max(muscles, 1)
    bounds = m if rates else 1

    @wp.kernel(
        module="unique",
        enable_backward=False,
        module_options={"enable_backward": False, "max_unroll": 1, **build_options()},
    )
    def kernel(
        # in
        groups: Groups, frames: Frames, cost: Cost, runs: wp.array2d[int],
        # out
        activation: wp.array2d[float], multiplier: wp.array2d[float], iterations: wp.array2d[int],
    ):  # fmt: skip
        group, run = wp.tid()
        g = Group()
        g.first = groups.first_coordinate[group]
        g.coordinates = groups.first_coordinate[group + 1] - g.first
        g.first_muscle = groups.first_muscle[group]
        g.muscles = groups.first_muscle[group + 1] - g.first_muscle
        y = wp.zeros(shape=m, dtype=real)
        dy = wp.zeros(shape=m, dtype=real)
        lows = wp.zeros(shape=bounds, dtype=real)
        highs = wp.zeros(shape=bounds, dtype=real)
        x = wp.zeros(shape=n, dtype=real)
        d = wp.zeros(shape=n, dtype=real)
        h = wp.zeros(shape=n, dtype=real)
        scale = wp.zeros(shape=n, dtype=real)
        hessian = wp.zeros(shape=(n, n), dtype=real)
        for f in range(runs[0, run], runs[1, run]):
            g.frame = f
            begin(g, runs[0, run], groups, frames, cost, activation, lows, highs, scale, x)
            count = wp.int32(0)
            known = wp.int32(0)  # whether it goes on
            if wp.static(not single):
                for i in range(g.coordinates):
                    nearly = multiplier[f, groups.coordinate[g.first + i]]
                    if wp.isfinite(nearly) and nearly != 0.0:
                        x[i] = real(nearly)
                        known = 1
            done = wp.int32(0)
            before = real(1.0e30)
            stalled = wp.int32(0)
            while done == 0:
                balance(count + known, g, groups, frames, cost, lows, highs, x, activation, y, h, hessian)
                error = real(0.0)
                for i in range(g.coordinates):
                    error = wp.max(error, wp.abs(h[i]) * scale[i])
                if wp.static(single):  # noqa: SIM102, with `and` it would be compiled in all the same
                    if error < real(CLOSE) and error > real(0.5) * before:
                        stalled += 1
                before = error
                if error < real(BALANCED):
                    done = 1
                elif count == ITERATIONS or stalled == STALLED or not (error < real(1.0e30)):
                    done = 1
                    count = -1
                else:
                    count += 1
                    newton_step(g.coordinates, hessian, h, d)
                    t = step_length(g, groups, frames, cost, lows, highs, x, h, d, y, dy)
                    for i in range(g.coordinates):
                        x[i] = x[i] + t * d[i]
            for i in range(g.coordinates):
                multiplier[f, groups.coordinate[g.first + i]] = wp.float32(x[i])
            iterations[f, group] = count

    return kernel
