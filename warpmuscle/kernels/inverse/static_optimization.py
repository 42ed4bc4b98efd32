"""Static optimisation of many frames: the activations of least cost that make given generalised forces.

Of each frame, with B the generalised forces of muscles at full activation, D strengths of reserves, tau what is needed:

    minimise  sum of c_j(a_j) + 1/2 sum r_i^2    so that  B a + D r = tau,  low <= a <= high

The unknown is one multiplier m a *coordinate*: a(m) minimises c_j(a) - (B^T m)_j a within its bounds, and r = D m. So
what is left is h(m) = B a(m) + D^2 m - tau = 0, the slope of a convex function, which Newton's method solves with the
exact zero of the slope along each step: H d = -h with H = B diag(da/dy) B^T + D^2.

Muscles of different limbs share no coordinate. What is solved is a group of coordinates that muscles connect, so the
matrices are small. A group of a run of frames is a thread's; within a run, bounds of a frame may follow from the one
before.

Where muscles do not suffice, multipliers of reserves are so large that single precision does not tell how muscles
balance each other: such frames are solved again in double precision.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.inverse.static_optimization_steps import LINEAR as LINEAR
from warpmuscle.kernels.inverse.static_optimization_steps import POWER as POWER
from warpmuscle.kernels.inverse.static_optimization_steps import (
    Cost,
    Frames,
    Group,
    Groups,
    Types,
    balance_of,
    begin_of,
    step_length_of,
    types_of,
)

ITERATIONS = 60  # of Newton's method at most
BALANCED = 2.0e-5  # of what a coordinate's muscles can make, (sum B^2 + D^2)^1/2, that the balance may miss
LEAST_PIVOT = 1.0e-7  # of a diagonal entry


@cache
def newton_step_of(types: Types) -> Any:
    """The Warp function (n, H, h, d) of d = -H^-1 h by Cholesky's factors, in place of the lower half of H."""
    real, vector, matrix = types.real, types.vector, types.matrix

    @wp.func
    def newton_step(n: int, hessian: wp.ref[matrix], h: wp.ref[vector], d: wp.ref[vector]):
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
        multiplier: (frames, speeds). iterations: (frames, groups), -1 where the balance was not reached.
    """
    types = types_of(coordinates, muscles, rates, real)
    vector, matrix, by_muscle, bounds = types.vector, types.matrix, types.by_muscle, types.bounds
    begin, balance, newton_step = begin_of(types, rates), balance_of(law, types, rates), newton_step_of(types)
    step_length = step_length_of(law, types, rates)

    @wp.kernel(module="unique", enable_backward=False, module_options={"enable_backward": False, "max_unroll": 1})
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
        all_groups = groups
        all_frames = frames
        costs = cost
        y = by_muscle()
        dy = by_muscle()
        lows = bounds()
        highs = bounds()
        x = vector()
        d = vector()
        h = vector()
        scale = vector()
        hessian = matrix()
        for f in range(runs[0, run], runs[1, run]):
            g.frame = f
            begin(g, runs[0, run], all_groups, all_frames, costs, activation, lows, highs, scale, x)
            count = wp.int32(0)
            done = wp.int32(0)
            while done == 0:
                balance(g, all_groups, all_frames, costs, lows, highs, x, activation, y, h, hessian)
                error = real(0.0)
                for i in range(g.coordinates):
                    error = wp.max(error, wp.abs(h[i]) * scale[i])
                if error < real(BALANCED):
                    done = 1
                elif count == ITERATIONS or not (error < real(1.0e30)):
                    done = 1
                    count = -1
                else:
                    count += 1
                    newton_step(g.coordinates, hessian, h, d)
                    t = step_length(g, all_groups, all_frames, costs, lows, highs, x, h, d, y, dy)
                    for i in range(g.coordinates):
                        x[i] = x[i] + t * d[i]
            for i in range(g.coordinates):
                multiplier[f, groups.coordinate[g.first + i]] = wp.float32(x[i])
            iterations[f, group] = count

    return kernel
