"""A walk along a route, from stop to stop: its length, and its moment arms.

OpenSim's path round several surfaces has two places where it reaches or leaves each: segments run between those of the
first round, and pull at those of the last. A smooth route does so, too, and has OpenSim's moment arms. OpenSim leaves
out of these what a point's motion does to a segment within one body, which may be asked for.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.body.coordinate_joint import along_coordinate
from warpmuscle.kernels.body.follower import along_driver
from warpmuscle.kernels.body.joint_motion import has_motion
from warpmuscle.kernels.memory.register_rows import rows_of
from warpmuscle.kernels.path.path import coordinate_gradient, offset_between, segment_moment_arm
from warpmuscle.kernels.path.route_bends import NOWHERE, WRAP_BIT, RouteKind, bend_after_of, bends_of
from warpmuscle.kernels.path.route_points import always, place_of, slopes_of, sometimes
from warpmuscle.kernels.structs import ModelRef, RouteSpan, ScratchRef, StateRef, at, whole

SHORTEST = 1.0e-9  # m, of a segment that has a direction


@cache
def pulls_of(count: int) -> Any:
    """The structure of the moment arms of a route by lever, with room for so many.

    A lane keeps them to itself until they are whole, which takes less time than to add up those of the working set.
    """

    @wp.struct
    class Pulls:
        arm: wp.types.matrix(shape=(count, 3), dtype=float)  # m, world

    return Pulls


def room_of(kind: RouteKind, wrench: bool) -> int:
    """Rows of moment arms of a route: one a lever, and with a `wrench` one more for its direction."""
    return max(kind.levers, 1) * (2 if wrench else 1)


@cache
def act_of(kind: RouteKind, coordinate_joints: bool, followers: bool, wrench: bool) -> Any:
    """The Warp function that adds the moment arms of the segment from a stop, at `a`, to the next one.

    It pulls at `left` and `reached`. What is compiled in is that of `walk_of`.
    """
    levers = room_of(kind, wrench)
    with_sum, pulls_struct = rows_of(levers).with_sum, pulls_of(levers)
    apart = kind.smooth and kind.wraps > 1 and not kind.exact

    @wp.func(inline=True)
    def act(
        instance: int, span: RouteSpan, a: wp.vec3, left: wp.vec3, reached: wp.vec3, direction: wp.vec3, before: int,
        stop: int, model: ModelRef, work: ScratchRef, pulls: wp.ref[pulls_struct],
    ):  # fmt: skip
        for k in range(span.first_lever, span.end_lever):
            lever = model.routes.lever[whole(k)]
            sign = ((lever.beyond >> stop) & 1) - ((lever.beyond >> before) & 1)
            if sign != 0:
                pull = direction * float(sign)
                joint = whole(lever.joint)
                place_of_pull = a
                if wp.static(apart):
                    place_of_pull = wp.where(sign > 0, reached, left)
                r = segment_moment_arm(place_of_pull, offset_between(joint, span.origin, work), pull)
                if wp.static(wrench):
                    pulls.arm = with_sum(pulls.arm, k - span.first_lever + wp.static(levers // 2), pull)
                elif wp.static(followers):
                    if has_motion(model.skeleton.plan[joint].joint_type):
                        r = along_driver(instance, joint, r, pull, model, work)
                elif wp.static(coordinate_joints) and has_motion(model.skeleton.plan[joint].joint_type):
                    r = along_coordinate(instance, joint, r, pull, model, work)
                pulls.arm = with_sum(pulls.arm, k - span.first_lever, r)

    return act


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
            axis = work.rotation[whole(plan.body)] * at(model.routes.motion_axis, instance, k)
            rate = wp.dot(pull, axis) * slope_of(slopes.of, k - plan.first_motion)
            r = coordinate_gradient(instance, motion.joint, 0, model, work) * rate
            arm[motion.crossing] = arm[motion.crossing] + r

    return act_on_motions


@cache
def walk_of(
    kind: RouteKind, acting: bool, coordinate_joints: bool = False, followers: bool = False, wrench: bool = False
) -> Any:
    """The Warp function that walks along a route and gives its length, m, but for what is fixed of it.

    Args:
        acting: whether it gives the moment arms, too. coordinate_joints, followers, wrench: as of
            `path.segments_stretch_of`; directions are in rows behind those of the moments.
    """
    count = max(kind.wraps, 1)
    bends_struct, bend_after, place = bends_of(count), bend_after_of(count), place_of(kind.motions)
    counts, slopes_struct = sometimes if kind.conditions else always, slopes_of(max(kind.motions, 1))
    within_bodies = not kind.across
    motions, wrapping, branches = kind.motions > 0 and not wrench, kind.wraps > 0, kind.branches
    act, act_on_motions = act_of(kind, coordinate_joints, followers, wrench), act_on_motions_of(kind.motions)
    pulls_struct, rows = pulls_of(room_of(kind, wrench)), rows_of(count)
    row, number, arc_of = rows.row, rows.number, rows.length

    @wp.func(inline=True)
    def walk(
        instance: int, span: RouteSpan, bends: wp.ref[bends_struct], model: ModelRef, state: StateRef, work: ScratchRef,
        pulls: wp.ref[pulls_struct], arm: wp.array[wp.vec3],
    ) -> float:  # fmt: skip
        total = wp.float32(0.0)
        slopes = slopes_struct()
        slopes_before = slopes_struct()
        a = wp.vec3(0.0)
        left = wp.vec3(0.0)
        before = int(NOWHERE)
        body_before = wp.int32(0)
        body = wp.int32(0)
        wraps = span.end_wrap - span.first_wrap
        points = span.end_point - span.first_point
        next_point = wp.int32(0)
        onto = int(NOWHERE)
        while next_point < points or onto >= 0:
            b = wp.vec3(0.0)
            stop = int(next_point)
            fixed = wp.int32(0)
            reached = wp.vec3(0.0)
            if onto >= 0:
                b = row(bends.first, onto)
                reached = b
                if wp.static(count > 1) and number(bends.kept, onto) == 1:
                    b = row(bends.kept_first, onto)
                stop = WRAP_BIT + onto
            else:
                next_point += 1
                if not counts(instance, span.first_point + stop, model, state):
                    continue
                b = place(instance, span.first_point + stop, span.origin, model, state, work, slopes)
                reached = b
                fixed = model.routes.point[span.first_point + stop].fixed
            if wp.static(motions and not within_bodies):
                if stop < WRAP_BIT:
                    body = model.routes.point[span.first_point + stop].body
                else:
                    body = model.routes.wrap[span.first_wrap + onto].body
            share = wp.float32(1.0)
            if wp.static(branches):
                to_point = wp.where(stop < WRAP_BIT, stop, next_point)
                share = at(model.routes.share, instance, span.first_point + to_point)
            if before != NOWHERE and fixed == 0:
                d = b - a
                length = wp.length(d)
                if wp.static(branches):
                    total += share * length
                else:
                    total += length
                if wp.static(acting):
                    direction = d * (1.0 / wp.max(length, SHORTEST))
                    if wp.static(branches):
                        direction *= share
                    act(instance, span, a, left, reached, direction, before, stop, model, work, pulls)
                    if wp.static(motions):
                        moves = bool(True)
                        if wp.static(not within_bodies):
                            moves = body != body_before
                        if moves and stop < WRAP_BIT:
                            act_on_motions(instance, span.first_point + stop, direction, slopes, model, work, arm)
                        if moves and before < WRAP_BIT:
                            act_on_motions(
                                instance, span.first_point + before, -direction, slopes_before, model, work, arm
                            )
            a = b
            left = reached
            before = stop
            if wp.static(motions and not within_bodies):
                body_before = body
            slopes_before.of = slopes.of
            if wp.static(wrapping):
                if onto >= 0:
                    if wp.static(branches):
                        total += share * arc_of(bends.arc, onto)
                    else:
                        total += arc_of(bends.arc, onto)
                    a = row(bends.second, onto)
                    left = a
                    if wp.static(count > 1) and number(bends.kept, onto) == 1:
                        a = row(bends.kept_second, onto)
                onto = bend_after(stop, wraps, bends.after)
        return total

    return walk
