"""Which place near the one that is wanted bears a whole foot, on ground with edges."""

import warp as wp

from warpmuscle.kernels.control.walking.body import ground_height
from warpmuscle.kernels.control.walking.parameters import FOOTHOLD, HEEL, LEG, PHASE, TOE
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef

PLACES = wp.constant(10)  # that are tried ahead of the wanted one, and as many behind it
FARTHEST = wp.constant(0.35)  # L, of these
SAMPLES = wp.constant(6)  # points along a sole
UNEVEN = wp.constant(
    12.0
)  # m for each metre by which the ground is from straight below a sole: what it may cost to avoid that
NARROW, WIDE = wp.constant(0.015), wp.constant(0.06)  # m, before and behind a sole, by which feet may miss their places
UNEASY = wp.constant(3.0)  # the same as UNEVEN, of the wider one
BACKWARDS = wp.constant(3.0)
HIGHEST = wp.constant(0.22)  # L, of what is climbed or descended in one step
STEADY = wp.constant(0.7)  # m for each metre by which a plan is changed at the end of a step
STEEPEST = wp.constant(0.35)  # of ground that a sole may lie along
TOLERATED = wp.constant(0.01)  # m, of these


@func
def foothold_cost(shift: float, uneven: float, uneasy: float, moved: float, phase: float) -> float:
    """What a place costs, m: how far it is away, how uneven the ground is there, and that plans are changed late.

    What is behind the wanted place costs twice as much, for there a body falls on faster.

    Args:
        shift: m, how far the place is ahead of the wanted one. moved: m, and of what was planned a moment ago.
    """
    away = wp.where(shift < 0.0, -BACKWARDS * shift, shift)
    away += UNEVEN * wp.max(uneven - TOLERATED, 0.0) + UNEASY * wp.max(uneasy - TOLERATED, 0.0)
    return away + STEADY * phase * wp.abs(moved)


@func
def unevenness(
    instance: int, ankle: wp.vec3, forwards: wp.vec3, margin: float, model: ModelRef, memory: wp.array[float]
) -> float:
    """How far points of the ground along a sole are from a straight line with at most a slope's incline, m."""
    heel = ankle + forwards * (memory[HEEL] - margin)
    toe = ankle + forwards * (memory[TOE] + margin)
    long = memory[TOE] - memory[HEEL] + 2.0 * margin
    low = ground_height(instance, heel[0], heel[2], model)
    rise = wp.clamp(ground_height(instance, toe[0], toe[2], model) - low, -STEEPEST * long, STEEPEST * long)
    most = wp.float32(0.0)
    for i in range(SAMPLES + 1):
        share = float(i) / float(SAMPLES)
        point = heel + forwards * (long * share)
        height = ground_height(instance, point[0], point[2], model)
        most = wp.max(most, wp.abs(height - low - rise * share))
    return most


@func
def best_shift(
    instance: int, wanted: wp.vec3, forwards: wp.vec3, level: float, climb: float, model: ModelRef,
    memory: wp.array[float],
) -> wp.vec2:  # fmt: skip
    """How far ahead of the wanted place of an ankle the foot does best to come down, m; of equals the nearest.

    Then how far ahead that is of where it is wanted at such a height: a body that has to rise comes to rest sooner.

    Args:
        level: m, height of the ground below the other foot. climb: by how much less far for each metre above that.
    """
    best = wp.vec2(0.0, 0.0)
    least = wp.float32(1.0e30)
    before = wp.vec3(memory[FOOTHOLD], memory[FOOTHOLD + 1], memory[FOOTHOLD + 2])
    for i in range(2 * PLACES + 1):
        shift = FARTHEST * memory[LEG] * float(i - PLACES) / float(PLACES)
        place = wanted + forwards * shift
        moved = wp.dot(place - before, forwards)
        uneven = unevenness(instance, place, forwards, NARROW, model, memory)
        uneasy = unevenness(instance, place, forwards, WIDE, model, memory)
        rise = ground_height(instance, place[0], place[2], model) - level
        off = shift + climb * rise
        uneven += wp.max(wp.abs(rise) - HIGHEST * memory[LEG], 0.0)
        cost = foothold_cost(off, uneven, uneasy, moved, memory[PHASE])
        if cost < least:
            least = cost
            best = wp.vec2(shift, off)
    return best
