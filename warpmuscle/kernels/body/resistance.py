"""What joints have of inertia and damping of their own: the rotor of a motor, or the drag of what is around a joint.

Both count along a joint's coordinate q, so that its force is Q = -(armature) q'' - (damping) q'. A joint that follows
another one by y = f(q) puts its own on that one's coordinate (virtual work): f'^2 of both, and the armature's force
f' f'' q'^2. All are linearly implicit in the step, as in MuJoCo.
"""

import warp as wp

from warpmuscle.kernels.algebra.spatial import symmetric, symmetric_outer
from warpmuscle.kernels.body.joint_motion import displacement_rates, has_motion
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import BALL, FIXED, FOLLOWER, ModelRef, ScratchRef, StateRef, at, nonnegative

FUNCTIONS = 6  # of a coupled joint


@func
def reflected(instance: int, body: int, q: float, model: ModelRef) -> wp.vec3:
    """Armature and damping that followers of a joint put on its coordinate q, and the first's force over q'^2."""
    total = wp.vec3(0.0)
    for place in range(model.couplings.follower_start[body], model.couplings.follower_start[body + 1]):
        other = nonnegative(model.couplings.follower[place])
        own = at(model.couplings.resistance, instance, other)
        if own[0] != 0.0 or own[1] != 0.0:
            first = model.couplings.joint[other].first
            for k in range(FUNCTIONS):
                rates = displacement_rates(model.couplings, instance, first + k, q)
                slope = rates[1]
                total += wp.vec3(own[0] * slope * slope, own[1] * slope * slope, own[0] * slope * rates[2])
    return total


@func
def armature_of(instance: int, body: int, model: ModelRef, state: StateRef) -> float:
    """Armature along each coordinate of a joint, with that of its followers."""
    total = at(model.couplings.resistance, instance, body)[0]
    plan = model.skeleton.plan[body]
    if has_motion(plan.joint_type):
        total += reflected(instance, body, state.coordinates[instance, nonnegative(plan.coordinate_start)], model)[0]
    return total


@func
def resistance_stage(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """Add a joint's armature and damping, and those of its followers, to its torque and implicit inertia."""
    if body == 0:  # the numbers of types of roots are those of joints, too
        return
    plan = model.skeleton.plan[body]
    kind = plan.joint_type
    step = model.time_step
    own = at(model.couplings.resistance, instance, body)
    if kind == BALL:
        parent = nonnegative(plan.parent)
        angular = work.angular_velocity[body] - work.angular_velocity[parent]
        rate = angular - work.lag_angular[body] + work.lag_angular[parent]
        k = own[0] + step * own[1]
        work.torque[body] = work.torque[body] + rate * own[1]
        work.stiffness[body] = work.stiffness[body] + symmetric(k, 0.0, 0.0, k, 0.0, k)
    elif kind != FIXED and kind != FOLLOWER:
        speed = nonnegative(plan.speed_start)
        v = state.speeds[instance, speed]
        rate_of = v - 0.5 * step * state.accelerations[instance, speed]
        total = wp.vec3(own[0], own[1], 0.0)
        if has_motion(kind):
            total += reflected(instance, body, state.coordinates[instance, nonnegative(plan.coordinate_start)], model)
        axis = work.rotation[body] * at(model.skeleton.row, instance, body).axis_a
        work.torque[body] = work.torque[body] + axis * (total[1] * rate_of + total[2] * v * v)
        work.stiffness[body] = work.stiffness[body] + symmetric_outer(axis, total[0] + step * total[1])
