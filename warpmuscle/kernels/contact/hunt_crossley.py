"""Hunt-Crossley contact of spheres with the ground, as OpenSim 4.6 has it, and its smooth variant.

The force of a sphere of radius R at depth d, with c the dissipation (Hunt 1975; Sherman 2011), is along the normal

    f = k d^(3/2) (1 + 3/2 c d'),    k = 4/3 sqrt(R) (E^(2/3)/2)^(3/2) for a stiffness E of sphere and ground

and across it f (min(v/v_t, 1) (mu_d + 2 (mu_s - mu_d)/(1 + (v/v_t)^2)) + mu_v v) at a slip v. It acts in the middle of
the depth. The smooth variant (Serrancoli 2019) has hyperbolic tangents in place of the bounds, so that spheres push a
little before they touch. Over a step the force is f0 - K a, as in `contact.py`: damping and friction are taken at the
end of the step, so that no slip is unstable, and elasticity as by Newmark's method with beta = 1/4, which is stable at
any stiffness and loses no energy (Newmark 1959).
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import cross_rows
from warpmuscle.kernels.contact.belts import belt_velocity
from warpmuscle.kernels.contact.beneath import about_body_of, beneath_sphere_of, plane_of_way_of
from warpmuscle.kernels.contact.contact import ContactSum, contact_tensor, minus_skew_product
from warpmuscle.kernels.contact.terrain import FLAT, Footing, has_patches, has_walls, patch_below
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ContactMaterial, ModelRef, ScratchRef, at

BETA = 0.25  # of Newmark's method
MARGIN = 12.0  # over hertz_smoothing: before it a smooth contact is less than 1e-10 of what it is at this depth


@func
def hertz_force(depth: float, hertz: float) -> wp.vec2:
    """Elastic force, N, and its slope, N/m; none outside the ground."""
    root = wp.sqrt(wp.max(depth, 0.0))
    return wp.vec2(hertz * root * root * root, 1.5 * hertz * root)


@func
def smooth_hertz_force(depth: float, hertz: float, smoothing: float, constant: float) -> wp.vec2:
    """Elastic force of the smooth variant, N, and its slope, N/m."""
    square = depth * depth + constant
    root = wp.sqrt(wp.sqrt(square))
    force = hertz * root * root * root
    bend = wp.tanh(smoothing * depth)
    part = 0.5 + 0.5 * bend
    slope = force * (1.5 * depth / square * part + 0.5 * smoothing * (1.0 - bend * bend))
    return wp.vec2(force * part, slope)


@func
def dissipated(rate: float, dissipation: float) -> wp.vec2:
    """What the elastic force is multiplied by at a rate of depth, m/s, and the derivative; the ground never pulls."""
    factor = 1.0 + 1.5 * dissipation * rate
    if factor <= 0.0:
        return wp.vec2(0.0, 0.0)
    return wp.vec2(factor, 1.5 * dissipation)


@func
def smoothly_dissipated(rate: float, dissipation: float, smoothing: float) -> wp.vec2:
    """The same for the smooth variant; its derivative is not negative."""
    factor = 1.0 + 1.5 * dissipation * rate
    bend = wp.tanh(smoothing * (rate + 1.0 / wp.max(1.5 * dissipation, 1.0e-9)))
    part = 0.5 + 0.5 * bend
    slope = 1.5 * dissipation * part + factor * 0.5 * smoothing * (1.0 - bend * bend)
    return wp.vec2(factor * part, wp.max(slope, 0.0))


@func
def friction_coefficient(slip: float, material: ContactMaterial) -> float:
    """Force across the normal over the one along it and over the slip, s/m."""
    relative = slip / material.transition_velocity
    friction = material.dynamic_friction
    friction += 2.0 * (material.static_friction - friction) / (1.0 + relative * relative)
    return friction / wp.max(material.transition_velocity, slip) + material.viscous_friction


@cache
def hunt_crossley_contacts_of(smooth: bool, terrain: int = FLAT, moves: bool = False) -> Any:
    """The Warp function of all contacts of a body, as `contact.point_contacts_of`."""
    rises, patched, walls = terrain != FLAT, has_patches(terrain), has_walls(terrain)
    about_body, beneath_sphere = about_body_of(terrain), beneath_sphere_of(terrain)
    plane_of_way = plane_of_way_of(terrain)

    @wp.func
    def body_contacts(instance: int, body: int, step: int, model: ModelRef, work: ScratchRef) -> ContactSum:
        contacts = model.contacts
        h = model.time_step
        total = ContactSum()
        normal = at(contacts.normal, instance, 0)
        height = wp.dot(normal, work.position[body]) - at(contacts.height, instance, 0)
        if wp.static(rises):
            about = about_body(instance, body, height, model, work)
            if height > at(contacts.reach, instance, body) + about.highest:
                return total
        elif height > at(contacts.reach, instance, body):
            return total
        middle = work.velocity[body] - work.lag_velocity[body]  # as in `contact.point_contacts_of`
        spin = work.angular_velocity[body] - work.lag_angular[body]
        up = wp.transpose(work.rotation[body]) * normal
        plan = model.skeleton.plan[body]
        if wp.static(rises):
            plane = Footing()
            plane.normal = normal
            plane.height = height
            plane_up = up
        for k in range(plan.first_point, plan.end_point):
            point = at(contacts.point, instance, k)
            ways = 1  # a constant, whose loop is written out
            if wp.static(rises):
                margin = at(contacts.material, instance, k).margin
                beneath = beneath_sphere(
                    instance, body, about, plane, plane_up, point.place, point.radius, margin, model, work
                )
                if beneath.ways == 0:
                    continue
                if wp.static(walls):
                    ways = beneath.ways
            for way in range(ways):
                material = at(contacts.material, instance, k)
                if wp.static(rises):
                    below = plane_of_way(
                        instance, body, way, about, beneath, plane, point.place, point.radius, margin, model, work
                    )
                    normal = below.normal
                    height = below.height
                    up = wp.transpose(work.rotation[body]) * normal
                depth = point.radius - height - wp.dot(up, point.place)
                if depth > -material.margin:
                    if wp.static(patched):
                        patch = patch_below(instance, work.position[body] + work.rotation[body] * point.place, model)
                        material.hertz *= patch.stiffness
                        material.dissipation *= patch.damping
                        material.static_friction = wp.min(material.static_friction, patch.friction)
                        material.dynamic_friction = wp.min(material.dynamic_friction, patch.friction)
                    r = work.rotation[body] * point.place - (point.radius - 0.5 * depth) * normal
                    velocity = middle + wp.cross(spin, r)
                    if wp.static(moves):
                        velocity -= belt_velocity(instance, work.position[body][0] + r[0], step, model)
                    rate = -wp.dot(normal, velocity)
                    elastic = hertz_force(depth, material.hertz)
                    damped = dissipated(rate, material.dissipation)
                    slip = velocity + normal * rate
                    slipping = wp.length(slip)
                    if wp.static(smooth):
                        elastic = smooth_hertz_force(depth, material.hertz, material.hertz_smoothing, material.constant)
                        damped = smoothly_dissipated(rate, material.dissipation, material.hunt_crossley_smoothing)
                        slipping = wp.sqrt(wp.length_sq(slip) + material.constant)
                    along = elastic[0] * damped[0]
                    across = along * friction_coefficient(slipping, material)
                    force = normal * along - slip * across
                    gives = h * elastic[0] * damped[1] + BETA * h * h * wp.max(elastic[1] * damped[0], 0.0)
                    c = contact_tensor(normal, gives, h * wp.max(across, 0.0))  # smooth contacts may pull a little
                    b = cross_rows(r, c)
                    total.a += minus_skew_product(b, r)
                    total.b += b
                    total.c += c
                    total.force += force
                    total.moment += wp.cross(r, force)
        return total

    return body_contacts
