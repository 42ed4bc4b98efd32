"""The way of a foot that swings, over the phase of its step (Coros 2010, 4.1)."""

import warp as wp

from warpmuscle.kernels.functions import func

ARRIVES = wp.constant(0.85)  # phase at which the foot is above its place
LOWERED = wp.constant(1.0)  # phase at which it is down
PUSHES, PUSHED = wp.constant(0.35), wp.constant(0.8)  # phases between which the leg that stands comes to push off
LOWERS = wp.constant(0.3)  # phase from which the leg that stands lets the other one down to where it is to be
STAIR = wp.constant(0.15)  # L, of what is as high as a stair
BELOW = wp.constant(0.5)  # L, how far below the ground a foot that finds none is sent in a step's time


@func
def progress(phase: float, start: float, end: float) -> float:
    """Share of a way, 0 to 1, between two phases: 3 s^2 - 2 s^3, at rest at both ends."""
    s = wp.clamp((phase - start) / (end - start), 0.0, 1.0)
    return s * s * (3.0 - 2.0 * s)


@func
def lift(phase: float) -> float:
    """Height of a foot over its way, 0 to 1: (4 s (1 - s))^2, s the share of the time till it is down."""
    s = wp.clamp(phase / LOWERED, 0.0, 1.0)
    p = 4.0 * s * (1.0 - s)
    return p * p


@func
def way_height(phase: float, start: float, end: float) -> float:
    """Height of the way between two places, m: what rises does so early, what falls late."""
    if end > start:
        return start + (end - start) * progress(phase, 0.0, 0.5)
    return start + (end - start) * progress(phase, 0.5, 1.0)


@func
def as_a_stair(level: float, stair: float, height: float) -> float:
    """A number that is one on level ground, another one for a stair, and between them for what is less high.

    Args:
        height: in lengths of a leg.
    """
    return level + (stair - level) * wp.clamp(height / STAIR, 0.0, 1.0)
