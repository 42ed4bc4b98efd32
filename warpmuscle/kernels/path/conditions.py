"""Conditional points of paths: how much a point, or a segment between two of them, counts.

The length of a path is l = sum of w |b - a| over its segments, with w = 1 for a path of fixed points. A conditional
point counts only while a joint angle is within an interval: its weight p(q) goes smoothly from 1 to 0 at both ends.
Every pair of points with none but conditional points between them is then a segment, of weight

    w = p_a p_b (1 - p_k) (1 - p_m) ...    over the points k, m, ... that it leaves out,

so that with p = 0 the path runs past the point and with p = 1 through it. Length, lengthening speed and moment arms
are continuous, and the latter two are the exact derivatives of the former, changes of weight included: a tension does
the work that the path's shortening takes. That costs a moment arm of dp/dq times what the detour over the point
is longer, so blend slowly where a point makes a long detour. Or a condition asks for weighted moment arms: dp/dq is
left out of them and of the speed, as where a smooth route slips off a surface, and as in OpenSim, whose paths jump.
"""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import UNIVERSAL, ModelRef, Paths, ScratchRef, StateRef, at


@wp.struct
class Weight:
    """How much a point or segment counts, and how that changes."""

    value: float  # 0..1
    rate: float  # 1/s
    gradient: wp.vec3  # by turns of one joint, world: times the joint's angular velocity it is a part of the rate


@func
def smooth_step(x: float) -> wp.vec2:
    """3 t^2 - 2 t^3 with t = x clamped to 0..1, and its slope."""
    t = wp.clamp(x, 0.0, 1.0)
    return wp.vec2(t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t))


@func
def condition_weight(angle: float, low: float, high: float, blend: float) -> wp.vec2:
    """Weight of a conditional point and its derivative by the angle: 1 within low..high, 0 outside, 1/2 at both ends.

    Args:
        blend: width of the transition about each end, rad; 0: the weight is 1 at both ends, too, and jumps there.
    """
    if blend <= 0.0:
        return wp.vec2(wp.where(angle >= low and angle <= high, 1.0, 0.0), 0.0)
    rise = smooth_step((angle - low) / blend + 0.5)
    fall = smooth_step((high - angle) / blend + 0.5)
    return wp.vec2(rise[0] * fall[0], (rise[1] * fall[0] - rise[0] * fall[1]) / blend)


@func
def both(a: Weight, b: Weight) -> Weight:
    """The product of two weights."""
    w = Weight()
    w.value = a.value * b.value
    w.rate = a.rate * b.value + a.value * b.rate
    w.gradient = a.gradient * b.value + b.gradient * a.value
    return w


@func
def without(a: Weight) -> Weight:
    """1 minus a weight."""
    w = Weight()
    w.value = 1.0 - a.value
    w.rate = -a.rate
    w.gradient = -a.gradient
    return w


@func
def coordinate_gradient(instance: int, joint: int, axis: int, model: ModelRef, work: ScratchRef) -> wp.vec3:
    """World vector whose product with the angular velocity of a hinge or universal joint is a coordinate's speed."""
    plan = model.skeleton.plan[joint]
    row = at(model.skeleton.row, instance, joint)
    a = work.rotation[joint] * row.axis_a
    if plan.joint_type != UNIVERSAL:
        return a
    b = work.rotation[plan.parent] * row.axis_b
    cosine = wp.dot(a, b)
    across = wp.where(axis == 0, a - b * cosine, b - a * cosine)
    return across / (1.0 - cosine * cosine)


@func
def point_weight(
    instance: int, point: int, joint: int, model: ModelRef, state: StateRef, paths: Paths, work: ScratchRef
) -> Weight:
    """How much a point counts; its gradient is by turns of the given joint."""
    w = Weight()
    w.value = 1.0
    condition = paths.point_condition[point]
    if condition < 0:
        return w
    on = paths.condition_joint[condition]
    axis = paths.condition_axis[condition]
    interval = at(paths.condition_interval, instance, condition)
    angle = state.coordinates[instance, model.skeleton.plan[on].coordinate_start + axis]
    weight = condition_weight(angle, interval[0], interval[1], interval[2])
    w.value = weight[0]
    w.rate = weight[1] * state.speeds[instance, model.skeleton.plan[on].speed_start + axis]
    if on == joint and weight[1] != 0.0 and paths.condition_slope[condition] != 0:
        w.gradient = coordinate_gradient(instance, on, axis, model, work) * weight[1]
    return w


@func
def segment_weight(
    instance: int, segment: int, joint: int, model: ModelRef, state: StateRef, paths: Paths, work: ScratchRef
) -> Weight:
    """How much a segment counts; its gradient is by turns of the given joint."""
    a = paths.segment_points[segment, 0]
    b = paths.segment_points[segment, 1]
    w = point_weight(instance, a, joint, model, state, paths, work)
    w = both(w, point_weight(instance, b, joint, model, state, paths, work))
    for left_out in range(a + 1, b):
        w = both(w, without(point_weight(instance, left_out, joint, model, state, paths, work)))
    return w
