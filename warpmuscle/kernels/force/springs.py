"""Spring-dampers of joints, see `scene.Actuation`: with the damping of muscles or the gains of PD they are implicit."""

import warp as wp

from warpmuscle.kernels.algebra.angles import pd_error
from warpmuscle.kernels.body.joint_motion import has_motion
from warpmuscle.kernels.control.coordinate_control import target_coordinate
from warpmuscle.kernels.force.actuation import IMPLICIT_SHARE, JointDrive, PassiveForce
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, at


@func
def spring_torque(error: wp.vec3, velocity: wp.vec3, stiffness: float, damping: float) -> wp.vec3:
    """Torque of a spring-damper on the parent, N m: d w - k e.

    Args:
        error: rotation from the child's orientation to the relaxed one, rad. velocity: of the child relative to the
            parent, rad/s.
    """
    return damping * velocity - stiffness * error


@func
def add_spring(
    instance: int,
    body: int,
    parent: int,
    rotation: wp.mat33,
    drive: wp.ref[JointDrive],
    passive: wp.mat33,
    model: ModelRef,
    work: ScratchRef,
):
    """Add the spring-damper of a joint to what drives it."""
    actuation = model.actuation
    stiffness = at(actuation.stiffness, instance, body)
    damping = at(actuation.damping, instance, body)
    if model.implicit_pd == 1:
        drive.inertia = drive.inertia + passive * wp.transpose(passive) * (
            model.time_step * (damping + model.time_step * stiffness)
        )
        damping += model.time_step * stiffness
    error = pd_error(work.orientation[body], work.orientation[parent] * at(actuation.rest, instance, body))
    torque = spring_torque(rotation * error, work.joint_velocity[body], stiffness, damping)
    drive.torque = drive.torque + passive * torque


@func
def add_any_spring(
    instance: int,
    body: int,
    parent: int,
    rotation: wp.mat33,
    drive: wp.ref[JointDrive],
    passive: wp.mat33,
    model: ModelRef,
    work: ScratchRef,
):
    """`add_spring` where there may be joints of one coordinate, whose springs are along it: N/m if it is a length.

    Written as `add_spring`; sharing code with it changes how the compiler rounds there.
    """
    if has_motion(model.skeleton.plan[body].joint_type):
        stiffness = at(model.actuation.stiffness, instance, body)
        damping = at(model.actuation.damping, instance, body)
        if model.implicit_pd == 1:
            damping += model.time_step * stiffness
            drive.inertia = drive.inertia + passive * wp.transpose(passive) * (model.time_step * damping)
        axis = at(model.skeleton.row, instance, body).axis_a
        rest = target_coordinate(at(model.actuation.rest, instance, body), axis)
        error = rotation * axis * (rest - work.coordinate_state[body][0])
        drive.torque = drive.torque + passive * spring_torque(error, work.joint_velocity[body], stiffness, damping)
    else:
        add_spring(instance, body, parent, rotation, drive, passive, model, work)


@func
def spring_damping(
    instance: int, body: int, inertia: wp.mat33, passive: wp.mat33, model: ModelRef, work: ScratchRef
) -> wp.mat33:
    """Implicit inertia of a joint, and that of its damper."""
    damping = at(model.actuation.damping, instance, body)
    return inertia + passive * wp.transpose(passive) * (damping * (IMPLICIT_SHARE * model.time_step))


SPRINGS = PassiveForce(add_spring, spring_damping)
ANY_SPRINGS = PassiveForce(add_any_spring, spring_damping)
