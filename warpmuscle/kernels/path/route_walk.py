"""A walk along a route, from stop to stop: its length, and its moment arms.

OpenSim's path round several surfaces has two places where it reaches or leaves each: segments run between those of the
first round, and pull at those of the last. A smooth route does so, too, and has OpenSim's moment arms. Pulls at both
ends of such a segment are not on one line: they turn bodies that carry both, too, which a lever of an OpenSim route may
ask for. Its speed is not that of its moment arms then, see `route_slip.py`. OpenSim leaves out of moment arms what a
point's motion does to a segment within one body, which may be asked for.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.body.coordinate_joint import coordinate_axis, effort_on
from warpmuscle.kernels.body.follower import driver_of
from warpmuscle.kernels.body.joint_motion import has_motion
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.register_rows import RowsOf, rows_in, rows_of
from warpmuscle.kernels.path.path import coordinate_gradient, offset_between, segment_moment_arm
from warpmuscle.kernels.path.route_bends import (
    LEVER_BITS,
    NOWHERE,
    WRAP_BIT,
    RouteKind,
    bend_after_of,
    bend_rows_of,
    bends_of,
)
from warpmuscle.kernels.path.route_points import always, place_of, placed_of, placed_points_of, slopes_of, sometimes
from warpmuscle.kernels.path.route_slip import SHORTEST, slip
from warpmuscle.kernels.structs import ModelRef, RouteSpan, ScratchRef, StateRef, at, nonnegative


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
def pull_rows_of(kind: RouteKind, count: int) -> RowsOf:
    """Warp functions on its rows, of routes of a kind."""
    return rows_in(pulls_of(count), "arm", count, 1 if kind.in_rounds else count)


def room_of(kind: RouteKind, wrench: bool) -> int:
    """Rows of moment arms of a route: one a lever, and with a `wrench` one more for its direction; one for its slip."""
    return max(kind.levers, 1) * (2 if wrench else 1) + int(kind.slips and not wrench)


@wp.func_native(
    snippet="""
#if defined(__CUDA_ARCH__)
return __ffs(bits) - 1;
#else
return __builtin_ctz(unsigned(bits));
#endif
"""
)
def lowest_bit(bits: int) -> int: ...  # its number; there has to be one


@func(inline=True)
def levers_beyond(span: RouteSpan, stop: int, wrap: int, model: ModelRef) -> int:
    """The levers that a stop is beyond, a bit each: a point of the route or where it reaches this surface."""
    if stop < WRAP_BIT:
        return model.routes.point[nonnegative(span.first_point + stop)].levers
    return model.routes.wrap[nonnegative(span.first_wrap + wrap)].levers


@func(inline=True)
def no_levers(span: RouteSpan, stop: int, wrap: int, model: ModelRef) -> int:
    """The same of a walk that does not ask."""
    return 0


def levers_of_stops(kind: RouteKind, acting: bool) -> Any:
    """The one of both for a walk that adds moment arms by bits of levers, or does not."""
    return levers_beyond if acting and kind.many_levers else no_levers


@cache
def act_on_lever_of(kind: RouteKind, coordinate_joints: bool, wrench: bool) -> Any:
    """The Warp function that adds what a segment does to lever k of its route, where it begins or ends beyond that.

    Its `sign` is 1 where the segment ends there, -1 where it begins there, and 0 where it does both, but runs from one
    body to another: then the lever feels the couple of the pulls at its ends. Else see `act_of`.
    """
    levers = room_of(kind, wrench)
    add_arm, pulls_struct = pull_rows_of(kind, levers).add, pulls_of(levers)
    apart, couples = kind.wraps > 1 and not kind.exact, kind.slips

    @wp.func(inline=True)
    def act_on_lever(
        k: int, sign: int, span: RouteSpan, a: wp.vec3, left: wp.vec3, reached: wp.vec3, direction: wp.vec3,
        model: ModelRef, work: ScratchRef, pulls: wp.ref[pulls_struct],
    ):  # fmt: skip
        joint = nonnegative(model.routes.lever[nonnegative(span.first_lever + k)].joint)
        if wp.static(not couples) or sign != 0:
            pull = direction * float(sign)
            place_of_pull = a
            if wp.static(apart):
                place_of_pull = wp.where(sign > 0, reached, left)
            r = segment_moment_arm(place_of_pull, offset_between(joint, span.origin, work), pull)
            if wp.static(wrench):
                add_arm(pulls, k + wp.static(levers // 2), pull)
            elif wp.static(coordinate_joints):  # noqa: SIM102, with `and` it would be compiled in all the same
                if has_motion(model.skeleton.plan[joint].joint_type):
                    r = wp.vec3(effort_on(joint, r, pull, work), 0.0, 0.0)
            add_arm(pulls, k, r)
        elif wp.static(couples):
            r = wp.cross(reached - left, direction)
            if wp.static(coordinate_joints and not wrench):  # noqa: SIM102, as above
                if has_motion(model.skeleton.plan[joint].joint_type):
                    r = wp.vec3(effort_on(joint, r, wp.vec3(0.0), work), 0.0, 0.0)
            add_arm(pulls, k, r)

    return act_on_lever


@cache
def act_of(kind: RouteKind, coordinate_joints: bool, wrench: bool) -> Any:
    """The Warp function that adds the moment arms of the segment from a stop, at `a`, to the next one.

    It pulls at `left` and `reached`; a lever that carries both feels their couple if the segment runs `across` from one
    body to another. Of a joint of one coordinate it adds up what acts on that, see `lever_arm_of`. Most segments are
    beyond few of many levers, or none: so these are taken by their bits, `behind` of the stop before and `beyond` of
    the next one, see `levers_beyond`. What is compiled in is that of `walk_of`.
    """
    act_on_lever, pulls_struct = act_on_lever_of(kind, coordinate_joints, wrench), pulls_of(room_of(kind, wrench))
    couples, many, more = kind.slips, kind.many_levers, not kind.many_levers or kind.levers > LEVER_BITS
    rest = LEVER_BITS if many else 0

    @wp.func(inline=True)
    def act(
        span: RouteSpan, a: wp.vec3, left: wp.vec3, reached: wp.vec3, direction: wp.vec3, before: int, stop: int,
        behind: int, beyond: int, across: bool, model: ModelRef, work: ScratchRef, pulls: wp.ref[pulls_struct],
    ):  # fmt: skip
        if wp.static(many):
            taken = int(beyond ^ behind)
            if wp.static(couples) and across:
                taken = taken | beyond
            while taken != 0:
                k = lowest_bit(taken)
                taken = taken & (taken - 1)
                sign = ((beyond >> k) & 1) - ((behind >> k) & 1)
                act_on_lever(k, sign, span, a, left, reached, direction, model, work, pulls)
        if wp.static(more):
            for k in range(rest, span.end_lever - span.first_lever):
                bits = model.routes.lever[nonnegative(span.first_lever + k)].beyond
                sign = ((bits >> stop) & 1) - ((bits >> before) & 1)
                couple = False
                if wp.static(couples):
                    couple = across and (bits >> stop) & 1 == 1
                if sign != 0 or couple:
                    act_on_lever(k, sign, span, a, left, reached, direction, model, work, pulls)

    return act


@cache
def lever_arm_of(kind: RouteKind, levers: int, coordinate_joints: bool, followers: bool) -> Any:
    """The Warp function of the moment arm that a lever has gathered: of a coordinate, along its axis.

    Args:
        kind, levers: of the route, and rows that there are. coordinate_joints, followers: as of `walk_of`.
    """
    arm_at, pulls_struct = pull_rows_of(kind, levers).get, pulls_of(levers)

    @wp.func(inline=True)
    def lever_arm(
        instance: int, joint: int, k: int, pulls: wp.ref[pulls_struct], model: ModelRef, work: ScratchRef
    ) -> wp.vec3:
        r = arm_at(pulls, k)
        if wp.static(coordinate_joints):  # noqa: SIM102, as above
            if has_motion(model.skeleton.plan[joint].joint_type):
                driver = int(joint)
                if wp.static(followers):
                    driver = driver_of(joint, model)
                r = coordinate_axis(instance, driver, model, work) * r[0]
        return r

    return lever_arm


@cache
def act_on_motions_of(motions: int) -> Any:
    """The Warp function that adds the moment arms of a point's motions, which it makes longer along `pull`."""
    slopes_struct, slope_of = slopes_of(max(motions, 1)), rows_of(max(motions, 1)).length

    @wp.func(inline=True)
    def act_on_motions(
        instance: int, point: int, pull: wp.vec3, slopes: slopes_struct, model: ModelRef, work: ScratchRef,
        arm: wp.array[wp.vec3],
    ):  # fmt: skip
        plan = model.routes.point[point]
        for k in range(plan.first_motion, plan.end_motion):
            motion = model.routes.motion[k]
            axis = work.rotation[nonnegative(plan.body)] * at(model.routes.motion_axis, instance, k)
            rate = wp.dot(pull, axis) * slope_of(slopes.of, k - plan.first_motion)
            r = coordinate_gradient(instance, motion.joint, 0, model, work) * rate
            arm[motion.crossing] = arm[motion.crossing] + r

    return act_on_motions


@cache
def act_on_ends_of(motions: int) -> Any:
    """The Warp function that does so at both ends of a segment, as far as they are points of the route."""
    slopes_struct, act_on_motions = slopes_of(max(motions, 1)), act_on_motions_of(motions)

    @wp.func(inline=True)
    def act_on_ends(
        instance: int, span: RouteSpan, before: int, stop: int, pull: wp.vec3, slopes_before: slopes_struct,
        slopes: slopes_struct, model: ModelRef, work: ScratchRef, arm: wp.array[wp.vec3],
    ):  # fmt: skip
        if stop < WRAP_BIT:
            act_on_motions(instance, span.first_point + stop, pull, slopes, model, work, arm)
        if before < WRAP_BIT:
            act_on_motions(instance, span.first_point + before, -pull, slopes_before, model, work, arm)

    return act_on_ends


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
    placed_struct, points = placed_of(room), placed_points_of(room, kind.motions, kind.conditions)
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
    count, placed_struct = max(kind.wraps, 1), placed_of(max(kind.places, 1))
    bends_struct, bend_after = bends_of(count), bend_after_of(count)
    motions, wrapping, across = kind.motions > 0 and not wrench, kind.wraps > 0, kind.across
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
                    act(span, a, left, reached, direction, before, stop, behind, beyond, between, model, work, pulls)
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
