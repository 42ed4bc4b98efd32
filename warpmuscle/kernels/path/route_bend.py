"""How a route goes round one of its surfaces: the segment of it that bends, and where it touches the surface then."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.main_memory import rotation_of
from warpmuscle.kernels.memory.register_rows import rows_of
from warpmuscle.kernels.path.path import offset_between
from warpmuscle.kernels.path.route_bends import (
    FAR,
    NOWHERE,
    ROUNDING,
    TORUS,
    WRAP_BIT,
    RouteKind,
    bend_after_of,
    bend_rows_of,
    bends_of,
    mujoco_touch_of,
    touch_of,
)
from warpmuscle.kernels.path.route_points import placed_of, placed_points_of
from warpmuscle.kernels.path.wrap_cylinder import AMONG_OTHERS, EXACT, IN_PLANE
from warpmuscle.kernels.path.wrap_torus import least_detour, torus_touch_of
from warpmuscle.kernels.path.wrap_touch import BESIDE, FREE, THROUGH, Touch
from warpmuscle.kernels.structs import ModelRef, RouteSpan, RouteWrap, ScratchRef, at, nonnegative


@func
def detour_of(touch: Touch, here: wp.vec3, there: wp.vec3) -> float:
    """How much longer a segment is for what it touches, m."""
    return wp.length(touch.first - here) + touch.arc + wp.length(there - touch.second) - wp.length(there - here)


@func
def asked(w: int, span: RouteSpan, ends: bool) -> bool:
    """Whether it matters what a segment without a detour does at surface w: `settle` asks of the first one's last."""
    return w == 0 and span.end_wrap - span.first_wrap > 1 and ends


def has_tori(kind: RouteKind) -> bool:
    """Whether some of a kind's surfaces are tori."""
    return TORUS in kind.surfaces and not kind.mujoco


@wp.struct
class Crossing:
    """The segment of a route that is nearest to a torus's plane."""

    stop: int  # that it begins at, NOWHERE if none does
    touch: Touch
    detour: float  # m


@func
def shorter(here: wp.vec3, there: wp.vec3, size: wp.vec3, known: Crossing) -> bool:
    """Whether a segment may go through a torus by a shorter detour than the one that is known."""
    return least_detour(here, there, size[0]) <= known.detour + ROUNDING


@cache
def measured_of(kind: RouteKind) -> tuple[Any, Any]:
    """The Warp functions of where a segment ends on a surface and begins on one, as far as its length is concerned.

    In a surface's axes, of which they take the inverse and the centre; see `RouteKind.keeps`.
    """
    count, keeps, rows = max(kind.wraps, 1), kind.keeps, bend_rows_of(kind)
    bends_struct, kept_first_at, kept_second_at = bends_of(count), rows.kept_first.get, rows.kept_second.get

    @wp.func(inline=True)
    def reached(now: wp.vec3, onto: int, bends: wp.ref[bends_struct], inverse: wp.mat33, center: wp.vec3) -> wp.vec3:
        place = wp.vec3(now)
        if wp.static(keeps):  # noqa: SIM102, with `and` it would be compiled in all the same
            if onto >= 0:
                place = inverse * (kept_first_at(bends, onto) - center)
        return place

    @wp.func(inline=True)
    def left(now: wp.vec3, onto: int, bends: wp.ref[bends_struct], inverse: wp.mat33, center: wp.vec3) -> wp.vec3:
        place = wp.vec3(now)
        if wp.static(keeps):  # noqa: SIM102, with `and` it would be compiled in all the same
            if onto >= 0:
                place = inverse * (kept_second_at(bends, onto) - center)
        return place

    return reached, left


@cache
def crossing_of(kind: RouteKind) -> Any:
    """The Warp function of the segment on which a route most likely goes through a torus, and of its detour there.

    The detour of others cannot be as short if they are farther from the torus's plane by more than that, which spares
    the search for their nearest places.
    """
    count, room = max(kind.wraps, 1), max(kind.places, 1)
    bends_struct, bend_after, rows = bends_of(count), bend_after_of(count), bend_rows_of(kind)
    first_at, second_at = rows.first.get, rows.second.get
    placed_struct, points = placed_of(room), placed_points_of(room, kind.motions, kind.conditions, kind.places_start)
    counts, place = points.counts, points.place
    torus_touch, (reached, left) = torus_touch_of(kind.as_opensim), measured_of(kind)

    @wp.func(inline=True)
    def crossing(
        span: RouteSpan, between: wp.vec2i, center: wp.vec3, inverse: wp.mat33, wrap: RouteWrap, size: wp.vec3,
        where: int, bends: wp.ref[bends_struct], placed: wp.ref[placed_struct], model: ModelRef,
    ) -> Crossing:  # fmt: skip
        found = Crossing()
        found.stop = NOWHERE
        found.detour = wp.float32(FAR)
        wraps = span.end_wrap - span.first_wrap
        last = between[1]
        stop = int(between[0])
        if wrap.kind != TORUS or last - stop <= 1:
            return found
        point = int(stop)
        here = inverse * (place(placed, stop) - center)
        measured_here = wp.vec3(here)
        near_here = wp.vec3(0.0)
        near_there = wp.vec3(0.0)
        least_here = wp.vec3(0.0)
        least_there = wp.vec3(0.0)
        least = wp.float32(FAR)
        from_surface = int(NOWHERE)
        while point < last:
            there = wp.vec3(0.0)
            to_surface = int(NOWHERE)
            onto = int(NOWHERE)
            if wp.static(count > 1):
                onto = bend_after(stop, wraps, bends.after)
            if onto >= 0:
                there = inverse * (first_at(bends, onto) - center)
                to_surface = model.routes.wrap[span.first_wrap + onto].surface
            else:
                point += 1
                while not counts(placed, point):
                    point += 1
                there = inverse * (place(placed, point) - center)
            measured_there = reached(there, onto, bends, inverse, center)
            bound = least_detour(measured_here, measured_there, size[0])
            if bound < least and (from_surface == NOWHERE or from_surface != to_surface):
                least = bound
                found.stop = stop
                near_here = here
                near_there = there
                least_here = measured_here
                least_there = measured_there
            stop = point
            here = there
            from_surface = to_surface
            if onto >= 0:
                stop = WRAP_BIT + onto
                here = inverse * (second_at(bends, onto) - center)
            measured_here = left(here, onto, bends, inverse, center)
        if found.stop == NOWHERE:
            return found
        found.touch = torus_touch(near_here, near_there, size[0], size[1], wrap.axis, wrap.side, where)
        if found.touch.kind >= BESIDE:
            found.detour = detour_of(found.touch, least_here, least_there)
        return found

    return crossing


@cache
def no_crossing_of(kind: RouteKind) -> Any:
    """The same where there are no tori: no segment."""
    bends_struct, placed_struct = bends_of(max(kind.wraps, 1)), placed_of(max(kind.places, 1))

    @wp.func(inline=True)
    def no_crossing(
        span: RouteSpan, between: wp.vec2i, center: wp.vec3, inverse: wp.mat33, wrap: RouteWrap, size: wp.vec3,
        where: int, bends: wp.ref[bends_struct], placed: wp.ref[placed_struct], model: ModelRef,
    ) -> Crossing:  # fmt: skip
        return Crossing()

    return no_crossing


@cache
def tried_of(kind: RouteKind) -> Any:
    """The Warp function of how a segment goes round surface w, where that may matter.

    It takes between which places the segment is `measured`, whether it `ends` the interval, and the one that is
    `known`, see `crossing_of`.
    """
    mujoco, tori = kind.mujoco, has_tori(kind)
    touch_at = mujoco_touch_of(kind.surfaces) if mujoco else touch_of(kind.surfaces, kind.smooth, kind.as_opensim)

    @wp.func(inline=True)
    def tried(
        instance: int, w: int, span: RouteSpan, here: wp.vec3, there: wp.vec3, measured_here: wp.vec3,
        measured_there: wp.vec3, stop: int, ends: bool, wrap: RouteWrap, size: wp.vec3, where: int, known: Crossing,
        model: ModelRef,
    ) -> Touch:  # fmt: skip
        touch = Touch()
        if wp.static(mujoco):
            touch = touch_at(here, there, wrap, size, at(model.routes.side_point, instance, span.first_wrap + w))
        elif wp.static(tori):
            if known.detour < FAR and known.stop == stop:
                touch = known.touch
            elif known.detour >= FAR or asked(w, span, ends) or shorter(measured_here, measured_there, size, known):
                touch = touch_at(here, there, wrap, size, where)
        else:
            touch = touch_at(here, there, wrap, size, where)
        return touch

    return tried


@cache
def bend_of(kind: RouteKind) -> Any:
    """The Warp function that lets a route go round one of its surfaces, where that is best.

    Its result is what the route's last segment does there, see `wrap_touch.py`.
    """
    count = max(kind.wraps, 1)
    bends_struct, bend_after = bends_of(count), bend_after_of(count)
    room, tried = max(kind.places, 1), tried_of(kind)
    placed_struct, points = placed_of(room), placed_points_of(room, kind.motions, kind.conditions, kind.places_start)
    counts, place, interval = points.counts, points.place, points.interval
    crossing = crossing_of(kind) if has_tori(kind) else no_crossing_of(kind)
    exact, rows, (reached, left) = kind.exact, bend_rows_of(kind), measured_of(kind)
    first_at, second_at, with_number = rows.first.get, rows.second.get, rows_of(count).with_number
    put_first, put_second, put_arc = rows.first.put, rows.second.put, rows.arc.put

    @wp.func(inline=True)
    def bend(
        instance: int, w: int, span: RouteSpan, bends: wp.ref[bends_struct], placed: wp.ref[placed_struct],
        model: ModelRef, work: ScratchRef,
    ) -> int:  # fmt: skip
        routes = model.routes
        origin = span.origin
        wraps = span.end_wrap - span.first_wrap
        wrap = routes.wrap[nonnegative(span.first_wrap + w)]
        own = at(routes.wrap_row, instance, span.first_wrap + w)
        body = rotation_of(nonnegative(wrap.body), work)
        center = body * own.position + offset_between(wrap.body, origin, work)
        axes = body * own.rotation
        between = interval(placed, wrap.first, wrap.last)
        last = between[1]
        stop = int(between[0])
        point = int(stop)
        here = wp.transpose(axes) * (place(placed, stop) - center)
        measured_here = wp.vec3(here)
        from_surface = int(NOWHERE)
        result = int(FREE)
        where = int(EXACT)
        if wp.static(not exact):
            where = wp.where(wraps > 1, AMONG_OTHERS, IN_PLANE)
        best = wp.float32(FAR)
        found = int(NOWHERE)
        known = crossing(span, between, center, wp.transpose(axes), wrap, own.size, where, bends, placed, model)
        while point < last:
            there = wp.vec3(0.0)
            to_surface = int(NOWHERE)
            onto = int(NOWHERE)
            if wp.static(count > 1):
                onto = bend_after(stop, wraps, bends.after)
            if onto >= 0:
                there = wp.transpose(axes) * (first_at(bends, onto) - center)
                to_surface = routes.wrap[span.first_wrap + onto].surface
            else:
                point += 1
                while not counts(placed, point):
                    point += 1
                there = wp.transpose(axes) * (place(placed, point) - center)
            measured_there = reached(there, onto, bends, wp.transpose(axes), center)
            if from_surface == NOWHERE or from_surface != to_surface:
                touch = tried(
                    instance, w, span, here, there, measured_here, measured_there, stop, point >= last, wrap, own.size,
                    where, known, model,
                )  # fmt: skip
                result = touch.kind
                if result >= BESIDE:
                    detour = detour_of(touch, measured_here, measured_there)
                    if result == THROUGH or detour < best:
                        best = detour
                        found = stop
                        put_arc(bends, w, touch.arc)
                        put_first(bends, w, center + axes * touch.first)
                        put_second(bends, w, center + axes * touch.second)
                    if result == THROUGH:
                        break
            stop = point
            here = there
            from_surface = to_surface
            if onto >= 0:
                stop = WRAP_BIT + onto
                here = wp.transpose(axes) * (second_at(bends, onto) - center)
            measured_here = left(here, onto, bends, wp.transpose(axes), center)
        if found != NOWHERE:
            if wp.static(count > 1):
                behind = bend_after(found, wraps, bends.after)
                if behind >= 0:
                    bends.after = with_number(bends.after, behind, WRAP_BIT + w)
            bends.after = with_number(bends.after, w, found)
        return result

    return bend
