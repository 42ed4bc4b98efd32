"""Where a foot is put: a pendulum comes to rest upright over it, and what it takes to go on (Coros 2010, Hof 2008)."""

import warp as wp

from warpmuscle.kernels.functions import func

LEAST_HASTE, MOST_HASTE = wp.constant(0.8), wp.constant(1.8)  # by which a step may go on faster than planned
SLOWEST = wp.constant(0.4)  # m/s


@func
def resting_distance(speed: float, height: float, gravity: float) -> float:
    """How far ahead a foot brings a pendulum to rest upright over it, m: v sqrt(h/g + v^2/(4 g^2)).

    By energy: v^2/2 + g h = g sqrt(h^2 + d^2).
    """
    return speed * wp.sqrt(height / gravity + speed * speed / (4.0 * gravity * gravity))


@func
def falling_rate(height: float, gravity: float) -> float:
    """Of a linear pendulum, sqrt(g/h), 1/s."""
    return wp.sqrt(gravity / height)


@func
def falls_to(place: float, speed: float, rate: float, time: float) -> wp.vec2:
    """Place from the foot and speed of a linear pendulum after a time: x cosh + v/w sinh, and its derivative."""
    e = wp.exp(rate * time)
    cosh = 0.5 * (e + 1.0 / e)
    sinh = 0.5 * (e - 1.0 / e)
    return wp.vec2(place * cosh + speed / rate * sinh, place * rate * sinh + speed * cosh)


@func
def steady_retreat(speed: float, rate: float, step_time: float) -> float:
    """How far behind the place of rest a foot keeps up a speed, m: V T / (exp(w T) - 1) (Hof 2008, eq. 8)."""
    return speed * step_time / (wp.exp(rate * step_time) - 1.0)


@func
def steady_margin(width: float, rate: float, step_time: float) -> float:
    """How far to the side of it a foot keeps up a step width, m: w / (exp(w T) + 1) (Hof 2008)."""
    return width / (wp.exp(rate * step_time) + 1.0)


@func
def towards(now: float, wanted: float, most: float) -> float:
    """A number that comes to another one by at most so much."""
    return now + wp.clamp(wanted - now, -most, most)


@func
def haste(shift: float, moves: float, remaining: float) -> float:
    """By how much faster a step goes on, so that the pendulum needs its foot where the ground bears it.

    A foot that comes down so much later has to be further ahead by `moves` times that.

    Args:
        shift: m, how far the foothold is ahead of where the pendulum needs it. moves: m/s. remaining: s, of the step.
    """
    later = shift / wp.max(moves, SLOWEST)
    return wp.clamp(remaining / wp.max(remaining + later, 1.0e-3), LEAST_HASTE, MOST_HASTE)
