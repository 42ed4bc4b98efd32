"""Ground contact: spring-damper points with regularised Coulomb friction, linearly implicit in the step.

A contact at point r (from the body's joint) with depth y < 0 gives the force f = f0 - K a over a step of length h,
with f0 the force at the velocity before the step, a the acceleration of the point, and K = h (d + h k) along the
normal and h d_t across it. K enters the body's articulated inertia, so that no stiffness is unstable.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import cross_rows, symmetric, symmetric_outer, symmetric_product
from warpmuscle.kernels.contact.belts import belt_velocity
from warpmuscle.kernels.contact.beneath import about_body_of, beneath_sphere_of, plane_of_way_of
from warpmuscle.kernels.contact.ground_plane import above_ground as above_ground
from warpmuscle.kernels.contact.soft_constraint import constraint_force
from warpmuscle.kernels.contact.terrain import FLAT, Footing, has_patches, has_walls, patch_below
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, at


@func
def body_weight(instance: int, model: ModelRef) -> float:
    """Weight of the whole character, N."""
    return at(model.skeleton.total_mass, instance, 0) * at(model.gravity, instance, 0)


@func
def normal_force(depth: float, speed: float, stiffness: float, damping: float, time_step: float) -> float:
    """Force of a contact along the normal at the start of a step, N: k depth - (d + h k) speed, never negative.

    Args:
        depth: penetration, m, positive inside the ground. speed: of the point along the normal, m/s.
    """
    return wp.max(stiffness * depth - (damping + time_step * stiffness) * speed, 0.0)


@func
def friction_damping(normal: float, slip: float, damping: float, friction: float) -> float:
    """Damping across the normal, N s/m: `damping` while that force stays below friction * normal, less beyond it."""
    return wp.min(damping, friction * normal / (slip + 1.0e-9))


@func
def contact_tensor(normal: wp.vec3, along: float, across: float) -> symmetric:
    """across (1 - n n^T) + along n n^T."""
    s = symmetric_outer(normal, along - across)
    return symmetric(s[0] + across, s[1], s[2], s[3] + across, s[4], s[5] + across)


@func
def minus_skew_product(b: wp.mat33, r: wp.vec3) -> symmetric:
    """-B [r]x for a product that is symmetric, as [r]x K [r]x^T is with B = [r]x K."""
    return symmetric_product(b, wp.transpose(wp.skew(r)))


@wp.struct
class ContactSum:
    """All contacts of a body: force and moment about its joint at the start of the step, and their tensors."""

    force: wp.vec3  # N
    moment: wp.vec3  # N m
    a: symmetric  # sum of [r]x K [r]x^T
    b: wp.mat33  # sum of [r]x K
    c: symmetric  # sum of K


def beneath_of(terrain: int) -> tuple[Any, Any, Any]:
    """The Warp functions of what lies beneath a body, beneath a sphere, and of its ways out; None on flat ground."""
    if terrain == FLAT:
        return None, None, None
    return about_body_of(terrain), beneath_sphere_of(terrain), plane_of_way_of(terrain)


@cache
def point_contacts_of(soft: bool, terrain: int = FLAT, moves: bool = False) -> Any:
    """The Warp function of the contacts of one body with the ground at points; zero if it is clear of it.

    Args:
        soft: whether points are soft constraints, see `soft_constraint.py`, or spring-dampers.
        terrain: whether the ground is FLAT, RISES, or is PATCHED or WALLED besides, see `terrain.py`.
        moves: whether it moves along itself, see `belts.py`.
    """
    rises, patched, walls = terrain != FLAT, has_patches(terrain), has_walls(terrain)
    (about_body, beneath_sphere, plane_of_way), patch_at = beneath_of(terrain), patch_below if patched else None
    ground_velocity, soft_force = belt_velocity if moves else None, constraint_force if soft else None

    @wp.func
    def point_contacts(instance: int, body: int, step: int, model: ModelRef, work: ScratchRef) -> ContactSum:
        h = model.time_step
        total = ContactSum()
        normal = at(model.contacts.normal, instance, 0)
        height = wp.dot(normal, work.position[body]) - at(model.contacts.height, instance, 0)
        if wp.static(rises):
            about = about_body(instance, body, height, model, work)
            if height > at(model.contacts.reach, instance, body) + about.highest:
                return total
        elif height > at(model.contacts.reach, instance, body):
            return total
        ground = at(model.contacts.ground, instance, 0)
        stiffness = ground.stiffness
        damping = ground.damping
        middle = work.velocity[body] - work.lag_velocity[body]  # the implicit step starts from the middle of the last
        spin = work.angular_velocity[body] - work.lag_angular[body]
        up = wp.transpose(work.rotation[body]) * normal
        plan = model.skeleton.plan[body]
        if wp.static(rises):
            plane = Footing()
            plane.normal = normal
            plane.height = height
            plane_up = up
        for k in range(plan.first_point, plan.end_point):
            point = at(model.contacts.point, instance, k)
            ways = 1  # a constant, whose loop is written out
            if wp.static(rises):
                beneath = beneath_sphere(
                    instance, body, about, plane, plane_up, point.place, point.radius, 0.0, model, work
                )
                if beneath.ways == 0:
                    continue
                if wp.static(walls):
                    ways = beneath.ways
            for way in range(ways):
                if wp.static(rises):
                    below = plane_of_way(
                        instance, body, way, about, beneath, plane, point.place, point.radius, 0.0, model, work
                    )
                    normal = below.normal
                    height = below.height
                    up = wp.transpose(work.rotation[body]) * normal
                depth = point.radius - height - wp.dot(up, point.place)
                if depth > 0.0:
                    r = work.rotation[body] * point.place - point.radius * normal
                    velocity = middle + wp.cross(spin, r)
                    if wp.static(moves):
                        velocity -= ground_velocity(instance, work.position[body][0] + r[0], step, model)
                    speed = wp.dot(normal, velocity)
                    friction = point.friction
                    if wp.static(patched):
                        patch = patch_at(instance, work.position[body] + r, model)
                        stiffness = ground.stiffness * patch.stiffness
                        damping = ground.damping * patch.damping
                        friction = wp.min(friction, patch.friction)
                    if wp.static(soft):
                        constraint = at(model.contacts.soft, instance, 0)
                        along = soft_force(depth, speed, constraint, h)
                        gives = h / constraint.softness
                    else:
                        along = normal_force(depth, speed, stiffness, damping, h)
                        gives = h * (damping + h * stiffness)
                    if along > 0.0:
                        slip = velocity - normal * speed
                        across = friction_damping(along, wp.length(slip), ground.tangential_damping, friction)
                        force = normal * along - slip * across
                        c = contact_tensor(normal, gives, h * across)
                        b = cross_rows(r, c)
                        total.a += minus_skew_product(b, r)
                        total.b += b
                        total.c += c
                        total.force += force
                        total.moment += wp.cross(r, force)
        return total

    return point_contacts


@cache
def contact_stage_of(contacts_of_body: Any, touches: float = 0.0) -> Any:
    """The Warp function that lets the ground act on a body, by a function such as that of `point_contacts_of`.

    Args:
        touches: N, the force from which on a body that is no foot has touched the ground; 0 for any.
    """

    @wp.func
    def contact_stage(instance: int, body: int, step: int, model: ModelRef, work: ScratchRef):
        """Add the contacts of one body to its articulated inertia and bias force, and keep what the foot needs."""
        plan = model.skeleton.plan[body]
        slot = plan.foot_slot
        if slot >= 0:
            work.contact_c[slot] = symmetric(0.0)
            work.contact_b[slot] = wp.mat33(0.0)
            work.contact_force[slot] = wp.vec3(0.0)
        if plan.end_point == plan.first_point:
            return
        total = contacts_of_body(instance, body, step, model, work)
        if wp.length_sq(total.force) == 0.0:
            return
        work.block_a[body] = work.block_a[body] + total.a
        work.block_b[body] = work.block_b[body] + total.b
        work.block_c[body] = work.block_c[body] + total.c
        work.bias_moment[body] = work.bias_moment[body] - total.moment
        work.bias_force[body] = work.bias_force[body] - total.force
        if slot >= 0:
            work.contact_c[slot] = total.c
            work.contact_b[slot] = total.b
            work.contact_force[slot] = total.force
        elif wp.static(touches == 0.0) or wp.length(total.force) > touches:
            work.flags[0] = 1

    return contact_stage
