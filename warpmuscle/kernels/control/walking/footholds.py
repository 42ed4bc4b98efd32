"""Which place near the one that is wanted bears a whole foot, on ground with edges."""

import warp as wp

from warpmuscle.kernels.control.walking.body import ground_height
from warpmuscle.kernels.control.walking.parameters import HEEL, LEG, SOLE, TOE
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef

PLACES = wp.constant(8)  # that are tried ahead of the wanted one, and as many behind it
FARTHEST = wp.constant(0.22)  # L, of these
SAMPLES = wp.constant(6)  # points along a sole
UNEVEN = wp.constant(12.0)  # m for each metre by which the ground below a sole differs: what it may cost to avoid that
TOLERATED = wp.constant(0.01)  # m, of these


@func
def foothold_cost(shift: float, unevenness: float, shrinks: float) -> float:
    """What a place costs, m: how far it is away, and how uneven the ground is there.

    Args:
        shrinks: m, by which the foot sinks below the wanted place.
    """
    return wp.abs(shift) + UNEVEN * wp.max(unevenness - TOLERATED, 0.0) + wp.max(shrinks, 0.0)


@func
def unevenness(instance: int, ankle: wp.vec3, forwards: wp.vec3, model: ModelRef, memory: wp.array[float]) -> float:
    """How far points along a sole are from the straight line between its ends' heights, and that from level, m."""
    low = wp.float32(1.0e30)
    high = wp.float32(-1.0e30)
    for i in range(SAMPLES + 1):
        along = memory[HEEL] + (memory[TOE] - memory[HEEL]) * float(i) / float(SAMPLES)
        point = ankle + forwards * along
        height = ground_height(instance, point[0], point[2], model)
        low = wp.min(low, height)
        high = wp.max(high, height)
    return high - low


@func
def best_shift(instance: int, wanted: wp.vec3, forwards: wp.vec3, model: ModelRef, memory: wp.array[float]) -> float:
    """How far ahead of the wanted place of an ankle the foot does best to come down, m; of equals the nearest."""
    best = wp.float32(0.0)
    least = wp.float32(1.0e30)
    for i in range(2 * PLACES + 1):
        shift = FARTHEST * memory[LEG] * float(i - PLACES) / float(PLACES)
        place = wanted + forwards * shift
        sinks = wanted[1] - memory[SOLE] - ground_height(instance, place[0], place[2], model) - 0.25 * memory[LEG]
        cost = foothold_cost(shift, unevenness(instance, place, forwards, model, memory), sinks)
        if cost < least:
            least = cost
            best = shift
    return best
