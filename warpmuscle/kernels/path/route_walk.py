"""A walk along a route, from stop to stop: its length, and its moment arms, see `route_pulls.py`.

OpenSim's path round several surfaces has two places where it reaches or leaves each: segments run between those of the
first round, and pull at those of the last. A smooth route does so, too, and has OpenSim's moment arms. Its speed is not
that of its moment arms then, see `route_slip.py`.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.path.route_bends import (
    NOWHERE,
    WRAP_BIT,
    RouteKind,
    bend_after_of,
    bend_rows_of,
    bends_of,
)
from warpmuscle.kernels.path.route_points import always, place_of, placed_of, placed_points_of, slopes_of, sometimes
from warpmuscle.kernels.path.route_pulls import act_of, act_on_ends_of, levers_of_stops, pull_rows_of, pulls_of, room_of
from warpmuscle.kernels.path.route_slip import SHORTEST, slip
from warpmuscle.kernels.structs import ModelRef, RouteSpan, ScratchRef, StateRef, at, nonnegative


@func(inline=True)
def body_of(span: RouteSpan, stop: int, wrap: int, model: ModelRef) -> int:
    """The body that a stop is on, a point of the route or where it reaches this surface."""
    if stop < WRAP_BIT:
        return model.routes.point[span.first_point + stop].body
    return model.routes.wrap[span.first_wrap + wrap].body


@func(inline=True)
def as_it_is(instance: int, span: RouteSpan, stop: int, next_point: int, model: ModelRef) -> float:
    """What `in_branches` says of routes without branches."""
    return 1.0


@func(inline=True)
def in_branches(instance: int, span: RouteSpan, stop: int, next_point: int, model: ModelRef) -> float:
    """What the way to a stop counts: as much as that to the point which it is, or which follows a surface."""
    return at(model.routes.share, instance, span.first_point + wp.where(stop < WRAP_BIT, stop, next_point))


@cache
def stops_of(kind: RouteKind, moving: bool) -> tuple[Any, Any]:
    """The Warp functions that say whether a point of a route counts, and where it is: from what a lane has kept.

    Args:
        moving: whether is asked how fast points move, too. Places of those that do are then found once more.
    """
    room, slopes_struct = max(kind.places, 1), slopes_of(max(kind.motions, 1))
    placed_struct, points = placed_of(room), placed_points_of(room, kind.motions, kind.conditions, kind.places_start)
    counts_now, place_now = sometimes if kind.conditions else always, place_of(kind.motions)
    kept, counts_at, place_at = kind.places > 0, points.counts, points.place

    @wp.func(inline=True)
    def counts(
        instance: int, span: RouteSpan, stop: int, placed: wp.ref[placed_struct], model: ModelRef, state: StateRef
    ) -> bool:
        if wp.static(kept):
            return counts_at(placed, stop)
        return counts_now(instance, span.first_point + stop, model, state)

    @wp.func(inline=True)
    def place(
        instance: int, span: RouteSpan, stop: int, placed: wp.ref[placed_struct], model: ModelRef, state: StateRef,
        work: ScratchRef, slopes: wp.ref[slopes_struct],
    ) -> wp.vec3:  # fmt: skip
        if wp.static(kept):
            if wp.static(moving):
                point = model.routes.point[nonnegative(span.first_point + stop)]
                if point.end_motion > point.first_motion:
                    return place_now(instance, span.first_point + stop, span.origin, model, state, work, slopes)
            return place_at(placed, stop)
        return place_now(instance, span.first_point + stop, span.origin, model, state, work, slopes)

    return counts, place


@cache
def measured_ends_of(kind: RouteKind) -> tuple[Any, Any]:
    """The Warp functions of the places where a route's length says that it reaches surface k and leaves it.

    They take (bends, k, last), the place of the last round. Round several surfaces they are those of the first round.
    """
    count = max(kind.wraps, 1)
    bends_struct, rows = bends_of(count), bend_rows_of(kind)
    kept_first_at, kept_second_at = rows.kept_first.get, rows.kept_second.get

    @wp.func(inline=True)
    def reaches(bends: wp.ref[bends_struct], k: int, last: wp.vec3) -> wp.vec3:
        place = last
        if wp.static(count > 1) and (bends.kept >> k) & 1 == 1:
            place = kept_first_at(bends, k)
        return place

    @wp.func(inline=True)
    def leaves(bends: wp.ref[bends_struct], k: int, last: wp.vec3) -> wp.vec3:
        place = last
        if wp.static(count > 1) and (bends.kept >> k) & 1 == 1:
            place = kept_second_at(bends, k)
        return place

    return reaches, leaves


@cache
def walk_of(
    kind: RouteKind, acting: bool, coordinate_joints: bool = False, followers: bool = False, wrench: bool = False
) -> Any:
    """The Warp function that walks along a route and gives its length, m, but for what is fixed of it.

    Args: acting: whether it gives the moment arms, too. Others are those of `path.segments_stretch_of`; see `room_of`.
    """
    count, motions, wrapping, across = max(kind.wraps, 1), kind.motions > 0 and not wrench, kind.wraps > 0, kind.across
    bends_struct, bend_after, placed_struct = bends_of(count), bend_after_of(count), placed_of(max(kind.places, 1))
    counts, place = stops_of(kind, acting and motions)
    slips, bodies = kind.slips and acting and not wrench, (motions and across) or kind.slips
    last, add_arm = room_of(kind, wrench) - 1, pull_rows_of(kind, room_of(kind, wrench)).add
    act, act_on_ends = act_of(kind, coordinate_joints or followers, wrench), act_on_ends_of(kind.motions)
    pulls_struct, slopes_struct = pulls_of(room_of(kind, wrench)), slopes_of(max(kind.motions, 1))
    rows, share_of = bend_rows_of(kind), in_branches if kind.branches else as_it_is
    first_at, second_at, arc_of = rows.first.get, rows.second.get, rows.arc.get
    (reaches, leaves), levers_of = measured_ends_of(kind), levers_of_stops(kind, acting)

    @wp.func(inline=True)
    def walk(
        instance: int, span: RouteSpan, bends: wp.ref[bends_struct], placed: wp.ref[placed_struct], model: ModelRef,
        state: StateRef, work: ScratchRef, pulls: wp.ref[pulls_struct], arm: wp.array[wp.vec3],
    ) -> float:  # fmt: skip
        total = wp.float32(0.0)
        slopes = slopes_struct()
        slopes_before = slopes_struct()
        a = wp.vec3(0.0)
        left = wp.vec3(0.0)
        before = int(NOWHERE)
        body_before = wp.int32(0)
        body = wp.int32(0)
        next_point = wp.int32(0)
        onto = int(NOWHERE)
        behind = wp.int32(0)
        while next_point < span.end_point - span.first_point or onto >= 0:
            b = wp.vec3(0.0)
            stop = int(next_point)
            fixed = wp.int32(0)
            reached = wp.vec3(0.0)
            if onto >= 0:
                reached = first_at(bends, onto)
                b = reaches(bends, onto, reached)
                stop = WRAP_BIT + onto
            else:
                next_point += 1
                if not counts(instance, span, stop, placed, model, state):
                    continue
                b = place(instance, span, stop, placed, model, state, work, slopes)
                reached = b
                fixed = model.routes.point[span.first_point + stop].fixed
            if wp.static(bodies):
                body = body_of(span, stop, onto, model)
            beyond = levers_of(span, stop, onto, model)
            between = body != body_before
            share = share_of(instance, span, stop, next_point, model)
            if before != NOWHERE and fixed == 0:
                d = b - a
                length = wp.length(d)
                total += share * length
                if wp.static(acting):
                    direction = d * (share / wp.max(length, SHORTEST))
                    act(instance, span, a, left, reached, direction, before, stop, behind, beyond, between, model,
                        state, work, pulls)  # fmt: skip
                    if wp.static(slips):
                        faster = slip(span, before, stop, body_before, body, d, reached - left, model, work)
                        add_arm(pulls, wp.static(last), wp.vec3(share * faster, 0.0, 0.0))
                    if wp.static(motions):  # noqa: SIM102, as above
                        if wp.static(not across) or between:
                            act_on_ends(
                                instance, span, before, stop, direction, slopes_before, slopes, model, work, arm
                            )
            a = b
            left = reached
            before = stop
            behind = beyond
            body_before = body
            slopes_before.of = slopes.of
            if wp.static(wrapping):
                if onto >= 0:
                    total += share * arc_of(bends, onto)
                    left = second_at(bends, onto)
                    a = leaves(bends, onto, left)
                    if wp.static(slips):
                        faster = slip(span, stop, stop, body, body, a - b, left - reached, model, work)
                        add_arm(pulls, wp.static(last), wp.vec3(share * faster, 0.0, 0.0))
                onto = bend_after(stop, span.end_wrap - span.first_wrap, bends.after)
        return total

    return walk
