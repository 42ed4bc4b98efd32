"""Segments of a path through a torus about z, as OpenSim 4.6 takes them (WrapTorus).

Where the segment is nearest to the circle in the middle of the ring, a cylinder along the circle stands for the ring,
and the path stays on the side of it that looks to the ring's centre. OpenSim looks for the nearest place from both
ends; the equation that it solves has twice the distance from the axis in it, and so have we.
"""

from __future__ import annotations

import math

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene.wrapping.cylinder import cylinder_touch
from warpmuscle.scene.wrapping.touch import BESIDE, Touch, sign, untouched

ENDLESS = 1.0e4  # m
STEPS = 100  # of the search for the nearest place, more than it needs
FIRST_REACH = 0.2
TOLERANCE = WORTHLESS = 1.0e-4
AHEAD = 1.0e-5  # m, over which OpenSim's search takes differences
DAMPINGS = 10  # that are tried for a step


def torus_touch(
    a: Floats, b: Floats, section: float, ring: float, axis: int, side: int, where: int, as_opensim: bool = False
) -> Touch:
    """How a segment from a to b, (3,) m, goes through a torus.

    Args:
        section, ring: radii of the section and of the circle in the middle, m.
        axis, side: the half of the circle that a path must be near: the axis, and 1 or -1; 0: both halves.
        where, as_opensim: see `cylinder_touch`.
    """
    near = [place_from(a, b, ring), place_from(b, a, ring)]
    if side != 0:
        near = [place for place in near if sign(place[axis]) == side]
    if not near:
        return untouched()
    place = min(near, key=lambda p: _distance(p, ring))
    flat = math.hypot(place[0], place[1])
    if flat == 0.0:
        return untouched()
    center = np.array([place[0], place[1], 0.0]) * (ring / flat)
    x, y = -center / ring, np.array([0.0, 0.0, -1.0])
    turn = np.array([x, y, np.cross(x, y)])
    touch = cylinder_touch(
        turn @ (a - center), turn @ (b - center), section, ENDLESS, 0, 1, where, as_opensim=as_opensim
    )
    if touch.kind < BESIDE:
        return touch
    return Touch(BESIDE, center + turn.T @ touch.first, center + turn.T @ touch.second, touch.length)


def place_from(a: Floats, b: Floats, ring: float) -> Floats:
    """The place on the line from a to b that OpenSim's search for the one nearest to the circle finds, from a on.

    Levenberg's and Marquardt's method for one unknown with steps within a reach (MINPACK's lmdif; More 1978), with
    slopes over AHEAD.
    """
    n = (b - a) / max(float(np.linalg.norm(b - a)), 1e-12)
    along, flat, square, rest = float(a @ n), float(a[:2] @ n[:2]), float(n[:2] @ n[:2]), float(a[:2] @ a[:2])

    def excess(u: float) -> float:
        away = math.sqrt(max(u * u * square + 2.0 * flat * u + rest, 1e-24))
        return 2.0 * (along + u - 2.0 * ring * (square * u + flat) / away)

    u, f, scale, reach, damping, moved = 0.0, excess(0.0), 0.0, FIRST_REACH, 0.0, False
    slope = (excess(AHEAD) - f) / AHEAD
    for _ in range(STEPS):
        if f == 0.0 or slope == 0.0:
            break
        scale = max(scale, abs(slope))
        step, damping = damped_step(abs(f), abs(slope), scale, reach, damping)
        size, step = scale * step, -math.copysign(step, f * slope)
        reach = reach if moved else min(reach, size)
        after = excess(u + step)
        left = abs(after / f)
        gain = 1.0 - left**2 if left < 10.0 else -1.0
        straight, held = (slope * step / f) ** 2, damping * (size / f) ** 2
        expected = straight + 2.0 * held
        if gain <= 0.25 * expected:
            share = 0.5 if gain >= 0.0 else 0.5 * (straight + held) / (straight + held - 0.5 * gain)
            share = 0.1 if left >= 10.0 or share < 0.1 else share
            reach, damping = share * min(reach, 10.0 * size), damping / share
        elif damping == 0.0 or gain >= 0.75 * expected:
            reach, damping = 2.0 * size, 0.5 * damping
        if gain >= WORTHLESS * expected:
            moved, u, f = True, u + step, after
            slope = (excess(u + AHEAD) - f) / AHEAD
        if abs(gain) <= TOLERANCE and expected <= TOLERANCE and gain <= 2.0 * expected:
            break
        if reach <= TOLERANCE * scale * abs(u):
            break
    return np.asarray(a + u * n)


def damped_step(f: float, slope: float, scale: float, reach: float, damping: float) -> tuple[float, float]:
    """A step's length and the damping with which, times the scale, it is within a tenth of the reach (lmpar).

    Args:
        f, slope: of the function, absolute values. damping: of the step before, with which the search begins.
    """
    step = f / slope
    size = scale * step
    if size <= 1.1 * reach:
        return step, 0.0
    least = (size / reach - 1.0) * (slope / scale) ** 2
    gradient = slope * f / scale
    damping = min(max(damping, least), gradient / reach)
    for _ in range(DAMPINGS):
        square = slope**2 + damping * scale**2
        step = slope * f / square
        over = scale * step / reach - 1.0
        if abs(over) <= 0.1:
            break
        least = max(least, damping) if over > 0.0 else least
        damping = max(least, damping + over * square / scale**2)
    return step, damping


def _distance(place: Floats, ring: float) -> float:
    """Distance of a place from the circle, m."""
    return math.hypot(math.hypot(place[0], place[1]) - ring, place[2])
