"""Parts of a Newton step of a quadratic programme: the balance of forces with its slope, and the length of a step."""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.inverse.static_optimization_steps import EXACT, SEARCHES
from warpmuscle.kernels.program.reduction import cholesky, place, solve
from warpmuscle.kernels.program.structs import Columns

LEAST_PIVOT = 1.0e-14  # of a diagonal entry


@wp.struct
class Controls:
    """What is known of the controls of a programme."""

    gain: wp.array[float]
    low: wp.array[float]
    high: wp.array[float]
    entry: wp.array[float]


@func
def control_of(y: wp.float64, j: int, controls: Controls) -> wp.vec2d:
    """The control within its bounds that minimises 1/2 c u^2 - y u, and its slope by y, which is 0 at a bound."""
    gain = wp.float64(controls.gain[j])
    u = gain * y
    within = wp.max(wp.float64(controls.low[j]), wp.min(u, wp.float64(controls.high[j])))
    return wp.vec2d(within, wp.where(u == within, gain, wp.float64(0.0)))


@func
def along_of(j: int, columns: Columns, entry: wp.array[float], x: wp.array[wp.float64]) -> wp.float64:
    """(B^T x) of a control."""
    s = wp.float64(0.0)
    for e in range(columns.first[j], columns.first[j + 1]):
        s += wp.float64(entry[e]) * x[columns.row[e]]
    return s


@func
def balance(
    n: int, m: int, controls: Controls, columns: Columns, reserve: wp.array[wp.float64], x: wp.array[wp.float64],
    y: wp.array[wp.float64], needed: wp.array[wp.float64], h: wp.array[wp.float64], size: wp.array[wp.float64],
    hessian: wp.array[wp.float64],
):  # fmt: skip
    """y = B^T x by control, the balance h = R x + B u - needed, its slope, and its sizes.

    A size is the sum of what stands on both sides of the balance of a coordinate.
    """
    for i in range(n):
        h[i] = -needed[i]
        size[i] = wp.abs(needed[i])
    for i in range(n):
        total = wp.float64(0.0)
        for q in range(i):
            r = reserve[place(i, q)]
            hessian[place(i, q)] = r
            total += r * x[q]
            h[q] = h[q] + r * x[i]
        r = reserve[place(i, i)]
        hessian[place(i, i)] = r
        h[i] = h[i] + total + r * x[i]
    for j in range(m):
        s = along_of(j, columns, controls.entry, x)
        y[j] = s
        answer = control_of(s, j, controls)
        u = answer[0]
        slope = answer[1]
        begin = columns.first[j]
        for e in range(begin, columns.first[j + 1]):
            i = columns.row[e]
            b = wp.float64(controls.entry[e])
            h[i] = h[i] + b * u
            size[i] = size[i] + wp.abs(b * u)
            if slope > wp.float64(0.0):
                for k in range(begin, e + 1):
                    at = place(i, columns.row[k])
                    hessian[at] = hessian[at] + b * slope * wp.float64(controls.entry[k])


@func
def newton_step(n: int, hessian: wp.array[wp.float64], h: wp.array[wp.float64], d: wp.array[wp.float64]):
    """The step d = -H^-1 h by Cholesky's factors, in place of H."""
    cholesky(n, LEAST_PIVOT, hessian)
    for i in range(n):
        d[i] = -h[i]
    solve(n, hessian, d)


@func
def step_length(
    n: int, m: int, controls: Controls, columns: Columns, reserve: wp.array[wp.float64], x: wp.array[wp.float64],
    d: wp.array[wp.float64], y: wp.array[wp.float64], dy: wp.array[wp.float64], needed: wp.array[wp.float64],
    h: wp.array[wp.float64],
) -> wp.float64:  # fmt: skip
    """The step along d to where the slope is zero, by its own rate within a bracket."""
    start = wp.float64(0.0)
    constant = wp.float64(0.0)
    rate = wp.float64(0.0)
    for i in range(n):
        start += d[i] * h[i]
        constant -= d[i] * needed[i]
        for q in range(i):
            r = reserve[place(i, q)]
            constant += r * (d[i] * x[q] + d[q] * x[i])
            rate += wp.float64(2.0) * r * d[i] * d[q]
        r = reserve[place(i, i)]
        constant += r * d[i] * x[i]
        rate += r * d[i] * d[i]
    for j in range(m):
        dy[j] = along_of(j, columns, controls.entry, d)
    t = wp.float64(1.0)
    below = wp.float64(0.0)
    above = wp.float64(-1.0)
    for _ in range(SEARCHES):
        value = constant + rate * t
        bend = rate
        for j in range(m):
            rise = dy[j]
            answer = control_of(y[j] + t * rise, j, controls)
            value += rise * answer[0]
            bend += answer[1] * rise * rise
        if wp.abs(value) <= wp.float64(EXACT) * wp.abs(start):
            break
        if value < wp.float64(0.0):
            below = t
        else:
            above = t
        following = t - value / wp.max(bend, wp.float64(1.0e-30))
        if above < wp.float64(0.0):
            t = wp.min(wp.max(following, wp.float64(1.25) * t), wp.float64(64.0) * t)
        elif following <= below or following >= above:
            t = wp.float64(0.5) * (below + above)
        else:
            t = following
        if above > wp.float64(0.0) and above - below <= wp.float64(1.0e-6) * above:
            break
    return t
