"""Joint kinematics."""

import warp as wp

from warpmuscle.kernels.algebra.angles import sine_cosine
from warpmuscle.kernels.functions import func


@func
def hinge_rotation(axis: wp.vec3, angle: float) -> wp.quat:
    """Rotation by `angle` (rad) about a unit axis."""
    half = sine_cosine(0.5 * angle)
    return wp.quat(axis[0] * half[0], axis[1] * half[0], axis[2] * half[0], half[1])


@func
def universal_bias(parent_velocity: wp.vec3, rate_a: wp.vec3, rate_b: wp.vec3) -> wp.vec3:
    """Velocity-product angular acceleration of a universal joint, rad/s^2; with rate_b = 0 of any other one.

    Axis b moves with the parent and axis a with the child: d/dt (b b') and d/dt (a a') at constant rates.

    Args:
        parent_velocity: angular velocity of the parent, world, rad/s.
        rate_a, rate_b: a a' and b b', the axes times their rates, world, rad/s. Of hinges and ball joints rate_a is the
            angular velocity relative to the parent.
    """
    return wp.cross(parent_velocity + rate_a + rate_b, rate_a) + wp.cross(parent_velocity, rate_b)
