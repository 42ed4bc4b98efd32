"""Passive devices and drag: the kinds of forces that scenes know by name, see `forces.py`."""

import warp as wp

from warpmuscle.kernels.forces import Force, Wrench
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at


@wp.struct
class BilinearSpring:
    """A torsion spring with another stiffness on either side of its rest angle, 0 where it is slack."""

    rest_angle: float  # rad
    stiffness_above: float  # N m/rad
    stiffness_below: float  # N m/rad
    damping: float  # N m s/rad, where it is not slack


@wp.func
def bilinear_spring_effort(angle: float, speed: float, spring: BilinearSpring) -> float:
    """Effort of a spring that is engaged over part of the range, N m: -k (q - q0) - d v, k by the side of q0.

    As of a passive ankle exoskeleton whose spring is slack on one side (Collins, Wiggin, Sawicki 2015).
    """
    stretch = angle - spring.rest_angle
    stiffness = wp.where(stretch > 0.0, spring.stiffness_above, spring.stiffness_below)
    if stiffness == 0.0:
        return 0.0
    return -stiffness * stretch - spring.damping * speed


@wp.func
def bilinear_spring(
    instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, spring: BilinearSpring
) -> wp.vec3:
    """Effort along the first coordinate of a hinge or universal joint."""
    plan = model.skeleton.plan[body]
    angle = state.coordinates[instance, plan.coordinate_start]
    return wp.vec3(bilinear_spring_effort(angle, state.speeds[instance, plan.speed_start], spring), 0.0, 0.0)


@wp.struct
class AirDrag:
    """What air does to a body that moves through it."""

    drag_area: float  # m^2, drag coefficient times frontal area
    density: float  # kg/m^3, some 1.2


@wp.func
def drag_force(velocity: wp.vec3, drag: AirDrag) -> wp.vec3:
    """Quadratic drag, N: -1/2 rho (c_d A) |v| v."""
    return velocity * (-0.5 * drag.density * drag.drag_area * wp.length(velocity))


@wp.func
def air_drag(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, drag: AirDrag) -> Wrench:
    """Drag at the centre of mass of a body in still air."""
    c = work.rotation[body] * at(model.skeleton.row, instance, body).com
    w = Wrench()
    w.force = drag_force(work.velocity[body] + wp.cross(work.angular_velocity[body], c), drag)
    return w


FORCES = {
    "bilinear_spring": Force(effort=bilinear_spring, parameters=BilinearSpring),
    "air_drag": Force(wrench=air_drag, parameters=AirDrag),
}
