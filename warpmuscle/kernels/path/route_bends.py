"""How a route goes round surfaces: one segment of it round one surface."""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.register_rows import rows_of
from warpmuscle.kernels.path.path import offset_between
from warpmuscle.kernels.path.route_points import placed_of, placed_points_of
from warpmuscle.kernels.path.wrap_cylinder import AMONG_OTHERS, EXACT, IN_PLANE, cylinder_touch_of
from warpmuscle.kernels.path.wrap_ellipsoid import ellipsoid_touch_of
from warpmuscle.kernels.path.wrap_mujoco import mujoco_cylinder_touch, mujoco_sphere_touch
from warpmuscle.kernels.path.wrap_sphere import smooth_sphere_touch, sphere_touch
from warpmuscle.kernels.path.wrap_torus import least_detour, torus_touch_of
from warpmuscle.kernels.path.wrap_touch import BESIDE, FREE, THROUGH, Touch
from warpmuscle.kernels.structs import ModelRef, RouteSpan, RouteWrap, ScratchRef, at, nonnegative

CYLINDER, SPHERE, ELLIPSOID, TORUS = 0, 1, 2, 3
WRAP_BIT = 24  # of a stop on the first wrap of a route, in `Lever.beyond`; the points come before
NOWHERE = -1
FAR = 1.0e30  # m, longer than any way
ROUNDING = 1.0e-6  # m, by which detours may be wrong


class RouteKind(NamedTuple):
    """What is compiled in for routes."""

    wraps: int = 0  # the most that one has
    levers: int = 0  # the same
    surfaces: tuple[int, ...] = ()  # CYLINDER ..., those that there are
    motions: int = 0  # the most that a point has
    conditions: bool = True  # whether some count only at times
    exact: bool = False  # whether routes around cylinders are the shortest ones, see `wrap_cylinder.py`
    smooth: bool = False  # whether no route jumps off cylinders, spheres and ellipsoids
    mujoco: bool = False  # whether each surface is between two points of its own, see `wrap_mujoco.py`; then exact
    branches: bool = False  # whether the ways to some points count more or less than others
    rows: bool = False  # whether some go over several surfaces between two of their points, see `route_rows.py`
    across: bool = False  # whether motions of points pull on segments between two bodies alone
    points: int = 0  # for how many of a route there is room, where some wrap

    @property
    def places(self) -> int:
        """Points whose places a lane keeps, see `route_points.placed_of`; 0: it finds each where it is asked for."""
        return max(self.points, 1) if self.wraps > 0 and not self.rows else 0

    @property
    def as_opensim(self) -> bool:
        """Whether arcs are all OpenSim's, see `wrap_cylinder.py`."""
        return not self.smooth and not self.exact

    @property
    def slips(self) -> bool:
        """Whether speeds of those round several surfaces are OpenSim's, see `route_walk.py`."""
        return self.as_opensim and self.wraps > 1


@cache
def bends_of(count: int) -> Any:
    """The structure of how a route goes round its surfaces, with room for so many."""

    @wp.struct
    class Bends:
        first: wp.types.matrix(shape=(count, 3), dtype=float)  # m, where it reaches each, from the route's origin
        second: wp.types.matrix(shape=(count, 3), dtype=float)  # m, and leaves it
        arc: wp.types.vector(length=count, dtype=float)  # m, on each
        after: wp.types.vector(length=count, dtype=int)  # the stop before, NOWHERE if the route does not touch it
        kept: wp.types.vector(length=count, dtype=int)  # 1: measured from those of the first round:
        kept_first: wp.types.matrix(shape=(count, 3), dtype=float)
        kept_second: wp.types.matrix(shape=(count, 3), dtype=float)

    return Bends


@cache
def touch_of(surfaces: tuple[int, ...], smooth: bool = False, as_opensim: bool = False) -> Any:
    """The Warp function of how a segment from a to b, in a surface's axes, goes round it.

    Args:
        surfaces: the kinds that there are. smooth: see `RouteKind`. as_opensim: see `wrap_cylinder.py`.
    """
    cylinder_touch, ellipsoid_touch = cylinder_touch_of(smooth, as_opensim), ellipsoid_touch_of(smooth, as_opensim)
    torus_touch = torus_touch_of(as_opensim)
    round_sphere = smooth_sphere_touch if smooth else sphere_touch
    cylinders, spheres, ellipsoids, tori = (kind in surfaces for kind in (CYLINDER, SPHERE, ELLIPSOID, TORUS))

    @wp.func
    def touch(a: wp.vec3, b: wp.vec3, wrap: RouteWrap, size: wp.vec3, where: int) -> Touch:
        result = Touch()
        if wp.static(cylinders) and wrap.kind == CYLINDER:
            result = cylinder_touch(a, b, size[0], size[1], wrap.axis, wrap.side, where)
        if wp.static(spheres) and wrap.kind == SPHERE:
            result = round_sphere(a, b, size[0], wrap.axis, wrap.side)
        if wp.static(ellipsoids) and wrap.kind == ELLIPSOID:
            result = ellipsoid_touch(a, b, size, wrap.axis, wrap.side, wrap.method)
        if wp.static(tori) and wrap.kind == TORUS:
            result = torus_touch(a, b, size[0], size[1], wrap.axis, wrap.side, where)
        return result

    return touch


@cache
def mujoco_touch_of(surfaces: tuple[int, ...]) -> Any:
    """The same of MuJoCo's surfaces, of which `wrap.side` says whether they have a side point."""
    cylinders, spheres = (kind in surfaces for kind in (CYLINDER, SPHERE))

    @wp.func
    def touch(a: wp.vec3, b: wp.vec3, wrap: RouteWrap, size: wp.vec3, point: wp.vec3) -> Touch:
        result = Touch()
        if wp.static(cylinders) and wrap.kind == CYLINDER:
            result = mujoco_cylinder_touch(a, b, size[0], wrap.side, point)
        if wp.static(spheres) and wrap.kind == SPHERE:
            result = mujoco_sphere_touch(a, b, size[0], wrap.side, point)
        return result

    return touch


@cache
def bend_after_of(count: int) -> Any:
    """The Warp function of the wrap whose surface a route reaches behind a stop, NOWHERE if there is none."""
    stops = wp.types.vector(length=count, dtype=int)
    number = rows_of(count).number

    @wp.func
    def bend_after(stop: int, wraps: int, after: stops) -> int:
        found = int(NOWHERE)
        for w in range(count):
            if w < wraps and found == NOWHERE and number(after, w) == stop:
                found = w
        return found

    return bend_after


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
def crossing_of(kind: RouteKind) -> Any:
    """The Warp function of the segment on which a route most likely goes through a torus, and of its detour there.

    The detour of others cannot be as short if they are farther from the torus's plane by more than that, which spares
    the search for their nearest places.
    """
    count, room = max(kind.wraps, 1), max(kind.places, 1)
    bends_struct, bend_after, row = bends_of(count), bend_after_of(count), rows_of(count).row
    placed_struct, points = placed_of(room), placed_points_of(room, kind.motions, kind.conditions)
    counts, place = points.counts, points.place
    torus_touch = torus_touch_of(kind.as_opensim)

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
        near_here = wp.vec3(0.0)
        near_there = wp.vec3(0.0)
        least = wp.float32(FAR)
        from_surface = int(NOWHERE)
        while point < last:
            there = wp.vec3(0.0)
            to_surface = int(NOWHERE)
            onto = int(NOWHERE)
            if wp.static(count > 1):
                onto = bend_after(stop, wraps, bends.after)
            if onto >= 0:
                there = inverse * (row(bends.first, onto) - center)
                to_surface = model.routes.wrap[span.first_wrap + onto].surface
            else:
                point += 1
                while not counts(placed, point):
                    point += 1
                there = inverse * (place(placed, point) - center)
            bound = least_detour(here, there, size[0])
            if bound < least and (from_surface == NOWHERE or from_surface != to_surface):
                least = bound
                found.stop = stop
                near_here = here
                near_there = there
            stop = point
            here = there
            from_surface = to_surface
            if onto >= 0:
                stop = WRAP_BIT + onto
                here = inverse * (row(bends.second, onto) - center)
        if found.stop == NOWHERE:
            return found
        found.touch = torus_touch(near_here, near_there, size[0], size[1], wrap.axis, wrap.side, where)
        if found.touch.kind >= BESIDE:
            found.detour = detour_of(found.touch, near_here, near_there)
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

    It takes whether the segment `ends` the interval, and the one that is `known`, see `crossing_of`.
    """
    mujoco, tori = kind.mujoco, has_tori(kind)
    touch_at = mujoco_touch_of(kind.surfaces) if mujoco else touch_of(kind.surfaces, kind.smooth, kind.as_opensim)

    @wp.func(inline=True)
    def tried(
        instance: int, w: int, span: RouteSpan, here: wp.vec3, there: wp.vec3, stop: int, ends: bool, wrap: RouteWrap,
        size: wp.vec3, where: int, known: Crossing, model: ModelRef,
    ) -> Touch:  # fmt: skip
        touch = Touch()
        if wp.static(mujoco):
            touch = touch_at(here, there, wrap, size, at(model.routes.side_point, instance, span.first_wrap + w))
        elif wp.static(tori):
            if known.detour < FAR and known.stop == stop:
                touch = known.touch
            elif known.detour >= FAR or asked(w, span, ends) or shorter(here, there, size, known):
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
    placed_struct, points = placed_of(room), placed_points_of(room, kind.motions, kind.conditions)
    counts, place, interval = points.counts, points.place, points.interval
    crossing = crossing_of(kind) if has_tori(kind) else no_crossing_of(kind)
    exact, rows = kind.exact, rows_of(count)
    row, with_row, with_number, with_length = rows.row, rows.with_row, rows.with_number, rows.with_length

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
        body = work.rotation[nonnegative(wrap.body)]
        center = body * own.position + offset_between(wrap.body, origin, work)
        axes = body * own.rotation
        between = interval(placed, wrap.first, wrap.last)
        last = between[1]
        stop = int(between[0])
        point = int(stop)
        here = wp.transpose(axes) * (place(placed, stop) - center)
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
                there = wp.transpose(axes) * (row(bends.first, onto) - center)
                to_surface = routes.wrap[span.first_wrap + onto].surface
            else:
                point += 1
                while not counts(placed, point):
                    point += 1
                there = wp.transpose(axes) * (place(placed, point) - center)
            if from_surface == NOWHERE or from_surface != to_surface:
                touch = tried(
                    instance, w, span, here, there, stop, point >= last, wrap, own.size, where, known, model
                )  # fmt: skip
                result = touch.kind
                if result >= BESIDE:
                    detour = detour_of(touch, here, there)
                    if result == THROUGH or detour < best:
                        best = detour
                        found = stop
                        bends.arc = with_length(bends.arc, w, touch.arc)
                        bends.first = with_row(bends.first, w, center + axes * touch.first)
                        bends.second = with_row(bends.second, w, center + axes * touch.second)
                    if result == THROUGH:
                        break
            stop = point
            here = there
            from_surface = to_surface
            if onto >= 0:
                stop = WRAP_BIT + onto
                here = wp.transpose(axes) * (row(bends.second, onto) - center)
        if found != NOWHERE:
            if wp.static(count > 1):
                behind = bend_after(found, wraps, bends.after)
                if behind >= 0:
                    bends.after = with_number(bends.after, behind, WRAP_BIT + w)
            bends.after = with_number(bends.after, w, found)
        return result

    return bend
