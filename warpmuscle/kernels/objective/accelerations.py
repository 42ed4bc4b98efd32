"""Accelerations of bodies within a step, for terms and recorded quantities of the stage `accelerations`."""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, at


@func
def centre_acceleration(instance: int, body: int, model: ModelRef, work: ScratchRef) -> wp.vec3:
    """Acceleration of a body's centre of mass, world, m/s^2; at rest on the ground it is 0.

    a + alpha x c + omega x (omega x c), with a of the joint and c from there.
    """
    c = work.rotation[body] * at(model.skeleton.row, instance, body).com
    omega = work.angular_velocity[body]
    turned = wp.cross(work.angular_acceleration[body], c) + wp.cross(omega, wp.cross(omega, c))
    return work.acceleration[body] + turned


@func
def centre_of_mass(instance: int, body: int, model: ModelRef, work: ScratchRef) -> wp.vec3:
    """Place of a body's centre of mass, world, m."""
    return work.position[body] + work.rotation[body] * at(model.skeleton.row, instance, body).com
