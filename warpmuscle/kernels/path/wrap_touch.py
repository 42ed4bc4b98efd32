"""How a segment of a path goes round a surface; all surfaces answer alike."""

import warp as wp

from warpmuscle.kernels.functions import func

FREE, INSIDE, BESIDE, THROUGH = 0, 1, 2, 3


@wp.struct
class Touch:
    """How a straight segment from a to b meets a surface, in the surface's axes.

    FREE: it does not touch it; INSIDE: one of its ends is inside, and so it stays straight; BESIDE: the surface takes
    it to its own side; THROUGH: straight, it would run through the surface. The places count for the last two only.
    """

    kind: int
    first: wp.vec3  # m, where the path reaches the surface
    second: wp.vec3  # m, and where it leaves it
    arc: float  # m, on the surface between them


GIVES = 4.0  # how much faster a smooth surface shrinks than an end of a segment goes into it


@func
def kept_size(near: float) -> float:
    """Share of its size that a smooth surface keeps, 0..1, with the end of a segment at so much of it from its middle.

    All of it if the end is outside. One inside by 1/GIVES of the size runs free, as all that are inside do in OpenSim.
    """
    return wp.clamp(1.0 - GIVES * (1.0 - near), 0.0, 1.0)


@func
def on_side(x: float, side: int) -> bool:
    """Whether a coordinate is on the side 1 or -1; 0 is on the side 1."""
    return (x >= 0.0) == (side > 0)


@func
def allowed(a: float, b: float, near: float, side: int, through: bool) -> int:
    """What a segment does at a surface with a side, from coordinates across it of its ends and its nearest point.

    As OpenSim has it: through the surface it must go round, if one of its ends is on the side; else only if it
    changes sides and is on the wrong one where it is nearest, or if both ends are on the wrong one.
    """
    a_on = on_side(a, side)
    b_on = on_side(b, side)
    if not a_on and not b_on:
        return BESIDE
    if through:
        return THROUGH
    if a_on != b_on and not on_side(near, side):
        return BESIDE
    return FREE


@func
def larger(p: float, q: float, r: float, s: float) -> int:
    """Which of four numbers is the largest."""
    if p > q and p > r and p > s:
        return 0
    if q > r and q > s:
        return 1
    return wp.where(r > s, 2, 3)
