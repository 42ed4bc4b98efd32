"""Musculotendon paths: straight segments between via points that are fixed to bodies.

The length of a path is l = sum of w |b - a| over its segments, with w = 1 for a path of fixed points. A conditional
point counts only while a joint angle is within an interval: its weight p(q) goes smoothly from 1 to 0 at both ends.
Every pair of points with none but conditional points between them is then a segment, of weight

    w = p_a p_b (1 - p_k) (1 - p_m) ...    over the points k, m, ... that it leaves out,

so that with p = 0 the path runs past the point and with p = 1 through it. Length, lengthening speed and moment arms
are continuous, and the latter two are the exact derivatives of the former, changes of weight included: a tension does
the work that the path's shortening takes. That costs a moment arm of dp/dq times what the detour over the point
is longer, so blend slowly where a point makes a long detour.

A moment arm is a vector r, world axes, with the torque F r on the joint's parent and -F r on its child; the path
lengthens at r . w with the angular velocity w of the child relative to the parent. (OpenSim's moment arm of a
coordinate, -dl/dq, is minus the component of r along its axis.)

A path on pulleys has no points: l = l_rest - sum of r_k (q_k - q_rest) with constant moment arms r_k of the joint
angles that it runs over (Cruz Ruiz 2015, eq. 3).
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.lanes import synchronize
from warpmuscle.kernels.structs import UNIVERSAL, Model, Paths, State, Work, at

SHORTEST = 1.0e-9  # m, of a segment that has a direction


@wp.struct
class Weight:
    """How much a point or segment counts, and how that changes."""

    value: float  # 0..1
    rate: float  # 1/s
    gradient: wp.vec3  # by turns of one joint, world: times the joint's angular velocity it is a part of the rate


@wp.struct
class Stretch:
    """Length and lengthening speed of a path. The parts of the length are kept apart for precision."""

    fixed: float  # m, of the segments within bodies
    moving: float  # m, of all others
    speed: float  # m/s


@wp.func
def segment_moment_arm(a: wp.vec3, joint: wp.vec3, direction: wp.vec3) -> wp.vec3:
    """Moment arm vector, m, of a segment from a on the joint's parent side to its child side: (a - joint) x direction.

    As in Bergmann 2017. All in world coordinates; for a segment the other way round it changes its sign.
    """
    return wp.cross(a - joint, direction)


@wp.func
def smooth_step(x: float) -> wp.vec2:
    """3 t^2 - 2 t^3 with t = x clamped to 0..1, and its slope."""
    t = wp.clamp(x, 0.0, 1.0)
    return wp.vec2(t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t))


@wp.func
def condition_weight(angle: float, low: float, high: float, blend: float) -> wp.vec2:
    """Weight of a conditional point and its derivative by the angle: 1 within low..high, 0 outside, 1/2 at both ends.

    Args:
        blend: width of the transition about each end, rad.
    """
    rise = smooth_step((angle - low) / blend + 0.5)
    fall = smooth_step((high - angle) / blend + 0.5)
    return wp.vec2(rise[0] * fall[0], (rise[1] * fall[0] - rise[0] * fall[1]) / blend)


@wp.func
def both(a: Weight, b: Weight) -> Weight:
    """The product of two weights."""
    w = Weight()
    w.value = a.value * b.value
    w.rate = a.rate * b.value + a.value * b.rate
    w.gradient = a.gradient * b.value + b.gradient * a.value
    return w


@wp.func
def without(a: Weight) -> Weight:
    """1 minus a weight."""
    w = Weight()
    w.value = 1.0 - a.value
    w.rate = -a.rate
    w.gradient = -a.gradient
    return w


@wp.func
def coordinate_gradient(instance: int, joint: int, axis: int, model: Model, work: Work) -> wp.vec3:
    """World vector whose product with the angular velocity of a hinge or universal joint is a coordinate's speed."""
    a = work.rotation[joint] * at(model.skeleton.axis_a, instance, joint)
    if model.skeleton.joint_type[joint] != UNIVERSAL:
        return a
    b = work.rotation[model.skeleton.parent[joint]] * at(model.skeleton.axis_b, instance, joint)
    cosine = wp.dot(a, b)
    across = wp.where(axis == 0, a - b * cosine, b - a * cosine)
    return across / (1.0 - cosine * cosine)


@wp.func
def point_weight(instance: int, point: int, joint: int, model: Model, state: State, paths: Paths, work: Work) -> Weight:
    """How much a point counts; its gradient is by turns of the given joint."""
    w = Weight()
    w.value = 1.0
    condition = paths.point_condition[point]
    if condition < 0:
        return w
    on = paths.condition_joint[condition]
    axis = paths.condition_axis[condition]
    interval = at(paths.condition_interval, instance, condition)
    angle = state.coordinates[instance, model.skeleton.coordinate_start[on] + axis]
    weight = condition_weight(angle, interval[0], interval[1], interval[2])
    w.value = weight[0]
    w.rate = weight[1] * state.speeds[instance, model.skeleton.speed_start[on] + axis]
    if on == joint and weight[1] != 0.0:
        w.gradient = coordinate_gradient(instance, on, axis, model, work) * weight[1]
    return w


@wp.func
def segment_weight(
    instance: int, segment: int, joint: int, model: Model, state: State, paths: Paths, work: Work
) -> Weight:
    """How much a segment counts; its gradient is by turns of the given joint."""
    a = paths.segment[segment, 0]
    b = paths.segment[segment, 1]
    w = point_weight(instance, a, joint, model, state, paths, work)
    w = both(w, point_weight(instance, b, joint, model, state, paths, work))
    for left_out in range(a + 1, b):
        w = both(w, without(point_weight(instance, left_out, joint, model, state, paths, work)))
    return w


@wp.func
def offset_between(body: int, origin: int, work: Work) -> wp.vec3:
    """From the joint of the body `origin` to that of another one, world axes, m."""
    if body == origin:
        return wp.vec3(0.0)
    return work.position[body] - work.position[origin]


@wp.func
def segment_end(instance: int, segment: int, end: int, model: Model, work: Work) -> wp.vec3:
    """From the joint of the segment's origin to its end a (0) or b (1), world axes, m."""
    paths = model.paths
    body = paths.segment_body[segment, end]
    local = work.rotation[body] * at(paths.segment_end, instance, 2 * segment + end)
    if paths.segment_far[segment] != 0:
        local += offset_between(body, paths.segment_origin[segment], work)
    return local


@wp.func
def joint_velocity(joint: int, model: Model, work: Work) -> wp.vec3:
    """Angular velocity of a joint's child relative to its parent in the middle of the last step, world, rad/s."""
    parent = model.skeleton.parent[joint]
    child = work.angular_velocity[joint] - work.lag_angular[joint]
    return child - work.angular_velocity[parent] + work.lag_angular[parent]


@wp.func
def joint_velocities(lane: int, lanes: int, model: Model, work: Work):
    """Relative angular velocities of all joints into the working set. Ends with a barrier."""
    for body in range(1 + lane, model.body_count, lanes):
        work.joint_velocity[body] = joint_velocity(body, model, work)
    synchronize()


@wp.func
def muscle_stretch(
    instance: int, muscle: int, model: Model, state: State, work: Work, arm: wp.array2d[wp.vec3]
) -> Stretch:
    """Length and lengthening speed of one muscle's path, from kinematics and joint velocities in the working set.

    Args:
        arm: (instances, crossings) gets the moment arm vectors of the muscle, m, world: a tension F puts the torque
            F r on the joint's parent and -F r on its child.
    """
    paths = model.paths
    total = Stretch()
    total.fixed = at(paths.fixed_length, instance, muscle)
    for segment in range(paths.segment_start[muscle], paths.segment_start[muscle + 1]):
        varies = paths.segment_varies[segment]
        a = segment_end(instance, segment, 0, model, work)
        d = segment_end(instance, segment, 1, model, work) - a
        length = wp.length(d)
        direction = d * (1.0 / wp.max(length, SHORTEST))
        weight = Weight()
        weight.value = 1.0
        for term in range(paths.term_start[segment], paths.term_start[segment + 1]):
            crossing = paths.term_crossing[term]
            joint = paths.crossing_joint[crossing]
            center = offset_between(joint, paths.segment_origin[segment], work)
            r = segment_moment_arm(a, center, direction) * float(paths.term_sign[term])
            if varies != 0:
                weight = segment_weight(instance, segment, joint, model, state, paths, work)
                r = r * weight.value + weight.gradient * length
            total.speed += wp.dot(r, work.joint_velocity[joint])
            if paths.term_first[term] == 0:
                r += arm[instance, crossing]
            arm[instance, crossing] = r
        if varies != 0:
            weight = segment_weight(instance, segment, 0, model, state, paths, work)
        total.moving += length * weight.value
    return total


@wp.func
def pulley_stretch(
    instance: int, muscle: int, model: Model, state: State, work: Work, arm: wp.array2d[wp.vec3]
) -> Stretch:
    """The same of a path on pulleys."""
    paths = model.paths
    total = Stretch()
    total.fixed = at(paths.fixed_length, instance, muscle)
    for k in range(paths.pulley_start[muscle], paths.pulley_start[muscle + 1]):
        crossing = paths.pulley_crossing[k]
        joint = paths.crossing_joint[crossing]
        axis = paths.pulley_axis[k]
        pulley = at(paths.pulley, instance, k)
        angle = state.coordinates[instance, model.skeleton.coordinate_start[joint] + axis]
        total.moving -= pulley[0] * (angle - pulley[1])
        r = coordinate_gradient(instance, joint, axis, model, work) * -pulley[0]
        total.speed += wp.dot(r, work.joint_velocity[joint])
        if paths.pulley_first[k] == 0:
            r += arm[instance, crossing]
        arm[instance, crossing] = r
    return total


@cache
def stretch_of(pulleys: bool) -> Any:
    """The Warp function of the length and speed of a path, see `muscle_stretch`.

    Args:
        pulleys: whether there are paths on pulleys.
    """
    if not pulleys:
        return muscle_stretch

    @wp.func
    def any_stretch(
        instance: int, muscle: int, model: Model, state: State, work: Work, arm: wp.array2d[wp.vec3]
    ) -> Stretch:
        if model.paths.pulley_start[muscle + 1] > model.paths.pulley_start[muscle]:
            return pulley_stretch(instance, muscle, model, state, work, arm)
        return muscle_stretch(instance, muscle, model, state, work, arm)

    return any_stretch
