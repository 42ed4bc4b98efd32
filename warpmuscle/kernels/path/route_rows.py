"""Routes over several surfaces in a row between two of their points: the shortest ones.

Each surface in turn is gone over from where the path leaves the one before to where it reaches the one behind, until no
place of touch moves any more: each turn makes the path shorter. One is gone over again only if another one in its row
has changed: else the same would come out again. A surface with a side point is touched there at first,
which says on which side of it the path runs, others are not touched at first.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.main_memory import rotation_of
from warpmuscle.kernels.memory.register_rows import rows_of
from warpmuscle.kernels.path.path import offset_between
from warpmuscle.kernels.path.route_bends import (
    CYLINDER,
    NOWHERE,
    WRAP_BIT,
    RouteKind,
    bend_rows_of,
    bends_of,
    mujoco_touch_of,
)
from warpmuscle.kernels.path.route_points import place_of, slopes_of
from warpmuscle.kernels.path.wrap_mujoco import NO_SIDE
from warpmuscle.kernels.path.wrap_touch import FREE
from warpmuscle.kernels.structs import ModelRef, RouteSpan, ScratchRef, StateRef, at, nonnegative

SWEEPS = 100  # over all surfaces of a route, at most
SETTLED = 1.0e-6  # m, by which no place of touch then moves any more


@cache
def neighbours_of(count: int) -> Any:
    """The Warp functions of the wraps before and behind one in its row that the path touches, NOWHERE if none is."""
    stops = wp.types.vector(length=count, dtype=int)
    number = rows_of(count).number

    @wp.func
    def touched_before(w: int, span: RouteSpan, after: stops, model: ModelRef) -> int:
        found = int(NOWHERE)
        first = model.routes.wrap[nonnegative(span.first_wrap + w)].first
        for k in range(w):
            if model.routes.wrap[nonnegative(span.first_wrap + k)].first == first and number(after, k) != NOWHERE:
                found = int(k)
        return found

    @wp.func
    def touched_behind(w: int, span: RouteSpan, after: stops, model: ModelRef) -> int:
        found = int(NOWHERE)
        first = model.routes.wrap[nonnegative(span.first_wrap + w)].first
        for k in range(w + 1, span.end_wrap - span.first_wrap):
            same = model.routes.wrap[nonnegative(span.first_wrap + k)].first == first
            if found == NOWHERE and same and number(after, k) != NOWHERE:
                found = int(k)
        return found

    return touched_before, touched_behind


@func(inline=True)
def others_in_row(w: int, span: RouteSpan, model: ModelRef) -> int:
    """The other wraps of a route between the same two of its points, a bit each."""
    found = wp.int32(0)
    first = model.routes.wrap[nonnegative(span.first_wrap + w)].first
    for k in range(span.end_wrap - span.first_wrap):
        if k != w and model.routes.wrap[nonnegative(span.first_wrap + k)].first == first:
            found = found | (1 << k)
    return found


@cache
def lay_of(kind: RouteKind) -> Any:
    """The Warp function that lets a route go over all of its surfaces; what is compiled in is that of the route."""
    count = max(kind.wraps, 1)
    bends_struct, rows, touch_at = bends_of(count), rows_of(count), mujoco_touch_of(kind.surfaces)
    place, slopes_struct = place_of(kind.motions), slopes_of(max(kind.motions, 1))
    touched_before, touched_behind = neighbours_of(count)
    number, with_number, bend_rows = rows.number, rows.with_number, bend_rows_of(kind)
    first_at, second_at = bend_rows.first.get, bend_rows.second.get
    put_first, put_second, put_arc = bend_rows.first.put, bend_rows.second.put, bend_rows.arc.put

    @wp.func(inline=True)
    def lay(
        instance: int, span: RouteSpan, bends: wp.ref[bends_struct], model: ModelRef, state: StateRef, work: ScratchRef
    ):
        routes = model.routes
        slopes = slopes_struct()
        wraps = span.end_wrap - span.first_wrap
        due = wp.int32(0)  # a bit a surface that is to be gone over
        for sweep in range(SWEEPS + 1):
            moved = wp.float32(0.0)
            for w in range(wraps):
                if sweep > 0:
                    if (due >> w) & 1 == 0:
                        continue
                    due = due - (1 << w)
                wrap = routes.wrap[nonnegative(span.first_wrap + w)]
                own = at(routes.wrap_row, instance, span.first_wrap + w)
                side = at(routes.side_point, instance, span.first_wrap + w)
                body = rotation_of(nonnegative(wrap.body), work)
                center = body * own.position + offset_between(wrap.body, span.origin, work)
                axes = body * own.rotation
                if sweep == 0:
                    if wrap.side != NO_SIDE:
                        flat = wp.where(wrap.kind == CYLINDER, wp.vec3(side[0], side[1], 0.0), side)
                        start = center + axes * (side + wp.normalize(flat) * (own.size[0] - wp.length(flat)))
                        put_first(bends, w, start)
                        put_second(bends, w, start)
                        bends.after = with_number(bends.after, w, 0)
                    moved = 1.0
                    due = due | (1 << w)
                else:
                    near = touched_before(w, span, bends.after, model)
                    far = touched_behind(w, span, bends.after, model)
                    before = wp.vec3(0.0)
                    behind = wp.vec3(0.0)
                    if near >= 0:
                        before = second_at(bends, near)
                    else:
                        before = place(instance, span.first_point + wrap.first, span.origin, model, state, work, slopes)
                    if far >= 0:
                        behind = first_at(bends, far)
                    else:
                        behind = place(instance, span.first_point + wrap.last, span.origin, model, state, work, slopes)
                    turn = wp.transpose(axes)
                    touch = touch_at(turn * (before - center), turn * (behind - center), wrap, own.size, side)
                    touched = number(bends.after, w) != NOWHERE
                    if touch.kind != FREE:
                        first = center + axes * touch.first
                        second = center + axes * touch.second
                        change = wp.length(first - first_at(bends, w)) + wp.length(second - second_at(bends, w))
                        change = wp.where(touched, change, 1.0)
                        moved = wp.max(moved, change)
                        if change > 0.0:
                            due = due | others_in_row(w, span, model)
                        put_first(bends, w, first)
                        put_second(bends, w, second)
                        put_arc(bends, w, touch.arc)
                        bends.after = with_number(bends.after, w, 0)
                    else:
                        if touched:
                            moved = 1.0
                            due = due | others_in_row(w, span, model)
                        bends.after = with_number(bends.after, w, NOWHERE)
            if moved < SETTLED or due == 0:
                break
        for k in range(wraps):
            w = wraps - 1 - k  # from the last on, since those before are looked for by what is kept
            if number(bends.after, w) != NOWHERE:
                near = touched_before(w, span, bends.after, model)
                stop = wp.where(near >= 0, WRAP_BIT + near, routes.wrap[nonnegative(span.first_wrap + w)].first)
                bends.after = with_number(bends.after, w, stop)

    return lay
