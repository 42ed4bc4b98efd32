"""Bodies that run into each other: every shape is a capsule, a segment swept by a sphere."""

from typing import Any

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import any_lane, synchronize
from warpmuscle.kernels.structs import COLLIDED, RUNNING, Collisions, ModelRef, ScratchRef, at


@func
def fraction_along(product: float, length_sq: float) -> float:
    """Where a point projects onto a segment, 0 at its start and 1 at its end; 0 on a segment without a length.

    Args:
        product: of the segment and the vector from its start to the point. length_sq: of the segment.
    """
    if length_sq > 0.0:
        return wp.clamp(product / length_sq, 0.0, 1.0)
    return 0.0


@func
def fractions_along(middle: wp.vec3, half_a: wp.vec3, half_b: wp.vec3) -> wp.vec2:
    """Where two segments are nearest to each other, 0 to 1 along each (Ericson 2005, section 5.1.9).

    Its denominator |a|^2 |b|^2 - (a.b)^2 is computed as |a x b|^2, which loses fewer digits when a and b are almost
    parallel; where it is lost nevertheless, any first guess on a leads to the nearest points.

    Args:
        middle: from the middle of segment a to that of segment b. half_a, half_b: from middle to end.
    """
    a = 2.0 * half_a
    b = 2.0 * half_b
    r = half_b - half_a - middle  # from the start of b to the start of a
    normal = wp.cross(a, b)
    on_a = fraction_along(wp.dot(wp.cross(b, r), normal), wp.length_sq(normal))
    on_b = fraction_along(wp.dot(b, r + a * on_a), wp.length_sq(b))
    on_a = fraction_along(wp.dot(a, b * on_b - r), wp.length_sq(a))
    return wp.vec2(on_a, on_b)


@func
def segment_distance_sq(middle: wp.vec3, half_a: wp.vec3, half_b: wp.vec3) -> float:
    """Squared distance of two segments, parallel ones and points included, m^2.

    Args:
        middle: from the middle of segment a to that of segment b. half_a, half_b: from middle to end.
    """
    nearest = fractions_along(middle, half_a, half_b)
    r = half_b - half_a - middle
    return wp.length_sq(r + 2.0 * half_a * nearest[0] - 2.0 * half_b * nearest[1])


@func
def place_shapes(instance: int, lane: int, lanes: int, collisions: Collisions, work: ScratchRef):
    """Put shapes where their bodies are, in places of memory that the controller has not written yet. No barrier."""
    for shape in range(lane, collisions.body.shape[0], lanes):
        body = collisions.body[shape]
        rotation = work.rotation[body]
        work.shape_middle[shape] = work.position[body] + rotation * at(collisions.middle, instance, shape)
        work.shape_half[shape] = rotation * at(collisions.half, instance, shape)


@func
def is_near(instance: int, pair: int, collisions: Collisions, work: ScratchRef) -> bool:
    """Whether two shapes of a pair are nearer to each other than their distance."""
    a = collisions.pair[pair, 0]
    b = collisions.pair[pair, 1]
    middle = work.shape_middle[b] - work.shape_middle[a]
    nearest = at(collisions.nearest_sq, instance, pair)
    if wp.length_sq(middle) < nearest[0]:
        return segment_distance_sq(middle, work.shape_half[a], work.shape_half[b]) < nearest[1]
    return False


@func
def look_for_near_pairs(instance: int, lane: int, lanes: int, collisions: Collisions, work: ScratchRef):
    """Flag 0 becomes 1 if two shapes of a pair are nearer to each other than their distance, else 0.

    The places of the shapes share their memory with what the controller has not written yet. Ends with a barrier.
    """
    if lane == 0:
        work.flags[0] = 0
    place_shapes(instance, lane, lanes, collisions, work)
    synchronize()
    for pair in range(lane, collisions.pair.shape[0], lanes):
        if is_near(instance, pair, collisions, work):
            work.flags[0] = 1
    synchronize()


@func
def collision_stage(instance: int, lane: int, lanes: int, step: int, model: ModelRef, work: ScratchRef) -> int:
    """COLLIDED, on all lanes, if two shapes of a pair are nearer to each other than they may be, else RUNNING.

    Tested every few steps, as bodies do not move far in between. Instances that share a warp may be at different steps,
    so that all pass the barriers where one of them tests. Ends with a barrier then.
    """
    tests = step % model.collisions.every == 0
    if not any_lane(tests):
        return RUNNING
    look_for_near_pairs(instance, lane, lanes, model.collisions, work)
    return wp.where(tests and work.flags[0] == 1, COLLIDED, RUNNING)


@func
def no_collisions(instance: int, lane: int, lanes: int, step: int, model: ModelRef, work: ScratchRef) -> int:
    """Bodies may run into each other."""
    return RUNNING


def collision_stage_of(tested: bool) -> Any:
    """The stage that a step has compiled in."""
    return collision_stage if tested else no_collisions
