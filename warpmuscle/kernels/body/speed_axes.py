"""Along what each speed of a joint moves its bodies, and how it changes: columns of the mass matrix."""

import warp as wp

from warpmuscle.kernels.body.joint_motion import has_motion
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import BALL, FOLLOWER, ROOT_FREE, UNIVERSAL, ModelRef, ScratchRef, at


@func
def speed_rate_of(body: int, k: int, model: ModelRef, work: ScratchRef) -> float:
    """Derivative of speed k of a body's joint, from the accelerations."""
    if body > 0:
        return work.factor_c[body][k]
    if model.skeleton.plan[0].joint_type == ROOT_FREE:
        if k < 3:
            return work.acceleration[0][k]
        return work.angular_acceleration[0][k - 3]
    if k < 2:
        return work.acceleration[0][k + 1]
    return work.angular_acceleration[0][0]


@func
def unit(k: int) -> wp.vec3:
    """Unit vector along axis k."""
    v = wp.vec3(0.0)
    v[k] = 1.0
    return v


@func
def angular_axis(instance: int, body: int, k: int, model: ModelRef, work: ScratchRef) -> wp.vec3:
    """Angular velocity that a unit of speed k of a body's joint gives the body relative to its parent, world."""
    kind = model.skeleton.plan[body].joint_type
    if body == 0:
        if kind == ROOT_FREE:
            return wp.where(k < 3, wp.vec3(0.0), unit(wp.max(k - 3, 0)))
        return wp.where(k < 2, wp.vec3(0.0), unit(0))
    if kind == BALL:
        return work.rotation[body] * unit(k)
    if has_motion(kind):
        return work.coordinate_turning[body]
    if kind == UNIVERSAL and k == 1:
        return work.rotation[model.skeleton.plan[body].parent] * at(model.skeleton.row, instance, body).axis_b
    return work.rotation[body] * at(model.skeleton.row, instance, body).axis_a


@func
def moving_speeds(body: int, model: ModelRef) -> int:
    """How many speeds move the joint of a body, its own or that which it follows."""
    if model.skeleton.plan[body].joint_type == FOLLOWER:
        return 1
    return model.skeleton.plan[body].speed_end - model.skeleton.plan[body].speed_start


@func
def linear_axis(body: int, k: int, model: ModelRef, work: ScratchRef) -> wp.vec3:
    """Velocity that a unit of speed k of a body's joint gives the joint, world; 0 if that cannot move."""
    if body == 0 and model.skeleton.plan[0].joint_type == ROOT_FREE:
        return wp.where(k < 3, unit(wp.min(k, 2)), wp.vec3(0.0))
    if body == 0:
        return wp.where(k < 2, unit(wp.min(k, 1) + 1), wp.vec3(0.0))
    if has_motion(model.skeleton.plan[body].joint_type):
        return work.coordinate_moving[body]
    return wp.vec3(0.0)
