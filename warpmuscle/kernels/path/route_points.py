"""Points of routes: when they count, and where they are."""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.body.joint_motion import cubic_rates, piece_of
from warpmuscle.kernels.body.kinematics import coordinate_quat
from warpmuscle.kernels.body.limits import ball_angles
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.main_memory import rotation_of
from warpmuscle.kernels.memory.register_rows import rows_in, rows_of
from warpmuscle.kernels.path.path import offset_between
from warpmuscle.kernels.structs import BALL, ModelRef, RouteSpan, ScratchRef, StateRef, at, nonnegative


@func
def always(instance: int, point: int, model: ModelRef, state: StateRef) -> bool:
    """What `sometimes` says where no point has a condition."""
    return True


@func(inline=False)
def angles_of_ball(rotation: wp.quat, swing: wp.vec3, twist: wp.vec3) -> wp.vec3:
    """`limits.ball_angles`, called and not copied into each place: else the code of paths outgrows a GPU's cache."""
    return ball_angles(rotation, swing, twist)


@func(inline=True)
def sometimes(instance: int, point: int, model: ModelRef, state: StateRef) -> bool:
    """Whether a point of a route counts now."""
    condition = model.routes.point[point].condition
    if condition < 0:
        return True
    paths = model.paths
    joint = paths.condition_joint[condition]
    interval = at(paths.condition_interval, instance, condition)
    start = model.skeleton.plan[joint].coordinate_start
    axis = paths.condition_axis[condition]
    if model.skeleton.plan[joint].joint_type == BALL:
        row = at(model.skeleton.row, instance, joint)
        angle = angles_of_ball(coordinate_quat(state, instance, start), row.axis_a, row.axis_b)[axis]
        return angle >= interval[0] and angle <= interval[1]
    q = state.coordinates[instance, start + axis]
    return q >= interval[0] and q <= interval[1]


@func(inline=True)
def motion_rates(instance: int, motion: int, model: ModelRef, state: StateRef) -> wp.vec3:
    """How far a point has moved along the axis of one of its motions, and the derivatives by the joint's coordinate."""
    plan = model.routes.motion[motion]
    q = state.coordinates[instance, model.skeleton.plan[plan.joint].coordinate_start]
    pieces = model.routes.piece
    held = wp.clamp(q, plan.low, plan.high)
    rates = wp.vec3()
    for turn in range(wp.where(held == q, 1, 2)):  # a loop, so that the search is compiled once
        place = wp.where(turn == 0, held, q)
        piece = at(pieces, instance, piece_of(pieces, instance, plan.first_piece, plan.end_piece, place))
        found = cubic_rates(piece.c, place - piece.start)
        rates = wp.vec3(wp.where(turn == 0, found[0], rates[0]), found[1], found[2])
    return rates


@cache
def slopes_of(count: int) -> Any:
    """The structure of how fast a point moves with its joints' coordinates, with room for so many motions."""

    @wp.struct
    class Slopes:
        of: wp.types.vector(length=count, dtype=float)  # m by a unit of each motion's coordinate

    return Slopes


@cache
def place_of(motions: int) -> Any:
    """The Warp function of the place of a route's point, m, from the origin's joint, world axes.

    Args:
        motions: the most that a point has, of which the function says how fast they are.
    """
    slopes_struct, with_slope = slopes_of(max(motions, 1)), rows_of(max(motions, 1)).with_length

    @wp.func(inline=True)
    def place(
        instance: int, point: int, origin: int, model: ModelRef, state: StateRef, work: ScratchRef,
        slopes: wp.ref[slopes_struct],
    ) -> wp.vec3:  # fmt: skip
        plan = model.routes.point[nonnegative(point)]
        local = at(model.routes.place, instance, point)
        if wp.static(motions > 0):
            for k in range(plan.first_motion, plan.end_motion):
                rates = motion_rates(instance, k, model, state)
                local += at(model.routes.motion_axis, instance, k) * rates[0]
                slopes.of = with_slope(slopes.of, k - plan.first_motion, rates[1])
        return rotation_of(nonnegative(plan.body), work) * local + offset_between(plan.body, origin, work)

    return place


@cache
def placed_of(count: int) -> Any:
    """The structure of a route's points, with room for so many, as they are now: each place is found once a step."""

    @wp.struct
    class Placed:
        place: wp.types.matrix(shape=(count, 3), dtype=float)  # m, from the route's origin, world axes
        counts: int  # a bit a point that counts now
        near: int  # see `RouteKind.near`

    return Placed


class PlacedPoints(NamedTuple):
    """Warp functions on the points of a route."""

    find: Any  # (instance, span, placed, model, state, work): puts in all that count
    counts: Any  # (placed, point of the route) -> bool
    place: Any  # (placed, point of the route) -> vec3
    interval: Any  # (placed, first, last) -> the first and the last point between these that count


@cache
def placed_points_of(count: int, motions: int, conditions: bool, start: int = -1) -> PlacedPoints:
    """The functions for routes of so many points.

    Args:
        motions, conditions: see `RouteKind`. start: of places among numbers that are near; -1: they are not.
    """
    placed_struct, place, slopes_struct = placed_of(count), place_of(motions), slopes_of(max(motions, 1))
    counts_now = sometimes if conditions else always

    rows = rows_in(placed_struct, "place", count, 1, start)
    put, place_at = rows.put, rows.get

    @wp.func(inline=True)
    def counts_at(placed: wp.ref[placed_struct], k: int) -> bool:
        return (placed.counts >> k) & 1 == 1

    @wp.func(inline=True)
    def interval(placed: wp.ref[placed_struct], first: int, last: int) -> wp.vec2i:
        high = int(last)
        while high > first and not counts_at(placed, high):
            high -= 1
        low = int(first)
        while low < high and not counts_at(placed, low):
            low += 1
        return wp.vec2i(low, high)

    @wp.func(inline=True)
    def find(
        instance: int, span: RouteSpan, placed: wp.ref[placed_struct], model: ModelRef, state: StateRef,
        work: ScratchRef,
    ):  # fmt: skip
        slopes = slopes_struct()
        placed.counts = 0
        for k in range(span.end_point - span.first_point):
            if counts_now(instance, span.first_point + k, model, state):
                placed.counts = placed.counts | (1 << k)
                put(placed, k, place(instance, span.first_point + k, span.origin, model, state, work, slopes))

    return PlacedPoints(find, counts_at, place_at, interval)
