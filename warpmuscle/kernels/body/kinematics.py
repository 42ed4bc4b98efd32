"""Forward kinematics: poses and velocities of all bodies, centre of mass."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import rotation_matrix
from warpmuscle.kernels.body.dynamics import forward_pass_of
from warpmuscle.kernels.body.joint import hinge_rotation, universal_bias
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.main_memory import rotation_of
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import (
    BALL,
    FIXED,
    ROOT_FREE,
    ROOT_PLANAR,
    UNIVERSAL,
    ModelRef,
    ScratchRef,
    Skeleton,
    StateRef,
    at,
    component,
    nonnegative,
    not_unrolled,
    set_component,
)


@func
def coordinate_quat(state: StateRef, instance: int, first: int) -> wp.quat:
    """The quaternion stored at coordinates first..first + 3."""
    first = nonnegative(first)
    return wp.quat(
        state.coordinates[instance, first],
        state.coordinates[instance, first + 1],
        state.coordinates[instance, first + 2],
        state.coordinates[instance, first + 3],
    )


@func
def speed_vector(state: StateRef, instance: int, first: int) -> wp.vec3:
    """The vector stored at speeds first..first + 2."""
    first = nonnegative(first)
    return wp.vec3(state.speeds[instance, first], state.speeds[instance, first + 1], state.speeds[instance, first + 2])


@func
def coordinate_vector(state: StateRef, instance: int, first: int) -> wp.vec3:
    """The vector stored at coordinates first..first + 2."""
    first = nonnegative(first)
    return wp.vec3(
        state.coordinates[instance, first],
        state.coordinates[instance, first + 1],
        state.coordinates[instance, first + 2],
    )


@func
def acceleration_vector(state: StateRef, instance: int, first: int) -> wp.vec3:
    """The vector stored at accelerations first..first + 2."""
    first = nonnegative(first)
    return wp.vec3(
        state.accelerations[instance, first],
        state.accelerations[instance, first + 1],
        state.accelerations[instance, first + 2],
    )


@func
def lag_vector(state: StateRef, instance: int, first: int, half: float) -> wp.vec3:
    """What speeds first..first + 2 gained in the last half step (s)."""
    return acceleration_vector(state, instance, first) * half


@func
def joint_orientation(skeleton: Skeleton, state: StateRef, instance: int, body: int) -> wp.quat:
    """Orientation of a body in its parent; of body 0 in the world."""
    plan = skeleton.plan[body]
    row = at(skeleton.row, instance, body)
    kind = plan.joint_type
    first = nonnegative(plan.coordinate_start)
    q = wp.quat(0.0, 0.0, 0.0, 1.0)
    if body == 0:
        if kind == ROOT_PLANAR:
            q = hinge_rotation(wp.vec3(1.0, 0.0, 0.0), state.coordinates[instance, first + 2])
        else:
            q = coordinate_quat(state, instance, first + 3)
    elif kind == BALL:
        q = coordinate_quat(state, instance, first)
    elif kind != FIXED:
        q = hinge_rotation(row.axis_a, state.coordinates[instance, first])
        if kind == UNIVERSAL:
            q = hinge_rotation(row.axis_b, state.coordinates[instance, first + 1]) * q
    return q


@func
def place_root(skeleton: Skeleton, state: StateRef, instance: int, half: float, work: ScratchRef):
    """Pose and velocity of the root from its coordinates and speeds, and the lag of its velocity."""
    q = joint_orientation(skeleton, state, instance, 0)
    position = coordinate_vector(state, instance, 0)
    velocity = wp.vec3(0.0, 0.0, 0.0)
    angular = wp.vec3(0.0, 0.0, 0.0)
    lag_velocity = wp.vec3(0.0, 0.0, 0.0)
    lag_angular = wp.vec3(0.0, 0.0, 0.0)
    if skeleton.plan[0].joint_type == ROOT_PLANAR:
        position = wp.vec3(0.0, state.coordinates[instance, 0], state.coordinates[instance, 1])
        velocity = wp.vec3(0.0, state.speeds[instance, 0], state.speeds[instance, 1])
        angular = wp.vec3(state.speeds[instance, 2], 0.0, 0.0)
        lag = lag_vector(state, instance, 0, half)
        lag_velocity = wp.vec3(0.0, lag[0], lag[1])
        lag_angular = wp.vec3(lag[2], 0.0, 0.0)
    elif skeleton.plan[0].joint_type == ROOT_FREE:
        velocity = speed_vector(state, instance, 0)
        angular = speed_vector(state, instance, 3)
        lag_velocity = lag_vector(state, instance, 0, half)
        lag_angular = lag_vector(state, instance, 3, half)
    work.orientation[0] = q
    work.rotation[0] = rotation_matrix(q)
    work.position[0] = position
    work.velocity[0] = velocity
    work.angular_velocity[0] = angular
    work.lag_velocity[0] = lag_velocity
    work.lag_angular[0] = lag_angular
    work.bias[0] = wp.vec3(0.0, 0.0, 0.0)


@func
def move_joint(instance: int, body: int, half: float, model: ModelRef, state: StateRef, work: ScratchRef):
    """What the joint of a body does, in the axes of its bodies: orientation, velocity, and what that gained.

    One part of the velocity is along axes of the child, the other, of universal joints, along an axis of the parent.
    """
    skeleton = model.skeleton
    plan = skeleton.plan[body]
    row = at(skeleton.row, instance, body)
    kind = plan.joint_type
    first = nonnegative(plan.speed_start)
    work.anchor[body] = row.anchor
    work.turned[body] = joint_orientation(skeleton, state, instance, body)
    rate = wp.vec3(0.0)
    gain = wp.vec3(0.0)
    parent_rate = wp.vec3(0.0)
    parent_gain = wp.vec3(0.0)
    if kind == BALL:
        rate = speed_vector(state, instance, first)
        gain = lag_vector(state, instance, first, half)
    elif kind != FIXED:
        axis = row.axis_a
        rate = axis * state.speeds[instance, first]
        gain = axis * (half * state.accelerations[instance, first])
        if kind == UNIVERSAL:
            axis = row.axis_b
            parent_rate = axis * state.speeds[instance, first + 1]
            parent_gain = axis * (half * state.accelerations[instance, first + 1])
    work.rate[body] = rate
    work.gain[body] = gain
    work.parent_rate[body] = parent_rate
    work.parent_gain[body] = parent_gain


@func
def place_body(skeleton: Skeleton, body: int, work: ScratchRef):
    """Pose and velocity of a body, and the lag of its velocity, from those of its parent and its joint's motion."""
    parent = nonnegative(skeleton.plan[body].parent)
    q = work.orientation[parent] * work.turned[body]
    rotation = rotation_matrix(q)
    parent_rotation = rotation_of(parent, work)
    parent_angular = work.angular_velocity[parent]
    parent_lag = work.lag_angular[parent]
    r = parent_rotation * work.anchor[body]
    rate_a = rotation * work.rate[body]
    rate_b = parent_rotation * work.parent_rate[body]
    lag = rotation * work.gain[body] + parent_rotation * work.parent_gain[body]
    work.orientation[body] = q
    work.rotation[body] = rotation
    work.position[body] = work.position[parent] + r
    work.angular_velocity[body] = parent_angular + (rate_a + rate_b)
    work.velocity[body] = work.velocity[parent] + wp.cross(parent_angular, r)
    work.lag_angular[body] = parent_lag + lag
    work.lag_velocity[body] = work.lag_velocity[parent] + wp.cross(parent_lag, r)
    work.bias[body] = universal_bias(parent_angular, rate_a, rate_b)


@func
def component_sum(values: wp.array[wp.vec3], count: int, axis: int) -> float:
    """Sum of a component of the first `count` vectors, in order."""
    total = wp.float32(0.0)
    for i in range(count):
        not_unrolled()
        total += component(values, i, axis)
    return total


@wp.func_native(
    snippet="""
float total = 0.0f;
#if defined(__CUDA_ARCH__)
#pragma unroll 16
#endif
for (int i = 0; i < count; ++i)
    total += (*wp::address(values, i))[axis];
return total;
"""
)
def component_sum_of_many(values: wp.array[wp.vec3], count: int, axis: int) -> float: ...  # fetches several at once


@cache
def kinematics_stage_of(move: Any, place: Any, prepare: Any = None, along_runs: Any = None) -> Any:
    """The Warp function of poses, velocities and centre of mass of one instance. It ends with a barrier.

    Args:
        move, place: `move_joint` and `place_body`, or others for more types of joints.
        prepare: a stage that comes before, if any. along_runs: places all bodies but the root, if not by `place`, see
            `along_runs.py`.
    """
    prepared = prepare is not None
    sum_up = component_sum if along_runs is None else component_sum_of_many

    @func
    def place_one(instance: int, body: int, model: ModelRef, work: ScratchRef):
        place(model.skeleton, body, work)

    place_all = along_runs or forward_pass_of(place_one)

    @func
    def kinematics_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
        skeleton = model.skeleton
        half = 0.5 * model.time_step
        if wp.static(prepared):
            prepare(instance, lane, lanes, model, state, work)
        if lane == 0:
            place_root(skeleton, state, instance, half, work)
        for body in range(1 + lane, model.body_count, lanes):
            not_unrolled()
            move(instance, body, half, model, state, work)
        synchronize()
        place_all(instance, lane, lanes, model, work)
        mass = at(skeleton.total_mass, instance, 0)
        for i in range(lane, model.body_count, lanes):
            not_unrolled()
            row = at(skeleton.row, instance, i)
            m = row.mass
            c = rotation_of(i, work) * row.com
            work.moment[i] = m * (work.position[i] + c)
            work.momentum[i] = m * (work.velocity[i] + wp.cross(work.angular_velocity[i], c))
        synchronize()
        for k in range(lane, 6, lanes):
            not_unrolled()
            axis = k % 3
            if k < 3:
                set_component(work.center, 0, axis, sum_up(work.moment, model.body_count, axis) / mass)
            else:
                set_component(work.center, 1, axis, sum_up(work.momentum, model.body_count, axis) / mass)
        synchronize()

    return kinematics_stage


kinematics_stage = kinematics_stage_of(move_joint, place_body)
