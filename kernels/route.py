"""Routes: musculotendon paths that wrap around surfaces, whose points move, or come in all at once.

A route is walked from stop to stop: its own points, and where it reaches and leaves a surface. Which segment goes
round which surface, and in which order, is OpenSim 4.6's (GeometryPath::applyWrapObjects). The places where it touches
a surface count as fixed to the surface's body: on the shortest path they do not matter to first order, and
elsewhere this is how OpenSim's moment arms come about. All places are measured from the joint of one body, along
world axes, so that no large numbers are subtracted.

Functions that are given the model have to be inlined: else all of it would lie in memory of the lane's own.
"""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.coordinate_joint import along_coordinate
from warpmuscle.kernels.follower import along_driver
from warpmuscle.kernels.joint_motion import cubic_rates, has_motion
from warpmuscle.kernels.kinematics import coordinate_quat
from warpmuscle.kernels.limits import ball_angles
from warpmuscle.kernels.path import (
    PathState,
    add_crossings,
    coordinate_gradient,
    offset_between,
    segment_moment_arm,
)
from warpmuscle.kernels.register_rows import rows_of
from warpmuscle.kernels.structs import BALL, ModelRef, RouteSpan, RouteWrap, ScratchRef, StateRef, at, whole
from warpmuscle.kernels.wrap_cylinder import AMONG_OTHERS, EXACT, IN_PLANE, cylinder_touch
from warpmuscle.kernels.wrap_ellipsoid import ellipsoid_touch
from warpmuscle.kernels.wrap_sphere import sphere_touch
from warpmuscle.kernels.wrap_torus import torus_touch
from warpmuscle.kernels.wrap_touch import BESIDE, FREE, INSIDE, THROUGH, Touch

CYLINDER, SPHERE, ELLIPSOID, TORUS = 0, 1, 2, 3
WRAP_BIT = 24  # of a stop on the first wrap of a route, in `Lever.beyond`; the points come before
NOWHERE = -1
ROUNDS = 8  # of a route with several surfaces, each going on where the one before ended ...
SETTLED = 5.0e-4  # m, by which the length then changes no more
SETTLED_EXACT = 1.0e-6
SHORTEST = 1.0e-9  # m, of a segment that has a direction


class RouteKind(NamedTuple):
    """What is compiled in for routes."""

    wraps: int = 0  # the most that one has
    levers: int = 0  # the same
    surfaces: tuple[int, ...] = ()  # CYLINDER ..., those that there are
    motions: int = 0  # the most that a point has
    conditions: bool = True  # whether some count only at times
    exact: bool = False  # whether routes around cylinders are the shortest ones, see `wrap_cylinder.py`


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


@wp.func
def always(instance: int, point: int, model: ModelRef, state: StateRef) -> bool:
    """What `sometimes` says where no point has a condition."""
    return True


@wp.func(inline=True)
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
        angle = ball_angles(coordinate_quat(state, instance, start), row.axis_a, row.axis_b)[axis]
        return angle >= interval[0] and angle <= interval[1]
    q = state.coordinates[instance, start + axis]
    return q >= interval[0] and q <= interval[1]


@wp.func(inline=True)
def motion_rates(instance: int, motion: int, model: ModelRef, state: StateRef) -> wp.vec3:
    """How far a point has moved along the axis of one of its motions, and the derivatives by the joint's coordinate."""
    plan = model.routes.motion[motion]
    q = state.coordinates[instance, model.skeleton.plan[plan.joint].coordinate_start]
    low = int(plan.first_piece)
    high = int(plan.end_piece)
    while high - low > 1:
        middle = (low + high) // 2
        if at(model.routes.piece, instance, middle).start <= q:
            low = middle
        else:
            high = middle
    piece = at(model.routes.piece, instance, low)
    return cubic_rates(piece.c, q - piece.start)


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
        plan = model.routes.point[whole(point)]
        local = at(model.routes.place, instance, point)
        if wp.static(motions > 0):
            for k in range(plan.first_motion, plan.end_motion):
                rates = motion_rates(instance, k, model, state)
                local += at(model.routes.motion_axis, instance, k) * rates[0]
                slopes.of = with_slope(slopes.of, k - plan.first_motion, rates[1])
        return work.rotation[whole(plan.body)] * local + offset_between(plan.body, origin, work)

    return place


@cache
def touch_of(surfaces: tuple[int, ...]) -> Any:
    """The Warp function of how a segment from a to b, in a surface's axes, goes round it.

    Args:
        surfaces: the kinds that there are.
    """
    cylinders, spheres, ellipsoids, tori = (kind in surfaces for kind in (CYLINDER, SPHERE, ELLIPSOID, TORUS))

    @wp.func
    def touch(a: wp.vec3, b: wp.vec3, wrap: RouteWrap, size: wp.vec3, where: int) -> Touch:
        result = Touch()
        if wp.static(cylinders) and wrap.kind == CYLINDER:
            result = cylinder_touch(a, b, size[0], size[1], wrap.axis, wrap.side, where)
        if wp.static(spheres) and wrap.kind == SPHERE:
            result = sphere_touch(a, b, size[0], wrap.axis, wrap.side)
        if wp.static(ellipsoids) and wrap.kind == ELLIPSOID:
            result = ellipsoid_touch(a, b, size, wrap.axis, wrap.side, wrap.method)
        if wp.static(tori) and wrap.kind == TORUS:
            result = torus_touch(a, b, size[0], size[1], wrap.axis, wrap.side, where)
        return result

    return touch


@cache
def pulls_of(count: int) -> Any:
    """The structure of the moment arms of a route by lever, with room for so many.

    A lane keeps them to itself until they are whole, which takes less time than to add up those of the working set.
    """

    @wp.struct
    class Pulls:
        arm: wp.types.matrix(shape=(count, 3), dtype=float)  # m, world

    return Pulls


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


@cache
def bend_of(kind: RouteKind) -> Any:
    """The Warp function that lets a route go round one of its surfaces, where that is best.

    Its result is what the route's last segment does there, see `wrap_touch.py`.
    """
    count = max(kind.wraps, 1)
    bends_struct, bend_after = bends_of(count), bend_after_of(count)
    counts, slopes_struct = sometimes if kind.conditions else always, slopes_of(max(kind.motions, 1))
    place, touch_at, exact, rows = place_of(kind.motions), touch_of(kind.surfaces), kind.exact, rows_of(count)
    row, with_row, with_number, with_length = rows.row, rows.with_row, rows.with_number, rows.with_length

    @wp.func(inline=True)
    def bend(
        instance: int,
        w: int,
        span: RouteSpan,
        bends: wp.ref[bends_struct],
        model: ModelRef,
        state: StateRef,
        work: ScratchRef,
    ) -> int:
        routes = model.routes
        slopes = slopes_struct()
        first_point = span.first_point
        origin = span.origin
        wraps = span.end_wrap - span.first_wrap
        wrap = routes.wrap[whole(span.first_wrap + w)]
        own = at(routes.wrap_row, instance, span.first_wrap + w)
        body = work.rotation[whole(wrap.body)]
        center = body * own.position + offset_between(wrap.body, origin, work)
        axes = body * own.rotation
        last = int(wrap.last)
        while last > wrap.first and not counts(instance, first_point + last, model, state):
            last -= 1
        stop = int(wrap.first)
        while stop < last and not counts(instance, first_point + stop, model, state):
            stop += 1
        point = int(stop)
        here = wp.transpose(axes) * (place(instance, first_point + stop, origin, model, state, work, slopes) - center)
        from_surface = int(NOWHERE)
        result = int(FREE)
        where = int(EXACT)
        if wp.static(not exact):
            where = wp.where(wraps > 1, AMONG_OTHERS, IN_PLANE)
        best = wp.float32(1.0e30)
        found = int(NOWHERE)
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
                while not counts(instance, first_point + point, model, state):
                    point += 1
                reached = place(instance, first_point + point, origin, model, state, work, slopes)
                there = wp.transpose(axes) * (reached - center)
            if from_surface == NOWHERE or from_surface != to_surface:
                touch = touch_at(here, there, wrap, own.size, where)
                result = touch.kind
                if result >= BESIDE:
                    detour = (
                        wp.length(touch.first - here) + touch.arc + wp.length(there - touch.second)
                        - wp.length(there - here)
                    )  # fmt: skip
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


@cache
def walk_of(kind: RouteKind, acting: bool, coordinate_joints: bool = False, followers: bool = False) -> Any:
    """The Warp function that walks along a route and gives its length, m, but for what is fixed of it.

    Args:
        acting: whether it gives the moment arms, too. coordinate_joints, followers: as of
            `path.segments_stretch_of`.
    """
    count = max(kind.wraps, 1)
    bends_struct, bend_after, place = bends_of(count), bend_after_of(count), place_of(kind.motions)
    counts, slopes_struct = sometimes if kind.conditions else always, slopes_of(max(kind.motions, 1))
    motions, slope_of = kind.motions > 0, rows_of(max(kind.motions, 1)).length
    wrapping, pulls_struct = kind.wraps > 0, pulls_of(max(kind.levers, 1))
    rows, with_sum = rows_of(count), rows_of(max(kind.levers, 1)).with_sum
    row, number, arc_of = rows.row, rows.number, rows.length

    @wp.func(inline=True)
    def act(
        instance: int, span: RouteSpan, a: wp.vec3, direction: wp.vec3, before: int, stop: int,
        model: ModelRef, work: ScratchRef, pulls: wp.ref[pulls_struct],
    ):  # fmt: skip
        """Add the moment arms of the segment from one stop to the next."""
        for k in range(span.first_lever, span.end_lever):
            lever = model.routes.lever[whole(k)]
            sign = ((lever.beyond >> stop) & 1) - ((lever.beyond >> before) & 1)
            if sign != 0:
                pull = direction * float(sign)
                joint = whole(lever.joint)
                r = segment_moment_arm(a, offset_between(joint, span.origin, work), pull)
                if wp.static(followers):
                    if has_motion(model.skeleton.plan[joint].joint_type):
                        r = along_driver(instance, joint, r, pull, model, work)
                elif wp.static(coordinate_joints) and has_motion(model.skeleton.plan[joint].joint_type):
                    r = along_coordinate(instance, joint, r, pull, model, work)
                pulls.arm = with_sum(pulls.arm, k - span.first_lever, r)

    @wp.func(inline=True)
    def act_on_motions(
        instance: int, point: int, pull: wp.vec3, slopes: slopes_struct, model: ModelRef, work: ScratchRef,
        arm: wp.array[wp.vec3],
    ):  # fmt: skip
        """Add the moment arms of a point's motions, which it makes longer along `pull`."""
        plan = model.routes.point[point]
        for k in range(plan.first_motion, plan.end_motion):
            motion = model.routes.motion[k]
            axis = work.rotation[whole(plan.body)] * at(model.routes.motion_axis, instance, k)
            rate = wp.dot(pull, axis) * slope_of(slopes.of, k - plan.first_motion)
            r = coordinate_gradient(instance, motion.joint, 0, model, work) * rate
            arm[motion.crossing] = arm[motion.crossing] + r

    @wp.func(inline=True)
    def walk(
        instance: int,
        span: RouteSpan,
        bends: wp.ref[bends_struct],
        model: ModelRef,
        state: StateRef,
        work: ScratchRef,
        pulls: wp.ref[pulls_struct],
        arm: wp.array[wp.vec3],
    ) -> float:
        total = wp.float32(0.0)
        slopes = slopes_struct()
        slopes_before = slopes_struct()
        a = wp.vec3(0.0)
        before = int(NOWHERE)
        wraps = span.end_wrap - span.first_wrap
        points = span.end_point - span.first_point
        next_point = wp.int32(0)
        onto = int(NOWHERE)
        while next_point < points or onto >= 0:
            b = wp.vec3(0.0)
            stop = int(next_point)
            fixed = wp.int32(0)
            if onto >= 0:
                b = row(bends.first, onto)
                if wp.static(count > 1) and number(bends.kept, onto) == 1:
                    b = row(bends.kept_first, onto)
                stop = WRAP_BIT + onto
            else:
                next_point += 1
                if not counts(instance, span.first_point + stop, model, state):
                    continue
                b = place(instance, span.first_point + stop, span.origin, model, state, work, slopes)
                fixed = model.routes.point[span.first_point + stop].fixed
            if before != NOWHERE and fixed == 0:
                d = b - a
                length = wp.length(d)
                total += length
                if wp.static(acting):
                    direction = d * (1.0 / wp.max(length, SHORTEST))
                    act(instance, span, a, direction, before, stop, model, work, pulls)
                    if wp.static(motions):
                        if stop < WRAP_BIT:
                            act_on_motions(instance, span.first_point + stop, direction, slopes, model, work, arm)
                        if before < WRAP_BIT:
                            act_on_motions(
                                instance, span.first_point + before, -direction, slopes_before, model, work, arm
                            )
            a = b
            before = stop
            slopes_before.of = slopes.of
            if wp.static(wrapping):
                if onto >= 0:
                    total += arc_of(bends.arc, onto)
                    a = row(bends.second, onto)
                    if wp.static(count > 1) and number(bends.kept, onto) == 1:
                        a = row(bends.kept_second, onto)
                onto = bend_after(stop, wraps, bends.after)
        return total

    return walk


@cache
def route_stretch_of(kind: RouteKind, coordinate_joints: bool = False, followers: bool = False) -> Any:
    """The Warp function of length and speed of a route and its moment arms, see `path.segments_stretch_of`.

    Args:
        kind: what is compiled in.
    """
    bends_struct, bend, pulls_struct = bends_of(max(kind.wraps, 1)), bend_of(kind), pulls_of(max(kind.levers, 1))
    measure, walk = walk_of(kind, False), walk_of(kind, True, coordinate_joints, followers)
    exact, several, count = kind.exact, kind.wraps > 1, max(kind.wraps, 1)
    settled = SETTLED_EXACT if kind.exact else SETTLED
    rows, lever_arm = rows_of(count), rows_of(max(kind.levers, 1)).row
    row, with_row, number, with_number = rows.row, rows.with_row, rows.number, rows.with_number

    @wp.func
    def remove(w: int, wraps: int, bends: wp.ref[bends_struct]):
        """Let a route run straight past a surface."""
        before = number(bends.after, w)
        for other in range(count):
            if other < wraps and number(bends.after, other) == WRAP_BIT + w:
                bends.after = with_number(bends.after, other, before)
        bends.after = with_number(bends.after, w, NOWHERE)

    @wp.func(inline=True)
    def settle(
        instance: int,
        span: RouteSpan,
        bends: wp.ref[bends_struct],
        model: ModelRef,
        state: StateRef,
        work: ScratchRef,
        pulls: wp.ref[pulls_struct],
        arm: wp.array[wp.vec3],
    ):
        """Go round several surfaces in turn until none has moved since it was last gone round, or the length stays."""
        wraps = span.end_wrap - span.first_wrap
        before = wp.float32(1.0e30)
        swapped = wp.int32(0)
        still = wp.int32(0)  # surfaces that the route last did not touch, neither before nor after
        for turn in range(ROUNDS):
            one = int(FREE)
            other = int(FREE)
            for k in range(wraps):
                w = int(k)
                if swapped == 1 and k < 2:
                    w = 1 - k
                if turn == 0 or still < wraps - 1:
                    touched = number(bends.after, w) != NOWHERE
                    remove(w, wraps, bends)
                    result = bend(instance, w, span, bends, model, state, work)
                    touches = number(bends.after, w) != NOWHERE
                    still = wp.where(touched or touches, 0, still + 1)
                    if wp.static(not exact) and wraps > 1 and touches and number(bends.kept, w) == 0:
                        bends.kept = with_number(bends.kept, w, 1)
                        bends.kept_first = with_row(bends.kept_first, w, row(bends.first, w))
                        bends.kept_second = with_row(bends.kept_second, w, row(bends.second, w))
                    if k == 0:
                        one = result
                    if k == 1:
                        other = result
            if turn == 0 and one == FREE and other == INSIDE:
                swapped = 1
                still = 0
                remove(0, wraps, bends)
            if still >= wraps - 1:
                break
            length = measure(instance, span, bends, model, state, work, pulls, arm)
            if wp.abs(length - before) < settled:
                break
            before = length

    @wp.func(inline=True)
    def route_stretch(
        instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef, arm: wp.array[wp.vec3]
    ) -> PathState:
        span = model.routes.span[muscle]
        own = model.paths.span[muscle]
        bends = bends_struct()
        pulls = pulls_struct()
        wraps = span.end_wrap - span.first_wrap
        for w in range(count):
            bends.after = with_number(bends.after, w, NOWHERE)
        for k in range(own.first_crossing, own.end_crossing):
            arm[whole(model.paths.of_muscle[whole(k)].number)] = wp.vec3(0.0)
        if wp.static(several):
            if wraps > 0:
                settle(instance, span, bends, model, state, work, pulls, arm)
        elif wraps == 1:
            bend(instance, 0, span, bends, model, state, work)
        total = PathState()
        total.fixed = at(model.paths.fixed_length, instance, muscle)
        total.moving = walk(instance, span, bends, model, state, work, pulls, arm)
        for k in range(span.first_lever, span.end_lever):
            crossing_of = whole(model.routes.lever[whole(k)].crossing)
            arm[crossing_of] = arm[crossing_of] + lever_arm(pulls.arm, k - span.first_lever)
        add_crossings(total, muscle, model, work, arm)
        return total

    return route_stretch
