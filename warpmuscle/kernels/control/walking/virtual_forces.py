"""Torques in place of forces that nothing exerts (Pratt 2001; Coros 2010, 4.3 and 4.4)."""

import warp as wp

from warpmuscle.kernels.functions import func


@func
def gravity_torque(mass: float, moment: wp.vec3, joint: wp.vec3, gravity: float) -> wp.vec3:
    """Torque on a body that bears the weight of all beyond its joint, N m: (c - p) x m g up.

    Args:
        mass, moment: of the body and all that it carries outwards, kg, and that times its centre of mass, kg m.
    """
    return wp.cross(moment - joint * mass, wp.vec3(0.0, gravity, 0.0))


@func
def force_torque(force: wp.vec3, place: wp.vec3, joint: wp.vec3) -> wp.vec3:
    """Torque on what is outward of a joint of a leg that stands, so that a force acts at a place inward: -(c - p) x F.

    It is the transpose of the Jacobian of the place, with the foot held.
    """
    return -wp.cross(place - joint, force)


@func
def within_foot(torque: wp.vec3, load: float, heel: float, toe: float, half_width: float) -> wp.vec3:
    """Torque on a foot in its axes, as much as its load can bear within its sole, N m.

    A torque about x moves the centre of pressure by torque / load forwards, one about z to the right.
    """
    return wp.vec3(
        wp.clamp(torque[0], load * heel, load * toe),
        torque[1],
        wp.clamp(torque[2], -load * half_width, load * half_width),
    )
