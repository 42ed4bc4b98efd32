"""How much faster an OpenSim route round several surfaces grows than its moment arms say: its slip.

Its speed is that of the places of its last round along the segments between those of the first, see `route_walk.py`.
Other than for forces, segments within one body count, too, and those along surfaces.
"""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.path.path import joint_velocity
from warpmuscle.kernels.structs import ModelRef, RouteSpan, ScratchRef, nonnegative

SHORTEST = 1.0e-9  # m, of a segment that has a direction


@func
def turning(body: int, work: ScratchRef) -> wp.vec3:
    """Angular velocity of a body, rad/s, world, without what it gained in the last half step."""
    return work.angular_velocity[nonnegative(body)] - work.lag_angular[nonnegative(body)]


@func
def slip(
    span: RouteSpan, before: int, stop: int, body_before: int, body: int, along: wp.vec3, moved: wp.vec3,
    model: ModelRef, work: ScratchRef,
) -> float:  # fmt: skip
    """The slip of a segment from the stop before to the next one, m/s.

    Args:
        along, moved: m, world, the ways between its ends in the first and in the last round.
    """
    one = int(body_before)
    other = int(body)
    while one != other:
        if one > other:
            one = model.skeleton.plan[nonnegative(one)].parent
        else:
            other = model.skeleton.plan[nonnegative(other)].parent
    rate = turning(one, work)
    if body != body_before:
        for k in range(span.first_lever, span.end_lever):
            lever = model.routes.lever[nonnegative(k)]
            if ((lever.beyond >> stop) & 1) + ((lever.beyond >> before) & 1) == 2:
                rate -= joint_velocity(nonnegative(lever.joint), model, work)
    return wp.dot(rate, wp.cross(moved, along)) / wp.max(wp.length(along), SHORTEST)
