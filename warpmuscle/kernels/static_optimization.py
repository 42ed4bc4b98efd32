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

LINEAR, POWER = 0, 1  # how activations follow: clip(gain y + shift), or clip((gain y)^exponent)
ITERATIONS = 60  # of Newton's method at most
SEARCHES = 50  # of the slope's zero along a step at most
EXACT = 5.0e-4  # of the slope at the start of a step, that may be left
BALANCED = 2.0e-5  # of what a coordinate's muscles can make, (sum B^2 + D^2)^1/2, that the balance may miss
LEAST_PIVOT = 1.0e-7  # of a diagonal entry


@wp.struct
class Cost:
    """Costs and bounds of activations."""

    gain: wp.array2d[float]  # (frames or 1, muscles)
    shift: wp.array2d[float]  # (frames or 1, muscles)
    exponent: float  # 1/(p - 1) of costs a^p; unless the law is linear
    low: wp.array[float]  # (muscles,) bounds
    high: wp.array[float]
    rise: wp.array2d[float]  # (frames, muscles) of the way to `high` from the frame before; empty: not bounded so
    fall: wp.array2d[float]  # and of the way to `low`


@wp.struct
class Groups:
    """Coordinates that muscles connect, a group after the other, and the muscles of each."""

    first_coordinate: wp.array[int]  # (groups + 1,) in `coordinate`
    coordinate: wp.array[int]  # numbers of the speeds
    first_muscle: wp.array[int]  # (groups + 1,) in `muscle`
    muscle: wp.array[int]
    first_lever: wp.array[int]  # (all muscles + 1,) in `lever` and `place`
    lever: wp.array[int]  # number in moment arms
    place: wp.array[int]  # of the coordinate within its group


@wp.struct
class Frames:
    """What is known of every frame."""

    moment_arm: wp.array2d[float]  # (frames, levers) m
    active: wp.array2d[float]  # (frames, muscles) N
    needed: wp.array2d[float]  # (frames, speeds) N and N m
    reserve: wp.array[float]  # (speeds,) D, N and N m


@cache
def activation_of(law: int, real: Any) -> Any:
    """The Warp function (y, gain, shift, exponent, low, high) -> activation and its slope by y, in a precision.

    Args:
        law: LINEAR, clip(gain y + shift), or POWER, clip((gain y)^exponent). real: wp.float32 or wp.float64.
    """
    pair = wp.types.vector(length=2, dtype=real)

    @wp.func
    def linear(y: real, gain: real, shift: real, exponent: real, low: real, high: real) -> pair:
        a = gain * y + shift
        return pair(wp.clamp(a, low, high), wp.where(a > low and a < high, gain, real(0.0)))

    @wp.func
    def power(y: real, gain: real, shift: real, exponent: real, low: real, high: real) -> pair:
        if y <= real(0.0):
            return pair(low, real(0.0))
        a = wp.pow(gain * y, exponent)
        return pair(wp.clamp(a, low, high), wp.where(a > low and a < high, exponent * a / y, real(0.0)))

    return linear if law == LINEAR else power


@cache
def newton_step_of(coordinates: int, real: Any) -> Any:
    """The Warp function (n, H, h, d) of d = -H^-1 h by Cholesky's factors, in place of the lower half of H."""
    vector = wp.types.vector(length=coordinates, dtype=real)
    matrix = wp.types.matrix(shape=(coordinates, coordinates), dtype=real)

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
    answer, newton_step = activation_of(law, real), newton_step_of(max(coordinates, 1), real)
    vector = wp.types.vector(length=max(coordinates, 1), dtype=real)
    matrix = wp.types.matrix(shape=(max(coordinates, 1), max(coordinates, 1)), dtype=real)
    long_vector = wp.types.vector(length=max(muscles, 1), dtype=real)
    bounds = wp.types.vector(length=max(muscles, 1) if rates else 1, dtype=real)

    @wp.kernel(module="unique", enable_backward=False, module_options={"max_unroll": 1})
    def kernel(
        # in
        groups: Groups, frames: Frames, cost: Cost, runs: wp.array2d[int],
        # out
        activation: wp.array2d[float], multiplier: wp.array2d[float], iterations: wp.array2d[int],
    ):  # fmt: skip
        group, run = wp.tid()
        first = groups.first_coordinate[group]
        n = groups.first_coordinate[group + 1] - first
        first_muscle = groups.first_muscle[group]
        m = groups.first_muscle[group + 1] - first_muscle
        exponent = real(cost.exponent)
        y = long_vector()
        dy = long_vector()
        lows = bounds()
        highs = bounds()
        x = vector()
        d = vector()
        h = vector()
        scale = vector()
        hessian = matrix()
        for f in range(runs[0, run], runs[1, run]):
            costs = wp.min(f, cost.gain.shape[0] - 1)
            for i in range(n):
                reserve = real(frames.reserve[groups.coordinate[first + i]])
                scale[i] = reserve * reserve
                x[i] = real(0.0)
            for j in range(m):
                muscle = groups.muscle[first_muscle + j]
                if wp.static(rates):
                    low = real(cost.low[muscle])
                    high = real(cost.high[muscle])
                    if f > runs[0, run]:
                        before = real(activation[f - 1, muscle])
                        low = before - real(cost.fall[f, muscle]) * (before - low)
                        high = before + real(cost.rise[f, muscle]) * (high - before)
                    lows[j] = low
                    highs[j] = high
                force = real(frames.active[f, muscle])
                for e in range(groups.first_lever[first_muscle + j], groups.first_lever[first_muscle + j + 1]):
                    b = real(frames.moment_arm[f, groups.lever[e]]) * force
                    i = groups.place[e]
                    scale[i] = scale[i] + b * b
            for i in range(n):
                scale[i] = real(1.0) / wp.sqrt(scale[i])
            count = wp.int32(0)
            done = wp.int32(0)
            while done == 0:
                for i in range(n):
                    speed = groups.coordinate[first + i]
                    reserve = real(frames.reserve[speed])
                    h[i] = reserve * reserve * x[i] - real(frames.needed[f, speed])
                    for q in range(i):
                        hessian[i, q] = real(0.0)
                    hessian[i, i] = reserve * reserve
                for j in range(m):
                    muscle = groups.muscle[first_muscle + j]
                    force = real(frames.active[f, muscle])
                    begin = groups.first_lever[first_muscle + j]
                    end = groups.first_lever[first_muscle + j + 1]
                    s = real(0.0)
                    for e in range(begin, end):
                        s += real(frames.moment_arm[f, groups.lever[e]]) * x[groups.place[e]]
                    y[j] = s * force
                    least = real(cost.low[muscle])
                    most = real(cost.high[muscle])
                    if wp.static(rates):
                        least = lows[j]
                        most = highs[j]
                    a = answer(
                        y[j], real(cost.gain[costs, muscle]), real(cost.shift[costs, muscle]), exponent, least, most
                    )
                    activation[f, muscle] = wp.float32(a[0])
                    pull = a[0] * force
                    for e in range(begin, end):
                        i = groups.place[e]
                        h[i] = h[i] + real(frames.moment_arm[f, groups.lever[e]]) * pull
                    if a[1] > real(0.0):
                        slope = a[1] * force * force
                        for e in range(begin, end):
                            i = groups.place[e]
                            part = real(frames.moment_arm[f, groups.lever[e]]) * slope
                            for k in range(begin, e + 1):  # places of a muscle increase
                                q = groups.place[k]
                                hessian[i, q] = hessian[i, q] + part * real(frames.moment_arm[f, groups.lever[k]])
                error = real(0.0)
                for i in range(n):
                    error = wp.max(error, wp.abs(h[i]) * scale[i])
                if error < real(BALANCED):
                    done = 1
                elif count == ITERATIONS or not (error < real(1.0e30)):
                    done = 1
                    count = -1
                else:
                    count += 1
                    newton_step(n, hessian, h, d)
                    start = real(0.0)
                    constant = real(0.0)
                    rate = real(0.0)
                    for i in range(n):
                        speed = groups.coordinate[first + i]
                        reserve = real(frames.reserve[speed])
                        start += d[i] * h[i]
                        constant += d[i] * (reserve * reserve * x[i] - real(frames.needed[f, speed]))
                        rate += d[i] * reserve * reserve * d[i]
                    for j in range(m):
                        s = real(0.0)
                        for e in range(groups.first_lever[first_muscle + j], groups.first_lever[first_muscle + j + 1]):
                            s += real(frames.moment_arm[f, groups.lever[e]]) * d[groups.place[e]]
                        dy[j] = s * real(frames.active[f, groups.muscle[first_muscle + j]])
                    # The zero of the slope along d, which rises with t: by its own rate, within a bracket.
                    t = real(1.0)
                    below = real(0.0)
                    above = real(-1.0)
                    for _ in range(SEARCHES):
                        value = constant + rate * t
                        bend = rate
                        for j in range(m):
                            muscle = groups.muscle[first_muscle + j]
                            least = real(cost.low[muscle])
                            most = real(cost.high[muscle])
                            if wp.static(rates):
                                least = lows[j]
                                most = highs[j]
                            a = answer(
                                y[j] + t * dy[j], real(cost.gain[costs, muscle]), real(cost.shift[costs, muscle]),
                                exponent, least, most,
                            )  # fmt: skip
                            value += dy[j] * a[0]
                            bend += a[1] * dy[j] * dy[j]
                        if wp.abs(value) <= real(EXACT) * wp.abs(start):
                            break
                        if value < real(0.0):
                            below = t
                        else:
                            above = t
                        following = t - value / wp.max(bend, real(1.0e-30))
                        if above < real(0.0):
                            t = wp.min(wp.max(following, real(1.25) * t), real(64.0) * t)
                        elif following <= below or following >= above:
                            t = real(0.5) * (below + above)
                        else:
                            t = following
                        if above > real(0.0) and above - below <= real(1.0e-6) * above:
                            break
                    for i in range(n):
                        x[i] = x[i] + t * d[i]
            for i in range(n):
                multiplier[f, groups.coordinate[first + i]] = wp.float32(x[i])
            iterations[f, group] = count

    return kernel
