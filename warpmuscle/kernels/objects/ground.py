"""Contacts of an object with the ground: the corners of its box, with the spheres about them, and points between them.

Ground that is not flat may come up between the corners. There, points of edges and faces touch it, by how much deeper
they are than any corner; on a plane none is.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import cross_rows
from warpmuscle.kernels.contact.belts import belt_velocity
from warpmuscle.kernels.contact.body_contact import mobility
from warpmuscle.kernels.contact.contact import ContactSum, contact_tensor, friction_damping, minus_skew_product
from warpmuscle.kernels.contact.terrain import (
    ENDLESS_TOP,
    FLAT,
    Footing,
    footing,
    has_patches,
    nearest_footing,
    patch_below,
    rise_at,
)
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.object_structs import ObjectMotion, ObjectRow
from warpmuscle.kernels.objects.bounce import bounce
from warpmuscle.kernels.objects.nearest_ground import nearest_ground
from warpmuscle.kernels.objects.shape import PARTS, corner, is_another, is_between, part_of
from warpmuscle.kernels.structs import ModelRef, at

DEEPER = wp.constant(1.0e-5)  # m, by which a point is deeper than all corners at least, or rounding would count


@func
def is_above_all(instance: int, height: float, row: ObjectRow, motion: ObjectMotion, model: ModelRef) -> bool:
    """Whether an object is higher than any ground that it could touch.

    Args:
        height: of its middle above the ground's plane, m.
    """
    place = at(model.contacts.terrain.place, instance, 0)
    top = place.top
    if top >= wp.static(ENDLESS_TOP):
        top = rise_at(instance, motion.place[0], motion.place[2], model)[0] + place.steepest * row.reach
    return height - at(model.contacts.normal, instance, 0)[1] * top > row.reach


@func
def add_contacts(total: wp.ref[ContactSum], more: ContactSum):
    """Add contacts to others of the same object."""
    total.a += more.a
    total.b += more.b
    total.c += more.c
    total.force += more.force
    total.moment += more.moment


@cache
def ground_contacts_of(terrain: int, moves: bool = False) -> Any:
    """The Warp function of all contacts of an object with the ground, about its middle.

    Args:
        terrain: whether the ground is FLAT, RISES, or is PATCHED besides, see `contact.terrain`.
        moves: whether it moves along itself, see `contact.belts`.
    """
    rises, patched = terrain != FLAT, has_patches(terrain)

    @wp.func
    def pressed(
        instance: int, step: int, row: ObjectRow, motion: ObjectMotion, rotation: wp.mat33, arm: wp.vec3,
        below: Footing, depth: float, model: ModelRef,
    ) -> ContactSum:  # fmt: skip
        total = ContactSum()
        h = model.time_step
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
            total.force = below.normal * b.along - slip * across
            total.c = contact_tensor(below.normal, b.gives, h * across)
            total.b = cross_rows(r, total.c)
            total.a = minus_skew_product(total.b, r)
            total.moment = wp.cross(r, total.force)
        return total

    @wp.func
    def ground_contacts(instance: int, step: int, row: ObjectRow, motion: ObjectMotion, model: ModelRef) -> ContactSum:
        total = ContactSum()
        below = Footing()
        below.normal = at(model.contacts.normal, instance, 0)
        below.height = wp.dot(below.normal, motion.place) - at(model.contacts.height, instance, 0)
        normal = below.normal
        height = below.height
        if at(model.contacts.ground, instance, 0).stiffness <= 0.0:
            return total
        if wp.static(not rises):
            if height > row.reach:
                return total
        elif is_above_all(instance, height, row, motion, model):
            return total
        rotation = wp.quat_to_matrix(motion.orientation)
        deepest = wp.float32(0.0)
        for number in range(8):
            if is_another(number, row.half):
                arm = rotation * corner(number, row.half)
                if wp.static(rises):
                    below = nearest_ground(instance, normal, height, arm, motion.place + arm, row.radius, model)
                depth = row.radius - below.height - wp.dot(below.normal, arm)
                deepest = wp.max(deepest, depth)
                if depth > 0.0:
                    found = pressed(instance, step, row, motion, rotation, arm, below, depth, model)
                    add_contacts(total, found)
        if wp.static(rises):
            for number in range(wp.static(PARTS * PARTS * PARTS)):
                if is_between(number, row.half):
                    arm = rotation * part_of(number, row.half)
                    point = motion.place + arm
                    below = footing(normal, height, arm, rise_at(instance, point[0], point[2], model))
                    if row.radius - below.height - wp.dot(below.normal, arm) > deepest + DEEPER:
                        below = nearest_footing(instance, normal, height, arm, point, row.radius, model)
                        depth = row.radius - below.height - wp.dot(below.normal, arm) - deepest
                        if depth > DEEPER:
                            found = pressed(instance, step, row, motion, rotation, arm, below, depth, model)
                            add_contacts(total, found)
        return total

    return ground_contacts
