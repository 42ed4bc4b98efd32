"""What an object and a body do to each other where the body's shape, as a capsule, touches it.

The force acts on both, equal and opposite at one point, so that momentum is kept to the last digit. As with bodies
that touch each other, what is stiff gives way over the step as if the body were free of its joints.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.contact.body_contact import mobility, point_velocity
from warpmuscle.kernels.contact.contact import friction_damping
from warpmuscle.kernels.object_structs import ObjectCapsule, ObjectMotion, ObjectRow
from warpmuscle.kernels.objects.bounce import bounce, eased
from warpmuscle.kernels.objects.hinge import object_mobility
from warpmuscle.kernels.objects.shape import between, nearest_on_segment
from warpmuscle.kernels.structs import ModelRef, ScratchRef, at


@wp.struct
class ObjectTouch:
    """What a body and an object do to each other at one point, world axes."""

    force: wp.vec3  # N, on the body; its opposite acts on the object
    body_arm: wp.vec3  # m, to that point from the centre of mass of the body
    object_arm: wp.vec3  # m, from the middle of the object


@cache
def object_touch_of(turned: bool, hinges: bool = False) -> Any:
    """The Warp function of what an object and a body do to each other, nothing where they are clear.

    Args:
        turned: whether the principal axes of some bodies are turned against those of their frames.
        hinges: whether some objects turn about an axis alone.
    """

    @wp.func
    def object_touch(
        instance: int,
        body: int,
        moves: bool,
        hinged: bool,
        capsule: ObjectCapsule,
        row: ObjectRow,
        motion: ObjectMotion,
        model: ModelRef,
        work: ScratchRef,
    ) -> ObjectTouch:
        touch = ObjectTouch()
        to_body = work.rotation[body]
        apart = work.position[body] + to_body * capsule.middle - motion.place
        reach = capsule.reach + row.reach
        if wp.length_sq(apart) >= reach * reach:
            return touch
        rotation = wp.quat_to_matrix(motion.orientation)
        core = row.half - wp.vec3(
            wp.min(row.rounding, row.half[0]), wp.min(row.rounding, row.half[1]), wp.min(row.rounding, row.half[2])
        )
        middle = wp.transpose(rotation) * apart
        along = wp.transpose(rotation) * (to_body * capsule.half)
        t = nearest_on_segment(middle, along, core)
        near = between(middle + along * t, core)
        radius = row.radius + row.rounding
        depth = radius + capsule.radius - near.distance
        if depth <= 0.0:
            return touch
        normal = rotation * near.normal
        object_arm = rotation * near.on_box + normal * (radius - 0.5 * depth)
        if near.distance < 0.0:
            object_arm = rotation * near.on_box + normal * (capsule.radius * -0.5)
        body_row = at(model.skeleton.row, instance, body)
        com = to_body * body_row.com
        body_arm = motion.place + object_arm - work.position[body] - com
        velocity = point_velocity(body, com + body_arm, work)
        velocity -= motion.velocity + wp.cross(motion.spin, object_arm)
        speed = wp.dot(normal, velocity)
        h = model.time_step
        axes = to_body
        if wp.static(turned):
            axes = to_body * at(model.couplings.inertia_axes, instance, body)
        both = mobility(normal, body_arm, axes, body_row.inertia, body_row.mass)
        if moves:
            if wp.static(hinges):
                both += object_mobility(normal, object_arm, row, motion, hinged)
            else:
                both += mobility(normal, object_arm, rotation, row.inertia, row.mass)
        b = bounce(depth, speed, row.stiffness, row.damping_ratio, both, h)
        if b.along <= 0.0:
            return touch
        pressing = eased(b.along, b.gives, both)
        touch.force = normal * pressing
        touch.body_arm = body_arm
        touch.object_arm = object_arm
        slip = velocity - normal * speed
        slipping = wp.length(slip)
        if slipping > 0.0:
            way = slip / slipping
            across = friction_damping(pressing, slipping, row.tangential_damping, row.friction)
            both = mobility(way, body_arm, axes, body_row.inertia, body_row.mass)
            if moves:
                if wp.static(hinges):
                    both += object_mobility(way, object_arm, row, motion, hinged)
                else:
                    both += mobility(way, object_arm, rotation, row.inertia, row.mass)
            touch.force -= way * eased(across * slipping, h * across, both)
        return touch

    return object_touch
