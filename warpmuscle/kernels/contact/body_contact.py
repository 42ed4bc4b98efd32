"""Contact of bodies with each other: capsules with a spring, a damper and regularised Coulomb friction.

The force of a pair acts on both bodies, equal and opposite at one point, so that momentum is kept to the last digit.
It is implicit over the step as if both bodies were free of their joints, which is as light as they can be: a true mass
can only be greater, so that no stiffness is unstable.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.contact.collision import fractions_along
from warpmuscle.kernels.contact.contact import friction_damping, normal_force
from warpmuscle.kernels.contact.touching import Touch
from warpmuscle.kernels.force.forces import ForceKind
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import BodyRow, ModelRef, ScratchRef, at


@wp.struct
class CapsulePair:
    """Two capsules, each in the axes of its body from its centre of mass, m, and what acts between them."""

    first_x: float  # middle of the first capsule's segment
    first_y: float
    first_z: float
    first_half_x: float  # from there to its end
    first_half_y: float
    first_half_z: float
    first_radius: float
    second_x: float
    second_y: float
    second_z: float
    second_half_x: float
    second_half_y: float
    second_half_z: float
    second_radius: float
    margin: float  # by which capsules that touch before the next look are clear of each other now at most
    reach: float  # of the middles; beyond it they are farther apart
    stiffness: float  # N/m
    damping: float  # N s/m
    tangential_damping: float  # N s/m, up to the friction limit
    friction: float


@func
def mobility(direction: wp.vec3, arm: wp.vec3, rotation: wp.mat33, inertia: wp.vec3, mass: float) -> float:
    """Acceleration of a point of a free body by a unit force in a direction there, 1/kg: 1/m + u . I^-1 u, u = r x n.

    Args:
        direction: n, unit vector. arm: r, from the centre of mass, m. rotation: of the principal axes.
        inertia: principal moments, kg m^2. mass: kg; of a body without mass, the other one's mobility counts alone.
    """
    if mass <= 0.0:
        return 0.0
    u = wp.transpose(rotation) * wp.cross(arm, direction)
    turning = u[0] * u[0] / inertia[0] + u[1] * u[1] / inertia[1] + u[2] * u[2] / inertia[2]
    return 1.0 / mass + turning


@func
def given_way(force: float, gives: float, pair_mobility: float) -> float:
    """A force at the end of a step that was `force` at its start and falls by `gives` for a unit of acceleration, N.

    f = f0 - K a with a = w f, so f = f0 / (1 + K w).

    Args:
        gives: K, h (d + h k), kg. pair_mobility: w, 1/kg, of both bodies together.
    """
    return force / (1.0 + gives * pair_mobility)


@wp.struct
class Closest:
    """Where two capsules are nearest to each other; each point from the centre of mass of its own body, world, m."""

    first_com: wp.vec3  # from the joint point of the first body to its centre of mass
    second_com: wp.vec3
    first_arm: wp.vec3  # to the nearest point of the first one's segment
    second_arm: wp.vec3
    apart: wp.vec3  # from the centre of mass of the first to that of the second
    gap: wp.vec3  # from nearest point to nearest point
    distance: float  # of these points; -1 if the capsules are out of reach, and the arms not known


@func
def closest_points(
    first_row: BodyRow, second_row: BodyRow, first: int, second: int, work: ScratchRef, pair: CapsulePair
) -> Closest:
    """Where the segments of two capsules are nearest to each other, unless they are out of reach."""
    c = Closest()
    c.distance = -1.0
    first_turn = work.rotation[first]
    second_turn = work.rotation[second]
    c.first_arm = first_turn * wp.vec3(pair.first_x, pair.first_y, pair.first_z)
    c.second_arm = second_turn * wp.vec3(pair.second_x, pair.second_y, pair.second_z)
    c.first_com = first_turn * first_row.com
    c.second_com = second_turn * second_row.com
    c.apart = (work.position[second] - work.position[first]) + (c.second_com - c.first_com)
    middle = c.apart + (c.second_arm - c.first_arm)
    if wp.length_sq(middle) >= pair.reach * pair.reach:
        return c
    first_half = first_turn * wp.vec3(pair.first_half_x, pair.first_half_y, pair.first_half_z)
    second_half = second_turn * wp.vec3(pair.second_half_x, pair.second_half_y, pair.second_half_z)
    nearest = fractions_along(middle, first_half, second_half)
    c.first_arm += first_half * (2.0 * nearest[0] - 1.0)
    c.second_arm += second_half * (2.0 * nearest[1] - 1.0)
    c.gap = c.apart + (c.second_arm - c.first_arm)
    c.distance = wp.length(c.gap)
    return c


@func
def point_velocity(body: int, place: wp.vec3, work: ScratchRef) -> wp.vec3:
    """Velocity of a point of a body as a contact takes it, see `contact.point_contacts_of`, world, m/s.

    Args:
        place: from the body's joint point, m.
    """
    spin = work.angular_velocity[body] - work.lag_angular[body]
    return work.velocity[body] - work.lag_velocity[body] + wp.cross(spin, place)


@cache
def capsule_contact_of(turned: bool) -> Any:
    """The Warp function of what two capsules do to each other's bodies, nothing where they are clear.

    Args:
        turned: whether the principal axes of some bodies are turned against those of their frames.
    """

    @wp.func
    def principal_axes(instance: int, body: int, model: ModelRef, work: ScratchRef) -> wp.mat33:
        if wp.static(turned):
            return work.rotation[body] * at(model.couplings.inertia_axes, instance, body)
        return work.rotation[body]

    @wp.func
    def capsule_contact(
        instance: int, first: int, second: int, model: ModelRef, work: ScratchRef, pair: CapsulePair
    ) -> Touch:
        touch = Touch()
        first_row = at(model.skeleton.row, instance, first)
        second_row = at(model.skeleton.row, instance, second)
        c = closest_points(first_row, second_row, first, second, work, pair)
        if c.distance < 0.0 or pair.stiffness <= 0.0:
            return touch
        depth = pair.first_radius + pair.second_radius - c.distance
        touch.near = wp.where(depth + pair.margin > 0.0, 1.0, 0.0)
        if depth <= 0.0 or c.distance <= 0.0:
            return touch
        normal = c.gap / c.distance
        first_arm = c.first_arm + normal * (pair.first_radius - 0.5 * depth)
        second_arm = first_arm - c.apart  # the same point, from the other centre of mass
        velocity = point_velocity(second, c.second_com + second_arm, work)
        velocity -= point_velocity(first, c.first_com + first_arm, work)
        speed = wp.dot(normal, velocity)
        h = model.time_step
        along = normal_force(depth, speed, pair.stiffness, pair.damping, h)
        if along <= 0.0:
            return touch
        first_axes = principal_axes(instance, first, model, work)
        second_axes = principal_axes(instance, second, model, work)
        both = mobility(normal, first_arm, first_axes, first_row.inertia, first_row.mass)
        both += mobility(normal, second_arm, second_axes, second_row.inertia, second_row.mass)
        along = given_way(along, h * (pair.damping + h * pair.stiffness), both)
        touch.force = normal * along
        touch.first_arm = first_arm
        touch.second_arm = second_arm
        slip = velocity - normal * speed
        slip_speed = wp.length(slip)
        if slip_speed > 0.0:
            way = slip / slip_speed
            across = friction_damping(along, slip_speed, pair.tangential_damping, pair.friction)
            both = mobility(way, first_arm, first_axes, first_row.inertia, first_row.mass)
            both += mobility(way, second_arm, second_axes, second_row.inertia, second_row.mass)
            touch.force -= way * given_way(across * slip_speed, h * across, both)
        return touch

    return capsule_contact


@cache
def body_contact_of(turned: bool) -> ForceKind:
    """The kind of force between bodies that touch, see `capsule_contact_of`."""
    return ForceKind(touch=capsule_contact_of(turned), parameters=CapsulePair, state=1)
