"""The moment arms of a route, lever by lever: what each segment of a walk along it adds.

Pulls at both ends of a segment that runs between places of the first round and pulls at those of the last are not on
one line: they turn bodies that carry both, too, which a lever of an OpenSim route may ask for. OpenSim leaves out of
moment arms what a point's motion does to a segment within one body, which may be asked for.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.body.coordinate_joint import coordinate_axis, effort_on, group_effort
from warpmuscle.kernels.body.follower import driver_of
from warpmuscle.kernels.body.joint_motion import has_motion
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.main_memory import rotation_of
from warpmuscle.kernels.memory.register_rows import RowsOf, rows_in, rows_of
from warpmuscle.kernels.path.conditions import coordinate_gradient
from warpmuscle.kernels.path.path import offset_between, segment_moment_arm
from warpmuscle.kernels.path.route_bends import LEVER_BITS, WRAP_BIT, RouteKind
from warpmuscle.kernels.path.route_points import slopes_of
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
    apart, couples, groups = kind.wraps > 1 and not kind.exact, kind.slips, kind.groups
    effort_of = group_effort if groups else None

    @wp.func(inline=True)
    def act_on_lever(
        instance: int, k: int, sign: int, span: RouteSpan, a: wp.vec3, left: wp.vec3, reached: wp.vec3,
        direction: wp.vec3, model: ModelRef, state: StateRef, work: ScratchRef, pulls: wp.ref[pulls_struct],
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
            elif wp.static(coordinate_joints):
                if wp.static(groups):
                    if has_motion(model.skeleton.plan[joint].joint_type):
                        group = model.routes.lever[nonnegative(span.first_lever + k)].group
                        r = wp.vec3(effort_of(instance, joint, group, r, pull, state, work), 0.0, 0.0)
                elif has_motion(model.skeleton.plan[joint].joint_type):
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
        instance: int, span: RouteSpan, a: wp.vec3, left: wp.vec3, reached: wp.vec3, direction: wp.vec3, before: int,
        stop: int, behind: int, beyond: int, across: bool, model: ModelRef, state: StateRef, work: ScratchRef,
        pulls: wp.ref[pulls_struct],
    ):  # fmt: skip
        if wp.static(many):
            taken = int(beyond ^ behind)
            if wp.static(couples) and across:
                taken = taken | beyond
            while taken != 0:
                k = lowest_bit(taken)
                taken = taken & (taken - 1)
                sign = ((beyond >> k) & 1) - ((behind >> k) & 1)
                act_on_lever(instance, k, sign, span, a, left, reached, direction, model, state, work, pulls)
        if wp.static(more):
            for k in range(rest, span.end_lever - span.first_lever):
                bits = model.routes.lever[nonnegative(span.first_lever + k)].beyond
                sign = ((bits >> stop) & 1) - ((bits >> before) & 1)
                couple = False
                if wp.static(couples):
                    couple = across and (bits >> stop) & 1 == 1
                if sign != 0 or couple:
                    act_on_lever(instance, k, sign, span, a, left, reached, direction, model, state, work, pulls)

    return act


@cache
def lever_arm_of(coordinate_joints: bool, followers: bool) -> Any:
    """The Warp function of the moment arm that levers have gathered: of a coordinate, along its axis.

    Args: as of `walk_of`.
    """

    @wp.func(inline=True)
    def lever_arm(instance: int, joint: int, gathered: wp.vec3, model: ModelRef, work: ScratchRef) -> wp.vec3:
        r = gathered
        if wp.static(coordinate_joints):  # noqa: SIM102, as above
            if has_motion(model.skeleton.plan[joint].joint_type):
                driver = int(joint)
                if wp.static(followers):
                    driver = driver_of(joint, model)
                r = coordinate_axis(instance, driver, model, work) * gathered[0]
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
            axis = rotation_of(nonnegative(plan.body), work) * at(model.routes.motion_axis, instance, k)
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
