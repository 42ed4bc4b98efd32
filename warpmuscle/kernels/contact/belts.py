"""Ground that moves along itself: the belts of a treadmill, one for each side, or a platform."""

import warp as wp

from warpmuscle.kernels.body_structs import Belts
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, RecordRef, at


@func
def profile_at(time: float, knots: wp.array[wp.vec2]) -> float:
    """A function of time, on straight lines between its knots (time, value), and level before and behind them."""
    last = knots.shape[0] - 1
    if time <= knots[0][0]:
        return knots[0][1]
    for k in range(last):
        after = knots[k + 1]
        if time < after[0]:
            before = knots[k]
            return before[1] + (after[1] - before[1]) * (time - before[0]) / (after[0] - before[0])
    return knots[last][1]


@func
def along_ground(sideways: float, backwards: float, normal: wp.vec3) -> wp.vec3:
    """A velocity along the ground, m/s, to the left and backwards; on level ground along the axes x and -z."""
    across = wp.normalize(wp.vec3(normal[1], -normal[0], 0.0))
    along = wp.cross(across, normal)
    return across * sideways - along * backwards


@func
def share_now(instance: int, step: int, belts: Belts, model: ModelRef) -> float:
    """By what the speeds of belts are multiplied in the middle of a step."""
    knots = model.contacts.belt_profile[wp.min(instance, model.contacts.belt_profile.shape[0] - 1)]
    return profile_at((float(step) + 0.5) * model.time_step - belts.start, knots)


@func
def belt_velocity(instance: int, x: float, step: int, model: ModelRef) -> wp.vec3:
    """Velocity of the belt under a place, world, m/s; the left one's from the line between them on."""
    belts = at(model.contacts.belts, instance, 0)
    share = share_now(instance, step, belts, model)
    backwards = wp.where(x >= belts.split, belts.left, belts.right)
    return along_ground(belts.sideways * share, backwards * share, at(model.contacts.normal, instance, 0))


@func
def record_belts(instance: int, step: int, row: int, frame: int, column: int, model: ModelRef, record: RecordRef):
    """Write the speeds of the left and the right belt in a step, m/s, from a column on."""
    belts = at(model.contacts.belts, instance, 0)
    share = share_now(instance, step, belts, model)
    record.custom[row, frame, column] = belts.left * share
    record.custom[row, frame, column + 1] = belts.right * share


@func
def mean_velocity(instance: int, step: int, model: ModelRef) -> wp.vec3:
    """Mean velocity of both belts, world, m/s: what a walker's speed is relative to."""
    belts = at(model.contacts.belts, instance, 0)
    share = share_now(instance, step, belts, model)
    backwards = 0.5 * (belts.left + belts.right)
    return along_ground(belts.sideways * share, backwards * share, at(model.contacts.normal, instance, 0))
