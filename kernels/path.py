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
"""

import warp as wp

from warpmuscle.kernels.structs import UNIVERSAL, Model, State, Work, at


@wp.struct
class Paths:
    """Paths of all muscles, one behind the other; a crossing is a pair of a joint and a muscle that acts on it.

    Crossings are sorted by joint, so that a joint gathers its own muscles. Joints are named by the body they carry.
    """

    muscle_count: int
    start: wp.array[int]  # (muscles + 1,) points of muscle m are start[m]..start[m + 1] - 1
    point_body: wp.array[int]  # (points,)
    point: wp.array2d[wp.vec3]  # (rows, points) m, from the body's joint, body axes
    point_condition: wp.array[int]  # (points,) -1: the point always counts
    condition_joint: wp.array[int]  # (conditions,)
    condition_axis: wp.array[int]  # (conditions,) which of the joint's coordinates
    condition_interval: wp.array2d[wp.vec3]  # (rows, conditions) low, high, width of the blend, rad
    segment_start: wp.array[int]  # (muscles + 1,)
    segment: wp.array2d[int]  # (segments, 2) its points a and b, in the order of the path
    segment_varies: wp.array[int]  # (segments,) 1: its weight depends on conditions
    crossing_start: wp.array[int]  # (bodies + 1,) crossings of the joint of body i
    crossing_joint: wp.array[int]  # (crossings,)
    crossing_muscle: wp.array[int]  # (crossings,)
    term_start: wp.array[int]  # (crossings + 1,) segments that make a muscle act on a joint
    term_segment: wp.array[int]  # (terms,)
    term_sign: wp.array[int]  # (terms,) 1: b is beyond the joint, -1: a is, 0: only a condition hangs on the joint
    muscle_crossing_start: wp.array[int]  # (muscles + 1,)
    muscle_crossing: wp.array[int]  # (crossings,) the crossings of a muscle, nearest to the root first


@wp.struct
class Weight:
    """How much a point or segment counts, and how that changes."""

    value: float  # 0..1
    rate: float  # 1/s
    gradient: wp.vec3  # by turns of one joint, world: times the joint's angular velocity it is a part of the rate


@wp.struct
class Stretch:
    """Length, m, and lengthening speed, m/s."""

    length: float
    speed: float


@wp.func
def direction_of(a: wp.vec3, b: wp.vec3) -> wp.vec3:
    """Unit vector from a to b; zero if they coincide."""
    return wp.normalize(b - a)


@wp.func
def lengthening_speed(direction: wp.vec3, velocity_a: wp.vec3, velocity_b: wp.vec3) -> float:
    """Rate of the distance of two points, m/s: (v_b - v_a) . direction.

    Args:
        direction: unit vector from a to b.
    """
    return wp.dot(velocity_b - velocity_a, direction)


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
def point_position(instance: int, point: int, paths: Paths, work: Work) -> wp.vec3:
    """Position of a via point in the world, m."""
    body = paths.point_body[point]
    return work.position[body] + work.rotation[body] * at(paths.point, instance, point)


@wp.func
def point_velocity(point: int, position: wp.vec3, paths: Paths, work: Work) -> wp.vec3:
    """Velocity, m/s, of a via point that is at this position in the world."""
    body = paths.point_body[point]
    return work.velocity[body] + wp.cross(work.angular_velocity[body], position - work.position[body])


@wp.func
def muscle_stretch(instance: int, muscle: int, model: Model, state: State, paths: Paths, work: Work) -> Stretch:
    """Length and lengthening speed of one muscle's path, from the kinematics in the working set."""
    total = Stretch()
    last = paths.start[muscle] - 1  # the point that b is: none yet
    b = wp.vec3(0.0)
    velocity_b = wp.vec3(0.0)
    for segment in range(paths.segment_start[muscle], paths.segment_start[muscle + 1]):
        first = paths.segment[segment, 0]
        a = b
        velocity_a = velocity_b
        if first != last:
            a = point_position(instance, first, paths, work)
            velocity_a = point_velocity(first, a, paths, work)
        last = paths.segment[segment, 1]
        b = point_position(instance, last, paths, work)
        velocity_b = point_velocity(last, b, paths, work)
        length = wp.length(b - a)
        speed = lengthening_speed(direction_of(a, b), velocity_a, velocity_b)
        if paths.segment_varies[segment] != 0:
            weight = segment_weight(instance, segment, 0, model, state, paths, work)
            speed = weight.value * speed + weight.rate * length
            length = weight.value * length
        total.length += length
        total.speed += speed
    return total


@wp.func
def moment_arm(instance: int, crossing: int, model: Model, state: State, paths: Paths, work: Work) -> wp.vec3:
    """Moment arm vector, m, world, of the crossing's muscle about its joint: the sum over all segments that act on it.

    A tension F puts the torque F r on the joint's parent and -F r on its child.
    """
    joint = paths.crossing_joint[crossing]
    total = wp.vec3(0.0)
    for term in range(paths.term_start[crossing], paths.term_start[crossing + 1]):
        segment = paths.term_segment[term]
        a = point_position(instance, paths.segment[segment, 0], paths, work)
        b = point_position(instance, paths.segment[segment, 1], paths, work)
        arm = segment_moment_arm(a, work.position[joint], direction_of(a, b)) * float(paths.term_sign[term])
        if paths.segment_varies[segment] != 0:
            weight = segment_weight(instance, segment, joint, model, state, paths, work)
            arm = arm * weight.value + weight.gradient * wp.length(b - a)
        total += arm
    return total


@wp.func
def path_stage(
    instance: int, lane: int, lanes: int, model: Model, state: State, paths: Paths, work: Work,
    length: wp.array2d[float], speed: wp.array2d[float],
):  # fmt: skip
    """Length, m, and lengthening speed, m/s, of every muscle of one instance, (instances, muscles). No barrier."""
    for muscle in range(lane, paths.muscle_count, lanes):
        stretch = muscle_stretch(instance, muscle, model, state, paths, work)
        length[instance, muscle] = stretch.length
        speed[instance, muscle] = stretch.speed
