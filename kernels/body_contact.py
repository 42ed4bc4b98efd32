"""Contact of bodies with each other: capsules with a spring, a damper and regularised Coulomb friction.

The force of a pair acts on both bodies, equal and opposite at one point, so that momentum is kept to the last digit.
It is implicit over the step as if both bodies were free of their joints, which is as light as they can be: a true mass
can only be greater, so that no stiffness is unstable.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.collision import fractions_along
from warpmuscle.kernels.contact import friction_damping, normal_force
from warpmuscle.kernels.forces import Force, Wrench
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at


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
    reach: float  # of the middles; beyond it the capsules are clear of each other
    stiffness: float  # N/m
    damping: float  # N s/m
    tangential_damping: float  # N s/m, up to the friction limit
    friction: float


@wp.func
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


@wp.func
def given_way(force: float, gives: float, pair_mobility: float) -> float:
    """A force at the end of a step that was `force` at its start and falls by `gives` for a unit of acceleration, N.

    f = f0 - K a with a = w f, so f = f0 / (1 + K w).

    Args:
        gives: K, h (d + h k), kg. pair_mobility: w, 1/kg, of both bodies together.
    """
    return force / (1.0 + gives * pair_mobility)


@cache
def capsule_contact_of(turned: bool) -> Any:
    """The Warp function of what one capsule of a pair does to the body of the other, zero where they are clear.

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
        instance: int, body: int, other: int, second: int, model: ModelRef, state: StateRef, work: ScratchRef,
        pair: CapsulePair,
    ) -> Wrench:  # fmt: skip
        acting = Wrench()
        a = wp.where(second == 1, other, body)
        b = wp.where(second == 1, body, other)
        row_a = at(model.skeleton.row, instance, a)
        row_b = at(model.skeleton.row, instance, b)
        turn_a = work.rotation[a]
        turn_b = work.rotation[b]
        arm_a = turn_a * wp.vec3(pair.first_x, pair.first_y, pair.first_z)
        arm_b = turn_b * wp.vec3(pair.second_x, pair.second_y, pair.second_z)
        com_a = turn_a * row_a.com
        com_b = turn_b * row_b.com
        apart = (work.position[b] - work.position[a]) + (com_b - com_a)
        middle = apart + (arm_b - arm_a)
        if wp.length_sq(middle) >= pair.reach * pair.reach:
            return acting
        half_a = turn_a * wp.vec3(pair.first_half_x, pair.first_half_y, pair.first_half_z)
        half_b = turn_b * wp.vec3(pair.second_half_x, pair.second_half_y, pair.second_half_z)
        nearest = fractions_along(middle, half_a, half_b)
        arm_a += half_a * (2.0 * nearest[0] - 1.0)
        arm_b += half_b * (2.0 * nearest[1] - 1.0)
        gap = apart + (arm_b - arm_a)
        distance = wp.length(gap)
        depth = pair.first_radius + pair.second_radius - distance
        if depth <= 0.0 or distance <= 0.0 or pair.stiffness <= 0.0:
            return acting
        normal = gap / distance
        arm_a += normal * (pair.first_radius - 0.5 * depth)
        arm_b = arm_a - apart  # the same point, from the other centre of mass
        spin_a = work.angular_velocity[a] - work.lag_angular[a]  # as in `contact.point_contacts_of`
        spin_b = work.angular_velocity[b] - work.lag_angular[b]
        at_a = work.velocity[a] - work.lag_velocity[a] + wp.cross(spin_a, com_a + arm_a)
        at_b = work.velocity[b] - work.lag_velocity[b] + wp.cross(spin_b, com_b + arm_b)
        velocity = at_b - at_a
        speed = wp.dot(normal, velocity)
        h = model.time_step
        along = normal_force(depth, speed, pair.stiffness, pair.damping, h)
        if along <= 0.0:
            return acting
        axes_a = principal_axes(instance, a, model, work)
        axes_b = principal_axes(instance, b, model, work)
        both = mobility(normal, arm_a, axes_a, row_a.inertia, row_a.mass)
        both += mobility(normal, arm_b, axes_b, row_b.inertia, row_b.mass)
        along = given_way(along, h * (pair.damping + h * pair.stiffness), both)
        slip = velocity - normal * speed
        slip_speed = wp.length(slip)
        force = normal * along
        if slip_speed > 0.0:
            way = slip / slip_speed
            across = friction_damping(along, slip_speed, pair.tangential_damping, pair.friction)
            both = mobility(way, arm_a, axes_a, row_a.inertia, row_a.mass)
            both += mobility(way, arm_b, axes_b, row_b.inertia, row_b.mass)
            force -= way * given_way(across * slip_speed, h * across, both)
        if second == 1:
            acting.force = force
            acting.moment = wp.cross(arm_b, force)
        else:
            acting.force = -force
            acting.moment = -wp.cross(arm_a, force)
        return acting

    return capsule_contact


@cache
def body_contact_of(turned: bool) -> Force:
    """The kind of force between bodies that touch, see `capsule_contact_of`."""
    return Force(pair=capsule_contact_of(turned), parameters=CapsulePair, near=True)
