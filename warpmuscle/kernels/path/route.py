"""Routes: musculotendon paths that wrap around surfaces, whose points move, or come in all at once.

A route is walked from stop to stop: its own points, and where it reaches and leaves a surface. Which segment goes
round which surface, and in which order, is OpenSim 4.6's (GeometryPath::applyWrapObjects). The places where it touches
a surface count as fixed to the surface's body: on the shortest path they do not matter to first order, and
elsewhere this is how OpenSim's moment arms come about. All places are measured from the joint of one body, along
world axes, so that no large numbers are subtracted.

Functions that are given the model have to be inlined: else all of it would lie in memory of the lane's own.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.register_rows import near_rows_of, rows_of
from warpmuscle.kernels.path.path import PathState, add_crossings
from warpmuscle.kernels.path.route_bend import bend_of
from warpmuscle.kernels.path.route_bends import NOWHERE, WRAP_BIT, RouteKind, bend_rows_of, bends_of
from warpmuscle.kernels.path.route_points import placed_of, placed_points_of
from warpmuscle.kernels.path.route_pulls import lever_arm_of, pull_rows_of, pulls_of, room_of
from warpmuscle.kernels.path.route_rows import lay_of
from warpmuscle.kernels.path.route_walk import walk_of
from warpmuscle.kernels.path.wrap_touch import FREE, INSIDE
from warpmuscle.kernels.structs import ModelRef, RouteSpan, RouteWrap, ScratchRef, StateRef, at, nonnegative

ROUNDS = 8  # of a route with several surfaces, each going on where the one before ended ...
SETTLED = 5.0e-4  # m, by which the length then changes no more
SETTLED_EXACT = 1.0e-6


@cache
def remove_of(count: int) -> Any:
    """The Warp function that lets a route run straight past one of so many surfaces."""
    bends_struct, rows = bends_of(count), rows_of(count)
    number, with_number = rows.number, rows.with_number

    @wp.func
    def remove(w: int, wraps: int, bends: wp.ref[bends_struct]):
        before = number(bends.after, w)
        for other in range(count):
            if other < wraps and number(bends.after, other) == WRAP_BIT + w:
                bends.after = with_number(bends.after, other, before)
        bends.after = with_number(bends.after, w, NOWHERE)

    return remove


@func
def neighbours(w: int, span: RouteSpan, wrap: wp.array[RouteWrap]) -> int:
    """A bit for each other surface of a route that may be gone round on a segment on which this one is, too."""
    own = wrap[span.first_wrap + w]
    found = wp.int32(0)
    for other in range(span.end_wrap - span.first_wrap):
        one = wrap[span.first_wrap + other]
        if other != w and wp.max(own.first, one.first) < wp.min(own.last, one.last):
            found = found | (1 << other)
    return found


@cache
def settle_of(kind: RouteKind, wrench: bool) -> Any:
    """The Warp function that goes round several surfaces in turn until the length stays.

    A surface is gone round again only if the path has changed since round one on the same segments: else the same would
    come out again. What is compiled in is that of `route_stretch_of`.
    """
    count, exact, settled = max(kind.wraps, 1), kind.exact, SETTLED_EXACT if kind.exact else SETTLED
    bends_struct, bend, remove, rows = bends_of(count), bend_of(kind), remove_of(count), rows_of(count)
    measure, pulls_struct = walk_of(kind, False, wrench=wrench), pulls_of(room_of(kind, wrench))
    placed_struct = placed_of(max(kind.places, 1))
    number, bend_rows = rows.number, bend_rows_of(kind)
    first_at, second_at = bend_rows.first.get, bend_rows.second.get
    keep_first, keep_second = bend_rows.kept_first.put, bend_rows.kept_second.put

    @wp.func(inline=True)
    def settle(
        instance: int, span: RouteSpan, bends: wp.ref[bends_struct], placed: wp.ref[placed_struct], model: ModelRef,
        state: StateRef, work: ScratchRef, pulls: wp.ref[pulls_struct], arm: wp.array[wp.vec3],
    ):  # fmt: skip
        wraps = span.end_wrap - span.first_wrap
        before = wp.float32(1.0e30)
        swapped = wp.int32(0)
        due = (1 << wraps) - 1  # a bit a surface that is to be gone round
        for turn in range(ROUNDS):
            one = int(FREE)
            other = int(FREE)
            for k in range(wraps):
                w = int(k)
                if swapped == 1 and k < 2:
                    w = 1 - k
                if (due >> w) & 1 == 1:
                    due = due - (1 << w)
                    stop = number(bends.after, w)
                    first = first_at(bends, w)
                    second = second_at(bends, w)
                    remove(w, wraps, bends)
                    result = bend(instance, w, span, bends, placed, model, work)
                    touches = number(bends.after, w) != NOWHERE
                    stays = first_at(bends, w) == first and second_at(bends, w) == second
                    if number(bends.after, w) != stop or (touches and not stays):
                        due = due | neighbours(w, span, model.routes.wrap)
                    if wp.static(not exact) and wraps > 1 and touches and (bends.kept >> w) & 1 == 0:
                        bends.kept = bends.kept | (1 << w)
                        keep_first(bends, w, first_at(bends, w))
                        keep_second(bends, w, second_at(bends, w))
                    if k == 0:
                        one = result
                    if k == 1:
                        other = result
            if turn == 0 and one == FREE and other == INSIDE:
                swapped = 1
                due = (1 << wraps) - 1
                remove(0, wraps, bends)
            if due == 0:
                break
            length = measure(instance, span, bends, placed, model, state, work, pulls, arm)
            if wp.abs(length - before) < settled:
                break
            before = length

    return settle


@cache
def give_wrenches_of(kind: RouteKind, levers: int) -> Any:
    """The Warp function that adds what levers have gathered to the moments and forces on their bodies.

    Args:
        kind, levers: of the route, and rows that there are: of moments, then of forces.
    """
    pulls_struct, arm_at = pulls_of(levers), pull_rows_of(kind, levers).get

    @wp.func(inline=True)
    def give_wrenches(
        instance: int, span: RouteSpan, pulls: wp.ref[pulls_struct], model: ModelRef, work: ScratchRef,
        arm: wp.array[wp.vec3],
    ):  # fmt: skip
        for k in range(span.first_lever, span.end_lever):
            joint = nonnegative(model.routes.lever[nonnegative(k)].joint)
            place = model.body_count + joint
            arm[joint] = arm[joint] + arm_at(pulls, k - span.first_lever)
            arm[place] = arm[place] + arm_at(pulls, k - span.first_lever + wp.static(levers // 2))

    return give_wrenches


@cache
def give_arms_of(kind: RouteKind, levers: int, coordinate_joints: bool, followers: bool) -> Any:
    """The Warp function that adds what levers have gathered to the moment arms of the muscle's crossings."""
    arm_at, pulls_struct = pull_rows_of(kind, levers).get, pulls_of(levers)
    lever_arm, together = lever_arm_of(coordinate_joints, followers), followers and kind.many_levers

    @wp.func(inline=True)
    def give_arms(
        instance: int, span: RouteSpan, pulls: wp.ref[pulls_struct], model: ModelRef, work: ScratchRef,
        arm: wp.array[wp.vec3],
    ):  # fmt: skip
        gathered = wp.vec3(0.0)
        for k in range(span.first_lever, span.end_lever):
            crossing_of = nonnegative(model.routes.lever[nonnegative(k)].crossing)
            joint = nonnegative(model.routes.lever[nonnegative(k)].joint)
            if wp.static(together):
                gathered += arm_at(pulls, k - span.first_lever)
                if model.routes.lever[nonnegative(k)].last != 0:
                    r = lever_arm(instance, joint, gathered, model, work)
                    arm[crossing_of] = arm[crossing_of] + r
                    gathered = wp.vec3(0.0)
            else:
                r = lever_arm(instance, joint, arm_at(pulls, k - span.first_lever), model, work)
                arm[crossing_of] = arm[crossing_of] + r

    return give_arms


@cache
def route_stretch_of(
    kind: RouteKind, coordinate_joints: bool = False, followers: bool = False, wrench: bool = False
) -> Any:
    """The Warp function of length and speed of a route and its moment arms, see `path.segments_stretch_of`.

    Args:
        kind: what is compiled in. wrench: see there.
    """
    levers, count, several = room_of(kind, wrench), max(kind.wraps, 1), kind.wraps > 1
    bends_struct, bend, pulls_struct = bends_of(count), bend_of(kind), pulls_of(levers)
    walk = walk_of(kind, True, coordinate_joints, followers, wrench)
    rows = kind.mujoco and kind.rows
    apart = kind.mujoco and several and not rows
    lay = lay_of(kind) if rows else bend
    settle = settle_of(kind, wrench) if several and not apart and not rows else bend
    with_number, arm_at = rows_of(count).with_number, pull_rows_of(kind, levers).get
    near = near_rows_of(int(kind.near) * kind.numbers)
    give_arms = give_arms_of(kind, levers, coordinate_joints or followers, followers)
    if wrench:
        give_arms = give_wrenches_of(kind, levers)
    kept, room = kind.places > 0, max(kind.places, 1)
    placed_struct, find = placed_of(room), placed_points_of(room, kind.motions, kind.conditions, kind.places_start).find

    @wp.func(inline=True)
    def route_stretch(
        instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef, arm: wp.array[wp.vec3]
    ) -> PathState:
        span = model.routes.span[muscle]
        own = model.paths.span[muscle]
        bends = bends_struct()
        placed = placed_struct()
        bends.near = near()
        placed.near = bends.near
        pulls = pulls_struct()
        wraps = span.end_wrap - span.first_wrap
        for w in range(count):
            bends.after = with_number(bends.after, w, NOWHERE)
        if wp.static(not wrench):
            for k in range(own.first_crossing, own.end_crossing):
                arm[nonnegative(model.paths.of_muscle[nonnegative(k)].number)] = wp.vec3(0.0)
        if wp.static(kept):
            find(instance, span, placed, model, state, work)
        if wp.static(rows):
            if wraps > 0:
                lay(instance, span, bends, model, state, work)
        elif wp.static(apart):
            for w in range(wraps):
                bend(instance, w, span, bends, placed, model, work)
        elif wp.static(several):
            if wraps > 0:
                settle(instance, span, bends, placed, model, state, work, pulls, arm)
        elif wraps == 1:
            bend(instance, 0, span, bends, placed, model, work)
        total = PathState()
        total.fixed = at(model.paths.fixed_length, instance, muscle)
        total.moving = walk(instance, span, bends, placed, model, state, work, pulls, arm)
        give_arms(instance, span, pulls, model, work, arm)
        if wp.static(not wrench):
            add_crossings(total, muscle, model, work, arm)
        if wp.static(kind.slips and not wrench):
            total.speed += arm_at(pulls, wp.static(levers - 1))[0]
        return total

    return route_stretch
