"""What a body earns that gets up from a seat: height over its feet, and that it then stands still."""

import warp as wp

from warpmuscle.kernels.learning.decision import Decision
from warpmuscle.kernels.objective.declaration import Declaration
from warpmuscle.kernels.structs import Model, Scratch, State


@wp.struct
class Standing:
    height: float  # m, of the centre of mass of a body that stands
    width: float  # m
    ahead: float  # m, how far in front of the middle of the seat it is to stand
    near: float  # m
    still: float  # m/s


@wp.func
def _stands(instance: int, model: Model, state: State, work: Scratch, decision: Decision, own: Standing) -> float:
    """1 at full height, over the feet as they were, and at rest; a third of that is for height and place alone."""
    low = wp.max(own.height - work.center[0][1], 0.0) / own.width
    off = (work.center[0][2] - own.ahead) / own.near
    speed = wp.length(work.center[1]) / own.still
    return wp.exp(-low * low - off * off) * (1.0 + 2.0 * wp.exp(-speed * speed)) / 3.0


stands = Declaration(
    function=_stands,
    parameters=Standing,
    stage="decision",
    sign="earned",
    unit="1/s",
    defaults={"height": 1.0, "width": 0.2, "ahead": 0.37, "near": 0.3, "still": 0.3},
)
