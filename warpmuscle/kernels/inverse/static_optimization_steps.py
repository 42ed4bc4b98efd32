"""Parts of a frame's static optimisation: bounds and scales, the balance of a group, the length of a step.

See `static_optimization.py` for the method.
"""

from functools import cache
from typing import Any

import warp as wp

LINEAR, POWER = 0, 1  # how activations follow: clip(gain y + shift), or clip((gain y)^exponent)
SEARCHES = 50  # of the slope's zero along a step at most
EXACT = 5.0e-4  # of the slope at the start of a step, that may be left
BENT = 1.0e-6  # of a multiplier times a strength, below which a root of it is straight


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


@wp.struct
class Group:
    """A group of coordinates with its muscles, in one frame."""

    frame: int
    first: int  # in `Groups.coordinate`
    coordinates: int
    first_muscle: int  # in `Groups.muscle`
    muscles: int


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
def reserve_of(law: int, real: Any) -> Any:
    """The Warp function (u, exponent) -> reserve over its strength and its slope, of u, multiplier times strength.

    Args:
        law: LINEAR, u itself, or POWER, |u|^exponent with the sign of u: costs of reserves have the power of muscles'.
    """
    pair = wp.types.vector(length=2, dtype=real)

    @wp.func
    def linear(u: real, exponent: real) -> pair:
        return pair(u, real(1.0))

    @wp.func
    def power(u: real, exponent: real) -> pair:
        square = u * u + real(BENT) * real(BENT)  # without it the slope is infinite at 0
        part = wp.pow(square, real(0.5) * (exponent - real(1.0)))
        return pair(part * u, part * (real(1.0) + (exponent - real(1.0)) * u * u / square))

    return linear if law == LINEAR else power


@cache
def begin_of(rates: bool, real: Any) -> Any:
    """The Warp function that begins a frame: bounds by muscle, scales by coordinate, and no multipliers.

    Args:
        rates: see `static_optimization_of`. A scale is 1 over what muscles and reserve of a coordinate can make.
    """

    @wp.func
    def begin(
        g: Group, start: int, groups: Groups, frames: Frames, cost: Cost, activation: wp.array2d[float],
        lows: wp.array[real], highs: wp.array[real], scale: wp.array[real], x: wp.array[real],
    ):  # fmt: skip
        f = g.frame
        for i in range(g.coordinates):
            reserve = real(frames.reserve[groups.coordinate[g.first + i]])
            scale[i] = reserve * reserve
            x[i] = real(0.0)
        for j in range(g.muscles):
            muscle = groups.muscle[g.first_muscle + j]
            if wp.static(rates):
                low = real(cost.low[muscle])
                high = real(cost.high[muscle])
                if f > start:
                    before = real(activation[f - 1, muscle])
                    low = before - real(cost.fall[f, muscle]) * (before - low)
                    high = before + real(cost.rise[f, muscle]) * (high - before)
                lows[j] = low
                highs[j] = high
            force = real(frames.active[f, muscle])
            for e in range(groups.first_lever[g.first_muscle + j], groups.first_lever[g.first_muscle + j + 1]):
                b = real(frames.moment_arm[f, groups.lever[e]]) * force
                i = groups.place[e]
                scale[i] = scale[i] + b * b
        for i in range(g.coordinates):
            scale[i] = real(1.0) / wp.sqrt(scale[i])

    return begin


@cache
def answer_of(law: int, rates: bool, real: Any) -> Any:
    """The Warp function of the activation with which a muscle answers y, and its slope by y."""
    answer, pair = activation_of(law, real), wp.types.vector(length=2, dtype=real)

    @wp.func
    def answered(
        y: real, g: Group, j: int, groups: Groups, cost: Cost, lows: wp.array[real], highs: wp.array[real]
    ) -> pair:
        muscle = groups.muscle[g.first_muscle + j]
        costs = wp.min(g.frame, cost.gain.shape[0] - 1)
        least = real(cost.low[muscle])
        most = real(cost.high[muscle])
        if wp.static(rates):
            least = lows[j]
            most = highs[j]
        return answer(
            y, real(cost.gain[costs, muscle]), real(cost.shift[costs, muscle]), real(cost.exponent), least, most
        )

    return answered


@cache
def balance_of(law: int, rates: bool, real: Any) -> Any:
    """The Warp function that puts in activations, y = B^T m by muscle, the balance h, and its slope H by m.

    At the start (`step` 0) muscles count as free of their bounds, at which most of them are: without them H would have
    the reserves alone, and a step many times too long.
    """
    answered, reserved = answer_of(law, rates, real), reserve_of(law, real)

    @wp.func
    def balance(
        step: int, g: Group, groups: Groups, frames: Frames, cost: Cost, lows: wp.array[real], highs: wp.array[real],
        x: wp.array[real], activation: wp.array2d[float], y: wp.array[real], h: wp.array[real],
        hessian: wp.array2d[real],
    ):  # fmt: skip
        f = g.frame
        for i in range(g.coordinates):
            speed = groups.coordinate[g.first + i]
            reserve = real(frames.reserve[speed])
            if wp.static(law == LINEAR):
                h[i] = reserve * reserve * x[i] - real(frames.needed[f, speed])
                hessian[i, i] = reserve * reserve
            else:
                r = reserved(reserve * x[i], real(cost.exponent))
                h[i] = reserve * r[0] - real(frames.needed[f, speed])
                hessian[i, i] = reserve * reserve * wp.where(step == 0, real(1.0), r[1])
            for q in range(i):
                hessian[i, q] = real(0.0)
        for j in range(g.muscles):
            muscle = groups.muscle[g.first_muscle + j]
            force = real(frames.active[f, muscle])
            begin = groups.first_lever[g.first_muscle + j]
            end = groups.first_lever[g.first_muscle + j + 1]
            s = real(0.0)
            for e in range(begin, end):
                s += real(frames.moment_arm[f, groups.lever[e]]) * x[groups.place[e]]
            y[j] = s * force
            a = answered(y[j], g, j, groups, cost, lows, highs)
            activation[f, muscle] = wp.float32(a[0])
            pull = a[0] * force
            for e in range(begin, end):
                i = groups.place[e]
                h[i] = h[i] + real(frames.moment_arm[f, groups.lever[e]]) * pull
            slope = a[1]
            if step == 0:
                slope = real(cost.gain[wp.min(f, cost.gain.shape[0] - 1), muscle])
            if slope > real(0.0):
                slope *= force * force
                for e in range(begin, end):
                    i = groups.place[e]
                    part = real(frames.moment_arm[f, groups.lever[e]]) * slope
                    for k in range(begin, e + 1):  # places of a muscle increase
                        q = groups.place[k]
                        hessian[i, q] = hessian[i, q] + part * real(frames.moment_arm[f, groups.lever[k]])

    return balance


@cache
def step_length_of(law: int, rates: bool, real: Any) -> Any:
    """The Warp function of the step along d to where the slope of the convex function is zero.

    The slope rises with the step: the zero is found by its own rate, within a bracket.
    """
    answered, reserved = answer_of(law, rates, real), reserve_of(law, real)

    @wp.func
    def step_length(
        g: Group, groups: Groups, frames: Frames, cost: Cost, lows: wp.array[real], highs: wp.array[real],
        x: wp.array[real], h: wp.array[real], d: wp.array[real], y: wp.array[real], dy: wp.array[real],
    ) -> real:  # fmt: skip
        start = real(0.0)
        constant = real(0.0)
        rate = real(0.0)
        for i in range(g.coordinates):
            speed = groups.coordinate[g.first + i]
            reserve = real(frames.reserve[speed])
            start += d[i] * h[i]
            if wp.static(law == LINEAR):
                constant += d[i] * (reserve * reserve * x[i] - real(frames.needed[g.frame, speed]))
                rate += d[i] * reserve * reserve * d[i]
            else:
                constant -= d[i] * real(frames.needed[g.frame, speed])
        for j in range(g.muscles):
            s = real(0.0)
            for e in range(groups.first_lever[g.first_muscle + j], groups.first_lever[g.first_muscle + j + 1]):
                s += real(frames.moment_arm[g.frame, groups.lever[e]]) * d[groups.place[e]]
            dy[j] = s * real(frames.active[g.frame, groups.muscle[g.first_muscle + j]])
        t = real(1.0)
        below = real(0.0)
        above = real(-1.0)
        for _ in range(SEARCHES):
            value = constant + rate * t
            bend = rate
            if wp.static(law != LINEAR):
                for i in range(g.coordinates):
                    reserve = real(frames.reserve[groups.coordinate[g.first + i]])
                    r = reserved(reserve * (x[i] + t * d[i]), real(cost.exponent))
                    value += d[i] * reserve * r[0]
                    bend += d[i] * d[i] * reserve * reserve * r[1]
            for j in range(g.muscles):
                a = answered(y[j] + t * dy[j], g, j, groups, cost, lows, highs)
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
        return t

    return step_length
