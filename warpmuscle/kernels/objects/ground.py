"""Contacts of an object with the ground: the corners of its box, with the spheres about them."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import cross_rows
from warpmuscle.kernels.contact.belts import belt_velocity
from warpmuscle.kernels.contact.body_contact import mobility
from warpmuscle.kernels.contact.contact import ContactSum, contact_tensor, friction_damping, minus_skew_product
from warpmuscle.kernels.contact.terrain import FLAT, Footing, has_patches, patch_below
from warpmuscle.kernels.object_structs import ObjectMotion, ObjectRow
from warpmuscle.kernels.objects.bounce import bounce
from warpmuscle.kernels.objects.nearest_ground import nearest_ground
from warpmuscle.kernels.objects.shape import corner, is_another
from warpmuscle.kernels.structs import ModelRef, at


@cache
def ground_contacts_of(terrain: int, moves: bool = False) -> Any:
    """The Warp function of all contacts of an object with the ground, about its middle.

    Args:
        terrain: whether the ground is FLAT, RISES, or is PATCHED besides, see `contact.terrain`.
        moves: whether it moves along itself, see `contact.belts`.
    """
    rises, patched = terrain != FLAT, has_patches(terrain)

    @wp.func
    def ground_contacts(instance: int, step: int, row: ObjectRow, motion: ObjectMotion, model: ModelRef) -> ContactSum:
        total = ContactSum()
        h = model.time_step
        below = Footing()
        below.normal = at(model.contacts.normal, instance, 0)
        below.height = wp.dot(below.normal, motion.place) - at(model.contacts.height, instance, 0)
        normal = below.normal
        height = below.height
        if at(model.contacts.ground, instance, 0).stiffness <= 0.0:
            return total
        if wp.static(not rises) and height > row.reach:
            return total
        rotation = wp.quat_to_matrix(motion.orientation)
        for number in range(8):
            if is_another(number, row.half):
                arm = rotation * corner(number, row.half)
                point = motion.place + arm
                if wp.static(rises):
                    below = nearest_ground(instance, normal, height, arm, point, row.radius, model)
                depth = row.radius - below.height - wp.dot(below.normal, arm)
                if depth > 0.0:
                    r = arm - below.normal * row.radius
                    velocity = motion.velocity + wp.cross(motion.spin, r)
                    if wp.static(moves):
                        velocity -= belt_velocity(instance, motion.place[0] + r[0], step, model)
                    speed = wp.dot(below.normal, velocity)
                    stiffness = row.stiffness
                    friction = row.ground_friction
                    if wp.static(patched):
                        patch = patch_below(instance, motion.place + r, model)
                        stiffness *= patch.stiffness
                        friction = wp.min(friction, patch.friction)
                    free = mobility(below.normal, r, rotation, row.inertia, row.mass)
                    b = bounce(depth, speed, stiffness, row.damping_ratio, free, h)
                    if b.along > 0.0:
                        slip = velocity - below.normal * speed
                        across = friction_damping(b.along, wp.length(slip), row.tangential_damping, friction)
                        force = below.normal * b.along - slip * across
                        c = contact_tensor(below.normal, b.gives, h * across)
                        moment_c = cross_rows(r, c)
                        total.a += minus_skew_product(moment_c, r)
                        total.b += moment_c
                        total.c += c
                        total.force += force
                        total.moment += wp.cross(r, force)
        return total

    return ground_contacts
