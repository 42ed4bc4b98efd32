"""A torque that follows the gait cycle of a leg, as an exoskeleton's motor gives it."""

import warp as wp

from warpmuscle.kernels.contact.gait_cycle import foot_part
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import LEFT, RIGHT, ModelRef, ScratchRef, StateRef

KNOTS = 10  # in a gait cycle


@wp.struct
class CycleTorque:
    """Torques at tenths of a gait cycle, from when the foot touches down."""

    torque_0: float  # N m, towards greater angles
    torque_1: float
    torque_2: float
    torque_3: float
    torque_4: float
    torque_5: float
    torque_6: float
    torque_7: float
    torque_8: float
    torque_9: float


@func
def knot_torque(torque: CycleTorque, knot: int) -> float:
    """The torque at a knot, N m."""
    low = wp.where(
        knot < 2,
        wp.where(knot == 0, torque.torque_0, torque.torque_1),
        wp.where(knot == 2, torque.torque_2, wp.where(knot == 3, torque.torque_3, torque.torque_4)),
    )
    high = wp.where(
        knot < 7,
        wp.where(knot == 5, torque.torque_5, torque.torque_6),
        wp.where(knot == 7, torque.torque_7, wp.where(knot == 8, torque.torque_8, torque.torque_9)),
    )
    return wp.where(knot < 5, low, high)


@func
def torque_at(part: float, torque: CycleTorque) -> float:
    """The torque at a part of the cycle, 0 to 1, N m: straight from knot to knot, and from the last to the first."""
    place = wp.clamp(part, 0.0, 1.0) * float(wp.static(KNOTS))
    knot = wp.min(int(place), wp.static(KNOTS - 1))
    after = wp.where(knot == wp.static(KNOTS - 1), 0, knot + 1)
    between = place - float(knot)
    return knot_torque(torque, knot) * (1.0 - between) + knot_torque(torque, after) * between


@func
def side_of(body: int, model: ModelRef) -> int:
    """The leg that a body belongs to: that whose foot is the body, or hangs on it."""
    carrier = model.feet.left
    while carrier > body:  # bodies are numbered from the root
        carrier = model.skeleton.plan[carrier].parent
    return wp.where(carrier == body, LEFT, RIGHT)


@func
def cycle_torque(
    instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, torque: CycleTorque
) -> wp.vec3:
    """Effort along the first coordinate of a joint of a leg, by the part of its gait cycle that its foot is in."""
    return wp.vec3(torque_at(foot_part(instance, side_of(body, model), state), torque), 0.0, 0.0)
