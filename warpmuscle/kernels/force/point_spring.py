"""A spring between a point of a body and one of another body."""

import warp as wp

from warpmuscle.kernels.force.forces import Wrench
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at

SHORTEST = 1.0e-6  # m, below which a line has no direction


@wp.struct
class PointSpring:
    """Where a spring is fixed, and how it pulls; a cord has no stiffness below its rest length."""

    first_x: float  # m, from the centre of mass of the first body
    first_y: float
    first_z: float
    second_x: float  # m, from that of the second body
    second_y: float
    second_z: float
    rest_length: float  # m
    stiffness_above: float  # N/m, where it is longer
    stiffness_below: float  # N/m, where it is shorter
    damping: float  # N s/m, where it is not slack


@func
def point_spring_tension(length: float, speed: float, spring: PointSpring) -> float:
    """Tension, N: k (l - l0) + d v, k by the side of the rest length; 0 where it is slack."""
    stretch = length - spring.rest_length
    stiffness = wp.where(stretch > 0.0, spring.stiffness_above, spring.stiffness_below)
    if stiffness == 0.0:
        return 0.0
    return stiffness * stretch + spring.damping * speed


@wp.struct
class PointsApart:
    """Two points of bodies, from one of them."""

    apart: wp.vec3  # m, from this body's point to the other one's, world
    moving: wp.vec3  # m/s, the rate of that
    arm: wp.vec3  # m, from the centre of mass of this body to its point


@func
def points_apart(
    instance: int, body: int, other: int, second: int, first_end: wp.vec3, second_end: wp.vec3, model: ModelRef,
    work: ScratchRef,
) -> PointsApart:  # fmt: skip
    """How the points lie, seen from `body`, of which `second` says whether it is the second one."""
    own = work.rotation[body] * wp.where(second == 1, second_end, first_end)
    center = work.rotation[body] * at(model.skeleton.row, instance, body).com
    theirs = work.rotation[other] * (
        wp.where(second == 1, first_end, second_end) + at(model.skeleton.row, instance, other).com
    )
    line = PointsApart()
    line.apart = work.position[other] + theirs - work.position[body] - own - center
    line.moving = work.velocity[other] + wp.cross(work.angular_velocity[other], theirs)
    line.moving -= work.velocity[body] + wp.cross(work.angular_velocity[body], own + center)
    line.arm = own
    return line


@func
def point_spring(
    instance: int, body: int, other: int, second: int, model: ModelRef, state: StateRef, work: ScratchRef,
    spring: PointSpring,
) -> Wrench:  # fmt: skip
    """What the spring does to one of its bodies, of which `second` says whether it is the second one."""
    first_end = wp.vec3(spring.first_x, spring.first_y, spring.first_z)
    second_end = wp.vec3(spring.second_x, spring.second_y, spring.second_z)
    line = points_apart(instance, body, other, second, first_end, second_end, model, work)
    length = wp.length(line.apart)
    w = Wrench()
    if length > wp.static(SHORTEST):
        along = line.apart / length
        w.force = along * point_spring_tension(length, wp.dot(line.moving, along), spring)
        w.moment = wp.cross(line.arm, w.force)
    return w
