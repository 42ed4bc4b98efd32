"""The solver of `box_program.py` by lanes that share a programme: a warp of a GPU each, in shared memory."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.inverse.static_optimization_steps import EXACT, SEARCHES
from warpmuscle.kernels.program.lane_algebra import lane_cholesky, lane_product, lane_solve
from warpmuscle.kernels.program.lanes import (
    LANES,
    doubles_at,
    floats_at,
    max_of_lanes,
    program_memory,
    sum_of_lanes,
    synchronize,
)
from warpmuscle.kernels.program.newton import (
    GIVEN_UP,
    GOES_ON,
    SMALLEST,
    Controls,
    along_of,
    control_of,
    controls_at,
    is_narrow,
    narrowed,
    next_length,
    outcome,
)
from warpmuscle.kernels.program.newton import LEAST_PIVOT as LEAST_HESSIAN
from warpmuscle.kernels.program.reduction import LEAST_PIVOT, place
from warpmuscle.kernels.program.structs import Columns, Programs, ProgramWork

REGISTERS = 96  # of a lane: with more, shared memory would have room for warps that registers have not


@wp.struct
class LaneWork:
    """A programme's working set."""

    hessian: wp.array[wp.float64]  # (n (n + 1)/2)
    reserve: wp.array[wp.float64]
    square: wp.array[wp.float64]  # (n n), in the places of what belongs to controls
    needed: wp.array[wp.float64]
    h: wp.array[wp.float64]
    size: wp.array[wp.float64]
    d: wp.array[wp.float64]
    x: wp.array[wp.float64]
    y: wp.array[wp.float64]  # (m)
    dy: wp.array[wp.float64]  # (m) B^T d; before, controls
    slope: wp.array[wp.float64]  # (m)


def doubles_of(n: int, m: int, entries: int) -> int:
    """Numbers of 8 bytes of a programme's working set."""
    return n * (n + 1) + 5 * n + max(3 * m, n * n) + (entries + 1) // 2


@func
def lane_work_at(memory: wp.array[wp.float64], n: int, m: int) -> LaneWork:
    """Views on the working set in some memory."""
    w = LaneWork()
    half = n * (n + 1) // 2
    w.hessian = doubles_at(memory, 0, half)
    w.reserve = doubles_at(memory, half, half)
    vectors = 2 * half
    w.needed = doubles_at(memory, vectors, n)
    w.h = doubles_at(memory, vectors + n, n)
    w.size = doubles_at(memory, vectors + 2 * n, n)
    w.d = doubles_at(memory, vectors + 3 * n, n)
    w.x = doubles_at(memory, vectors + 4 * n, n)
    rest = vectors + 5 * n
    w.square = doubles_at(memory, rest, n * n)
    w.y = doubles_at(memory, rest, m)
    w.dy = doubles_at(memory, rest + m, m)
    w.slope = doubles_at(memory, rest + 2 * m, m)
    return w


@func
def lane_reserve(
    lane: int, lanes: int, n: int, mass: wp.array[float], weight: wp.array[float], factor: wp.array[wp.float64],
    work: LaneWork,
):  # fmt: skip
    """R = M W^-1 M, and the factor of W."""
    for i in range(lane, n, lanes):
        for j in range(i + 1):
            work.hessian[place(i, j)] = wp.float64(weight[j * n + i])
    synchronize()
    lane_cholesky(lane, lanes, n, LEAST_PIVOT, work.hessian)
    for k in range(lane, n * (n + 1) // 2, lanes):
        factor[k] = work.hessian[k]
    for s in range(lane, n, lanes):
        for i in range(n):
            value = wp.float64(mass[i * n + s])
            at = place(i, 0)
            for q in range(i):
                value -= work.hessian[at + q] * work.square[q * n + s]
            work.square[i * n + s] = value * work.hessian[at + i]
    synchronize()
    for i in range(n):
        for s in range(lane, i + 1, lanes):
            total = wp.float64(0.0)
            for q in range(n):
                total += work.square[q * n + i] * work.square[q * n + s]
            work.reserve[place(i, s)] = total
    synchronize()


@func
def lane_balance(lane: int, lanes: int, n: int, m: int, controls: Controls, columns: Columns, work: LaneWork):
    """y = B^T x by control, the balance h = R x + B u - needed, its slope, and its sizes."""
    for j in range(lane, m, lanes):
        s = along_of(j, columns, controls.entry, work.x)
        answer = control_of(s, j, controls)
        work.y[j] = s
        work.dy[j] = answer[0]
        work.slope[j] = answer[1]
    lane_product(lane, lanes, n, work.reserve, work.x, work.needed, work.h)
    synchronize()
    for group in range(columns.line.shape[0] - 1):
        for c in range(lane, LANES, lanes):
            i = columns.line_target[group * LANES + c]
            if i >= 0:
                s = work.h[i]
                size = wp.abs(work.needed[i])
                for t in range(columns.line[group], columns.line[group + 1]):
                    e = columns.line_entry[t * LANES + c]
                    if e >= 0:
                        force = wp.float64(controls.entry[e]) * work.dy[columns.owner[e]]
                        s += force
                        size += wp.abs(force)
                work.h[i] = s
                work.size[i] = size
    for group in range(columns.pair.shape[0] - 1):
        for c in range(lane, LANES, lanes):
            at = columns.pair_target[group * LANES + c]
            if at >= 0:
                s = work.reserve[at]
                for t in range(columns.pair[group], columns.pair[group + 1]):
                    both = columns.pair_entry[t * LANES + c]
                    if both[0] >= 0:
                        b = wp.float64(controls.entry[both[0]]) * work.slope[columns.owner[both[0]]]
                        s += b * wp.float64(controls.entry[both[1]])
                work.hessian[at] = s
    synchronize()


@func
def lane_step_length(
    lane: int, lanes: int, n: int, m: int, controls: Controls, columns: Columns, work: LaneWork
) -> wp.float64:
    """The step along d to where the slope is zero, by its own rate within a bracket."""
    start = wp.float64(0.0)
    constant = wp.float64(0.0)
    rate = wp.float64(0.0)
    for i in range(lane, n, lanes):
        di = work.d[i]
        xi = work.x[i]
        start += di * work.h[i]
        constant -= di * work.needed[i]
        at = place(i, 0)
        for q in range(i):
            r = work.reserve[at + q]
            constant += r * (di * work.x[q] + work.d[q] * xi)
            rate += wp.float64(2.0) * r * di * work.d[q]
        r = work.reserve[at + i]
        constant += r * di * xi
        rate += r * di * di
    start = sum_of_lanes(start)
    constant = sum_of_lanes(constant)
    rate = sum_of_lanes(rate)
    for j in range(lane, m, lanes):
        work.dy[j] = along_of(j, columns, controls.entry, work.d)
    t = wp.float64(1.0)
    bracket = wp.vec2d(wp.float64(0.0), wp.float64(-1.0))
    for _ in range(SEARCHES):
        value = wp.float64(0.0)
        bend = wp.float64(0.0)
        if lane == 0:
            value = constant + rate * t
            bend = rate
        for j in range(lane, m, lanes):
            rise = work.dy[j]
            answer = control_of(work.y[j] + t * rise, j, controls)
            value += rise * answer[0]
            bend += answer[1] * rise * rise
        value = sum_of_lanes(value)
        bend = sum_of_lanes(bend)
        if wp.abs(value) <= wp.float64(EXACT) * wp.abs(start):
            break
        bracket = narrowed(t, value, bracket)
        t = next_length(t, value, bend, bracket)
        if is_narrow(bracket):
            break
    return t


@cache
def lane_program_of(lanes: int, doubles: int) -> Any:
    """The kernel, with as many lanes a programme, and so many numbers of 8 bytes of memory."""
    memory_of = program_memory(doubles)

    @wp.kernel(
        module="unique", enable_backward=False, cuda_max_registers=REGISTERS,
        module_options={"enable_backward": False, "max_unroll": 1, "block_dim": LANES},
    )  # fmt: skip
    def kernel(
        # in
        chosen: wp.array[int], programs: Programs, columns: Columns,
        # in and out
        work: ProgramWork, multiplier: wp.array2d[wp.float64],
        # out
        control: wp.array2d[float], acceleration: wp.array2d[float], iterations: wp.array[int],
    ):  # fmt: skip
        one, lane = wp.tid()
        p = chosen[one]
        n = programs.bias.shape[1]
        m = columns.first.shape[0] - 1
        memory = memory_of(work.memory[wp.min(p, work.memory.shape[0] - 1)])
        w = lane_work_at(memory, n, m)
        controls = controls_at(p, programs)
        entries = columns.owner.shape[0]
        controls.entry = floats_at(memory, doubles - (entries + 1) // 2, entries)
        for e in range(lane, entries, lanes):
            controls.entry[e] = programs.entry[p, e]
        mass = programs.mass[p]
        wanted = programs.wanted[p]
        for i in range(lane, n, lanes):
            total = wp.float64(programs.bias[p, i])
            for s in range(n):
                total += wp.float64(mass[s * n + i]) * wp.float64(wanted[s])
            w.needed[i] = total
            w.x[i] = multiplier[p, i]
        lane_reserve(lane, lanes, n, mass, programs.weight[p], work.factor[p], w)
        count = wp.int32(0)
        ended = wp.int32(GOES_ON)
        before = wp.float64(wp.inf)
        while ended == GOES_ON:
            lane_balance(lane, lanes, n, m, controls, columns, w)
            error = wp.float64(0.0)
            for i in range(lane, n, lanes):
                error = wp.max(error, wp.abs(w.h[i]) / (w.size[i] + wp.float64(SMALLEST)))
            error = max_of_lanes(error)
            ended = outcome(count, error, before)
            if ended == GOES_ON:
                count += 1
                before = error
                for i in range(lane, n, lanes):
                    w.d[i] = -w.h[i]
                lane_cholesky(lane, lanes, n, LEAST_HESSIAN, w.hessian)
                lane_solve(lane, lanes, n, w.hessian, w.d)
                t = lane_step_length(lane, lanes, n, m, controls, columns, w)
                synchronize()
                for i in range(lane, n, lanes):
                    w.x[i] = w.x[i] + t * w.d[i]
                synchronize()
        for j in range(lane, m, lanes):
            control[p, j] = wp.float32(control_of(w.y[j], j, controls)[0])
        for i in range(lane, n, lanes):
            total = wp.float64(0.0)
            for s in range(n):
                total += wp.float64(mass[s * n + i]) * w.x[s]
            w.d[i] = total
            multiplier[p, i] = w.x[i]
        factor = work.factor[p]
        for k in range(lane, n * (n + 1) // 2, lanes):
            w.hessian[k] = factor[k]
        synchronize()
        lane_solve(lane, lanes, n, w.hessian, w.d)
        for i in range(lane, n, lanes):
            acceleration[p, i] = wp.float32(wp.float64(wanted[i]) - w.d[i])
        if lane == 0:
            iterations[p] = wp.where(ended == GIVEN_UP, -1, count)

    return kernel
