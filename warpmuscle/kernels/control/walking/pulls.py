"""PD torques of the walking controller, and what its relative numbers are multiplied by."""

import warp as wp

from warpmuscle.kernels.algebra.angles import pd_error
from warpmuscle.kernels.body.joint import hinge_rotation
from warpmuscle.kernels.contact.contact import body_weight
from warpmuscle.kernels.control.joint_values import joint_coordinate, joint_speed
from warpmuscle.kernels.control.walking.parameters import LEG, WalkingJoint
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at


@wp.struct
class Units:
    """What relative numbers are multiplied by."""

    stiffness: float  # N m/rad
    damping: float  # N m s/rad
    force: float  # N s/m, of forces for a speed
    weight: float  # N


@func
def units_of(instance: int, model: ModelRef, memory: wp.array[float]) -> Units:
    """Those of a body."""
    u = Units()
    gravity = at(model.gravity, instance, 0)
    time = wp.sqrt(memory[LEG] / gravity)
    u.weight = body_weight(instance, model)
    u.stiffness = u.weight * memory[LEG]
    u.damping = u.stiffness * time
    u.force = u.weight / gravity / time
    return u


@func
def pull_to(body: int, target: wp.quat, relative: wp.vec3, kp: float, kd: float, work: ScratchRef) -> wp.vec3:
    """PD torque on a body towards an orientation, world, N m: kp error - kd velocity.

    Args:
        target: world. relative: angular velocity that is damped, rad/s, world.
    """
    return work.rotation[body] * pd_error(work.orientation[body], target) * kp - relative * kd


@func
def turn_by(v: wp.vec3) -> wp.quat:
    """The rotation about a vector by its length, rad."""
    angle = wp.length(v)
    if angle < 1.0e-6:
        return wp.quat(0.0, 0.0, 0.0, 1.0)
    return hinge_rotation(v / angle, angle)


@func
def hinge_pull(
    instance: int, body: int, angle: float, own: WalkingJoint, u: Units, model: ModelRef, state: StateRef,
    work: ScratchRef,
) -> wp.vec3:  # fmt: skip
    """PD torque of a hinge towards an angle on the body that it carries, world, N m."""
    error = angle - joint_coordinate(instance, body, 0, model, state)
    effort = own.kp * u.stiffness * error - own.kd * u.damping * joint_speed(instance, body, 0, model, state)
    return work.rotation[body] * at(model.skeleton.row, instance, body).axis_a * effort


@func
def lead_of(own: WalkingJoint, u: Units) -> float:
    """How far ahead of now PD must aim, s, not to lag behind what moves: kd / kp."""
    return own.kd * u.damping / wp.max(own.kp * u.stiffness, 1.0e-6)
