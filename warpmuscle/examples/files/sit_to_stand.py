"""What a body earns that gets up from a seat: that it stands over its feet, and then stands still."""

import warp as wp

from warpmuscle.kernels.learning.decision import Decision
from warpmuscle.kernels.objective.accelerations import centre_of_mass
from warpmuscle.kernels.objective.declaration import Declaration
from warpmuscle.kernels.structs import Model, Scratch, State

TORSO = wp.constant(1)  # the root, the pelvis, is 0, and bodies follow their parents
LEFT_UPPER_ARM = wp.constant(5)
RIGHT_UPPER_ARM = wp.constant(6)
LEFT_FOREARM = wp.constant(9)
RIGHT_FOREARM = wp.constant(10)


@wp.struct
class Standing:
    height: float  # m, of the pelvis of a body that stands
    width: float  # m
    near: float  # m, of the centre of mass from the middle of the feet, along the ground
    still: float  # m/s


@wp.func
def _stands(instance: int, model: Model, state: State, work: Scratch, decision: Decision, own: Standing) -> float:
    """1 at full height over the feet, the trunk upright, at rest; a fifth for being over the feet alone."""
    left = centre_of_mass(instance, model.feet.left, model, work)
    right = centre_of_mass(instance, model.feet.right, model, work)
    off = work.center[0] - 0.5 * (left + right)
    over = wp.exp(-(off[0] * off[0] + off[2] * off[2]) / (own.near * own.near))
    low = wp.max(own.height - work.position[0][1], 0.0) / own.width
    upright = wp.max((work.rotation[TORSO] * wp.vec3(0.0, 1.0, 0.0))[1], 0.0)
    speed = wp.length(work.center[1]) / own.still
    return over * (0.2 + 0.4 * wp.exp(-low * low) * upright * (1.0 + wp.exp(-speed * speed)))


@wp.func
def raised(instance: int, upper: int, lower: int, model: Model, work: Scratch) -> float:
    """How far a forearm is above where it hangs, over 0.1 m, at most 4."""
    above = centre_of_mass(instance, lower, model, work)[1] - centre_of_mass(instance, upper, model, work)[1]
    return wp.clamp(above * 10.0 + 2.0, 0.0, 4.0)


@wp.func
def _arms(instance: int, model: Model, state: State, work: Scratch, decision: Decision) -> float:
    """What arms cost that do not hang."""
    left = raised(instance, LEFT_UPPER_ARM, LEFT_FOREARM, model, work)
    right = raised(instance, RIGHT_UPPER_ARM, RIGHT_FOREARM, model, work)
    return left * left + right * right


@wp.struct
class Place:
    seat: float  # m, how far forwards the seat reaches; feet stay in front of it
    step: float  # m, how far in front of it they may go
    lift: float  # m, how high their middles may come
    back: float  # m, how far behind the middle of the seat the centre of mass may be


@wp.func
def _leaves(instance: int, model: Model, state: State, work: Scratch, own: Place) -> bool:
    """Whether a foot leaves its place in front of the seat, as in a leap, or the body leans back."""
    left = centre_of_mass(instance, model.feet.left, model, work)
    right = centre_of_mass(instance, model.feet.right, model, work)
    nearest = wp.min(left[2], right[2]) - own.seat
    farthest = wp.max(left[2], right[2]) - own.seat
    return nearest < 0.0 or farthest > own.step or wp.max(left[1], right[1]) > own.lift or work.center[0][2] < -own.back


stands = Declaration(
    function=_stands,
    parameters=Standing,
    stage="decision",
    sign="earned",
    unit="1/s",
    defaults={"height": 1.0, "width": 0.25, "near": 0.25, "still": 0.3},
)
arms = Declaration(function=_arms, stage="decision", sign="cost", unit="1/s")
leaves = Declaration(function=_leaves, parameters=Place, defaults={"seat": 0.2, "step": 0.4, "lift": 0.2, "back": 0.15})
