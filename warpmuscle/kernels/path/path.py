"""Musculotendon paths: straight segments between via points that are fixed to bodies.

The length of a path is l = sum of w |b - a| over its segments, with w = 1 for a path of fixed points, and else a
weight that changes with joint angles, see `conditions.py`.

A moment arm is a vector r, world axes, with the torque F r on the joint's parent and -F r on its child; the path
lengthens at r . w with the angular velocity w of the child relative to the parent. (OpenSim's moment arm of a
coordinate, -dl/dq, is minus the component of r along its axis.)

A path on pulleys has no points: l = l_rest - sum of r_k (q_k - q_rest) with constant moment arms r_k of the joint
angles that it runs over (Cruz Ruiz 2015, eq. 3).
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.body.coordinate_joint import along_coordinate, coordinate_axis, effort_on, group_effort
from warpmuscle.kernels.body.follower import along_driver
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.main_memory import rotation_of
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.muscle.muscle_control import counted, wanted_force
from warpmuscle.kernels.muscle_structs import (
    BY_COORDINATE,
    END_BEYOND,
    FIRST_OF_CROSSING,
    GROUPS,
    IN_FIRST_SEGMENT,
    LAST_OF_CROSSING,
    LAST_OF_SEGMENT,
    START_BEYOND,
)
from warpmuscle.kernels.path.conditions import Weight, coordinate_gradient, segment_weight
from warpmuscle.kernels.structs import (
    Contribution,
    ModelRef,
    ScratchRef,
    Segment,
    StateRef,
    at,
    nonnegative,
    not_unrolled,
)

SHORTEST = 1.0e-9  # m, of a segment that has a direction


@wp.struct
class PathState:
    """Length and lengthening speed of a path. The parts of the length are kept apart for precision."""

    fixed: float  # m, of the segments within bodies
    moving: float  # m, of all others
    speed: float  # m/s
    wanted: wp.vec2  # N, what its joints want of the muscle, and the number of joints that count; see `counted`
    arm: wp.vec3  # m, the moment arm of a path that is straight
    crossing: int  # and which crossing it belongs to


@func
def segment_moment_arm(a: wp.vec3, joint: wp.vec3, direction: wp.vec3) -> wp.vec3:
    """Moment arm vector, m, of a segment from a on the joint's parent side to its child side: (a - joint) x direction.

    As in Bergmann 2017. All in world coordinates; for a segment the other way round it changes its sign.
    """
    return wp.cross(a - joint, direction)


@func
def offset_between(body: int, origin: int, work: ScratchRef) -> wp.vec3:
    """From the joint of the body `origin` to that of another one, world axes, m."""
    if body == origin:
        return wp.vec3(0.0)
    return work.position[nonnegative(body)] - work.position[nonnegative(origin)]


@func
def segment_end(end: wp.vec3, body: int, origin: int, far: int, work: ScratchRef) -> wp.vec3:
    """From the joint of the segment's origin to one of its ends, world axes, m.

    Args:
        end: in the axes of its body; from the joint of the origin, or if `far` from that of its body.
    """
    local = rotation_of(nonnegative(body), work) * end
    if far != 0:
        local += offset_between(body, origin, work)
    return local


@func
def joint_velocity(joint: int, model: ModelRef, work: ScratchRef) -> wp.vec3:
    """Angular velocity of a joint's child relative to its parent in the middle of the last step, world, rad/s."""
    parent = nonnegative(model.skeleton.plan[joint].parent)
    child = work.angular_velocity[joint] - work.lag_angular[joint]
    return child - work.angular_velocity[parent] + work.lag_angular[parent]


@func(inline=True)
def add_crossings(total: wp.ref[PathState], muscle: int, model: ModelRef, work: ScratchRef, arm: wp.array[wp.vec3]):
    """Add the speed of a path whose moment arms are known, and what its joints want of the muscle."""
    span = model.paths.span[muscle]
    for k in range(span.first_crossing, span.end_crossing):
        not_unrolled()
        crossing = model.paths.of_muscle[nonnegative(k)]
        r = arm[nonnegative(crossing.number)]
        total.speed += wp.dot(r, work.joint_velocity[nonnegative(crossing.joint)])
        total.wanted += counted(wanted_force(work.torque[nonnegative(crossing.joint)], r), model.muscles.negative)


@func
def joint_velocities(lane: int, lanes: int, model: ModelRef, work: ScratchRef):
    """Relative angular velocities of all joints into the working set. Ends with a barrier."""
    for body in range(1 + lane, model.body_count, lanes):
        not_unrolled()
        work.joint_velocity[body] = joint_velocity(body, model, work)
    synchronize()


@func
def give(
    total: wp.ref[PathState], own: Contribution, first: int, joint: int, r: wp.vec3, model: ModelRef, work: ScratchRef,
    arm: wp.array[wp.vec3],
):  # fmt: skip
    """Add a moment arm to that of a crossing, what it means for the speed, and in the end what the joint wants.

    Args:
        first: the mark that says whether nothing has been added before.
    """
    crossing = nonnegative(own.crossing)
    total.speed += wp.dot(r, work.joint_velocity[joint])
    whole = r
    if own.marks & first == 0:
        whole += arm[crossing]
    arm[crossing] = whole
    if own.marks & LAST_OF_CROSSING != 0:
        total.wanted += counted(wanted_force(work.torque[joint], whole), model.muscles.negative)


@func
def sign_of(own: Contribution) -> float:
    """1 where a segment ends beyond the joint, -1 where it starts there, else 0."""
    return float((own.marks & END_BEYOND) - ((own.marks & START_BEYOND) >> 1))


@func
def group_of(own: Contribution) -> int:
    """The group of joints by which a segment acts on a crossing; -1: one joint by itself."""
    return own.marks // GROUPS - 1


@cache
def add_wrenches_of(conditions: bool) -> Any:
    """`add_arms_of` where lines of action are asked for, see `segments_stretch_of`."""

    @wp.func(inline=True)
    def add_wrenches(
        instance: int, i: int, segment: Segment, a: wp.vec3, direction: wp.vec3, length: float,
        total: wp.ref[PathState], model: ModelRef, state: StateRef, work: ScratchRef, arm: wp.array[wp.vec3],
    ):  # fmt: skip
        weight = Weight()
        weight.value = 1.0
        if wp.static(conditions) and segment.varies != 0:
            weight = segment_weight(instance, i, 0, model, state, model.paths, work)
        for k in range(segment.first_contribution, segment.end_contribution):
            own = model.paths.contribution[nonnegative(k)]
            joint = nonnegative(own.joint)
            sign = sign_of(own)
            r = segment_moment_arm(a, offset_between(joint, segment.origin, work), direction) * sign
            pull = direction * (sign * weight.value)
            arm[joint] = arm[joint] + r * weight.value
            arm[model.body_count + joint] = arm[model.body_count + joint] + pull

    return add_wrenches


@cache
def add_gathered_arms_of(conditions: bool, groups: bool) -> Any:
    """`add_arms_of` where many joints follow one: what a segment does to all of a crossing is added as one moment arm.

    Which takes less time where they are many, and more where they are not.
    """
    effort_of = group_effort if groups else None

    @wp.func(inline=True)
    def add_arms(
        instance: int, i: int, segment: Segment, a: wp.vec3, direction: wp.vec3, length: float,
        total: wp.ref[PathState], model: ModelRef, state: StateRef, work: ScratchRef, arm: wp.array[wp.vec3],
    ):  # fmt: skip
        paths = model.paths
        weight = Weight()
        weight.value = 1.0
        gathered = wp.vec3(0.0)  # by joints that turn about an axis ...
        effort = wp.float32(0.0)  # ... and by those of one coordinate
        slope = wp.vec3(0.0)
        for k in range(segment.first_contribution, segment.end_contribution):
            own = paths.contribution[nonnegative(k)]
            joint = nonnegative(own.joint)
            sign = sign_of(own)
            r = segment_moment_arm(a, offset_between(joint, segment.origin, work), direction) * sign
            if own.marks & BY_COORDINATE != 0:
                if wp.static(groups):
                    effort += effort_of(instance, joint, group_of(own), r, direction * sign, state, work)
                else:
                    effort += effort_on(joint, r, direction * sign, work)
            else:
                gathered += r
            if wp.static(conditions) and segment.varies != 0:
                weight = segment_weight(instance, i, joint, model, state, paths, work)
                slope += weight.gradient * length
            if own.marks & LAST_OF_SEGMENT != 0:
                driver = nonnegative(own.driver)
                if own.marks & BY_COORDINATE != 0:
                    gathered += coordinate_axis(instance, driver, model, work) * effort
                if wp.static(conditions) and segment.varies != 0:
                    gathered = gathered * weight.value + slope
                give(total, own, IN_FIRST_SEGMENT, driver, gathered, model, work, arm)
                gathered = wp.vec3(0.0)
                effort = 0.0
                slope = wp.vec3(0.0)

    return add_arms


@cache
def add_arms_of(conditions: bool, coordinate_joints: bool, followers: bool, groups: bool) -> Any:
    """The Warp function that adds to moment arms, and to the speed, what a segment from `a` contributes to them.

    Args:
        conditions, coordinate_joints, followers, groups: see `segments_stretch_of`.
    """
    along = along_driver if followers else along_coordinate
    effort_of = group_effort if groups else None

    @wp.func(inline=True)
    def add_arms(
        instance: int, i: int, segment: Segment, a: wp.vec3, direction: wp.vec3, length: float,
        total: wp.ref[PathState], model: ModelRef, state: StateRef, work: ScratchRef, arm: wp.array[wp.vec3],
    ):  # fmt: skip
        paths = model.paths
        for k in range(segment.first_contribution, segment.end_contribution):
            own = paths.contribution[nonnegative(k)]
            joint = nonnegative(own.joint)
            sign = sign_of(own)
            r = segment_moment_arm(a, offset_between(joint, segment.origin, work), direction) * sign
            if wp.static(coordinate_joints or followers) and own.marks & BY_COORDINATE != 0:
                if wp.static(groups):
                    effort = effort_of(instance, joint, group_of(own), r, direction * sign, state, work)
                    r = coordinate_axis(instance, nonnegative(own.driver), model, work) * effort
                else:
                    r = along(instance, joint, r, direction * sign, model, work)
            if wp.static(conditions) and segment.varies != 0:
                weight = segment_weight(instance, i, joint, model, state, paths, work)
                r = r * weight.value + weight.gradient * length
            if wp.static(followers):
                joint = nonnegative(own.driver)
            give(total, own, FIRST_OF_CROSSING, joint, r, model, work, arm)

    return add_arms


@cache
def segments_stretch_of(
    conditions: bool, coordinate_joints: bool = False, followers: bool = False, wrench: bool = False,
    gathers: bool = False, groups: bool = False,
) -> Any:  # fmt: skip
    """The Warp function of length and lengthening speed of one muscle's path of segments, and of its moment arms.

    They follow from kinematics and joint velocities in the working set. What its joints want of the muscle follows from
    the torques there, if the controller's are.

    Args:
        conditions: whether there are conditional points.
        coordinate_joints: whether some joints are as in `coordinate_joint.py`.
        followers: whether some follow others: `Term.joint` may be one of them, which acts on the one that it follows.
        gathers: whether some segments act on a crossing by several joints, see `add_gathered_arms_of`.
        groups: whether some act on one by a group of joints, see `coordinate_joint.put_groups`.
        wrench: whether its last argument gets lines of action instead, (2 bodies,): at a joint's number the moment of
            a unit of tension about the joint, m, and behind those of all bodies its direction, upon the joint's parent.

    The function's last argument, (crossings,), gets the moment arm vectors of the muscle, m, world: a tension F puts
    the torque F r on the joint's parent and -F r on its child.
    """
    add = add_arms_of(conditions, coordinate_joints, followers, groups)
    if gathers:
        add = add_gathered_arms_of(conditions, groups)
    if wrench:
        add = add_wrenches_of(conditions)

    @wp.func
    def muscle_stretch(
        instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef, arm: wp.array[wp.vec3]
    ) -> PathState:
        paths = model.paths
        total = PathState()
        total.fixed = at(paths.fixed_length, instance, muscle)
        span = paths.span[muscle]
        for i in range(span.first_segment, span.end_segment):
            segment = paths.segment[nonnegative(i)]
            ends = at(paths.ends, instance, i)
            a = segment_end(ends.a, segment.body_a, segment.origin, segment.far, work)
            d = segment_end(ends.b, segment.body_b, segment.origin, segment.far, work) - a
            length = wp.length(d)
            direction = d * (1.0 / wp.max(length, SHORTEST))
            add(instance, i, segment, a, direction, length, total, model, state, work, arm)
            weight = Weight()
            weight.value = 1.0
            if wp.static(conditions) and segment.varies != 0:
                weight = segment_weight(instance, i, 0, model, state, paths, work)
            total.moving += length * weight.value
        return total

    return muscle_stretch


@func
def straight_stretch(
    instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef, arm: wp.array[wp.vec3]
) -> PathState:
    """What `segments_stretch_of` says, of a path that is straight; the moment arm is left to the caller."""
    path = model.paths.straight[muscle]
    ends = at(model.paths.ends, instance, muscle)
    joint = nonnegative(wp.max(path.body_a, path.body_b))
    a = rotation_of(nonnegative(path.body_a), work) * ends.a
    d = rotation_of(nonnegative(path.body_b), work) * ends.b - a
    length = wp.length(d)
    total = PathState()
    total.arm = wp.cross(a, d * (1.0 / wp.max(length, SHORTEST))) * float(path.sign)
    total.crossing = nonnegative(path.crossing)
    total.fixed = at(model.paths.fixed_length, instance, muscle)
    total.moving = length
    total.speed = wp.dot(total.arm, work.joint_velocity[joint])
    total.wanted = counted(wanted_force(work.torque[joint], total.arm), model.muscles.negative)
    return total


@func
def pulley_stretch(
    instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef, arm: wp.array[wp.vec3]
) -> PathState:
    """What `segments_stretch_of` says, of a path on pulleys."""
    paths = model.paths
    total = PathState()
    total.fixed = at(paths.fixed_length, instance, muscle)
    span = paths.span[muscle]
    for k in range(span.first_pulley, span.end_pulley):
        pulley = paths.pulley[k]
        own = at(paths.pulley_row, instance, k)
        angle = state.coordinates[instance, model.skeleton.plan[pulley.joint].coordinate_start + pulley.axis]
        total.moving -= own[0] * (angle - own[1])
        r = coordinate_gradient(instance, pulley.joint, pulley.axis, model, work) * -own[0]
        total.speed += wp.dot(r, work.joint_velocity[pulley.joint])
        if pulley.first == 0:
            r += arm[pulley.crossing]
        arm[pulley.crossing] = r
        if pulley.last != 0:
            total.wanted += counted(wanted_force(work.torque[pulley.joint], r), model.muscles.negative)
    return total


@cache
def stretch_of(
    pulleys: bool = True,
    conditions: bool = True,
    straight: bool = False,
    coordinate_joints: bool = False,
    followers: bool = False,
    wrench: bool = False,
    gathers: bool = False,
    groups: bool = False,
) -> Any:
    """The Warp function of the length and speed of a path, see `segments_stretch_of`.

    Args:
        pulleys: whether there are paths on pulleys. conditions: whether there are conditional points.
        straight: whether all paths are straight, see `structs.Straight`.
        coordinate_joints: whether some joints are as in `coordinate_joint.py`. followers: and some follow others.
        wrench, gathers, groups: see there; paths on pulleys have no lines of action.
    """
    if straight:
        return straight_stretch
    segments_stretch = segments_stretch_of(conditions, coordinate_joints, followers, wrench, gathers, groups)
    if not pulleys:
        return segments_stretch

    @wp.func
    def any_stretch(
        instance: int, muscle: int, model: ModelRef, state: StateRef, work: ScratchRef, arm: wp.array[wp.vec3]
    ) -> PathState:
        if model.paths.span[muscle].end_pulley > model.paths.span[muscle].first_pulley:
            return pulley_stretch(instance, muscle, model, state, work, arm)
        return segments_stretch(instance, muscle, model, state, work, arm)

    return any_stretch
