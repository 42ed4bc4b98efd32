"""Parts of a Newton step of a quadratic programme: the balance of forces with its slope, and the length of a step."""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.inverse.static_optimization_steps import EXACT, SEARCHES
from warpmuscle.kernels.program.reduction import cholesky, place, solve
from warpmuscle.kernels.program.structs import Columns, Programs

LEAST_PIVOT = 1.0e-14  # of a diagonal entry
ITERATIONS = 60  # of Newton's method at most
BALANCED = 1.0e-12  # of what stands on both sides, that the balance may miss ...
NEARLY = 1.0e-8  # ... or, where another step makes it no better
SMALLEST = 1.0e-9  # N or N m, of what stands there, that is told from nothing
GOES_ON, REACHED, GIVEN_UP = wp.constant(0), wp.constant(1), wp.constant(-1)


@wp.struct
class Controls:
    """What is known of the controls of a programme."""

    gain: wp.array[float]
    low: wp.array[float]
    high: wp.array[float]
    entry: wp.array[float]


@func
def controls_at(p: int, programs: Programs) -> Controls:
    """Those of a programme but for their entries, of which programmes may have rows of their own."""
    controls = Controls()
    controls.gain = programs.gain[wp.min(p, programs.gain.shape[0] - 1)]
    controls.low = programs.low[wp.min(p, programs.low.shape[0] - 1)]
    controls.high = programs.high[wp.min(p, programs.high.shape[0] - 1)]
    return controls


@func
def outcome(count: int, error: wp.float64, before: wp.float64) -> int:
    """Whether Newton's method goes on after so many steps, by how far the balance is missed now and was before."""
    if error < wp.float64(BALANCED) or (error < wp.float64(NEARLY) and error > wp.float64(0.5) * before):
        return REACHED
    if count == ITERATIONS or not (error < wp.float64(1.0e30)):
        return GIVEN_UP
    return GOES_ON


@func
def narrowed(t: wp.float64, value: wp.float64, bracket: wp.vec2d) -> wp.vec2d:
    """The bracket of a step's length that is left with the slope at a length in it; -1 above: not known yet."""
    if value < wp.float64(0.0):
        return wp.vec2d(t, bracket[1])
    return wp.vec2d(bracket[0], t)


@func
def next_length(t: wp.float64, value: wp.float64, bend: wp.float64, bracket: wp.vec2d) -> wp.float64:
    """Where the slope is zero by its rate at a length, if that is within the bracket."""
    below = bracket[0]
    above = bracket[1]
    following = t - value / wp.max(bend, wp.float64(1.0e-30))
    if above < wp.float64(0.0):
        return wp.min(wp.max(following, wp.float64(1.25) * t), wp.float64(64.0) * t)
    if following <= below or following >= above:
        return wp.float64(0.5) * (below + above)
    return following


@func
def is_narrow(bracket: wp.vec2d) -> bool:
    """Whether a bracket is too small to look further."""
    return bracket[1] > wp.float64(0.0) and bracket[1] - bracket[0] <= wp.float64(1.0e-6) * bracket[1]


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
    bracket = wp.vec2d(wp.float64(0.0), wp.float64(-1.0))
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
        bracket = narrowed(t, value, bracket)
        t = next_length(t, value, bend, bracket)
        if is_narrow(bracket):
            break
    return t
