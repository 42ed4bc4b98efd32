"""Objects that turn about an axis alone, which stands still in the world: a seesaw, a door."""

import warp as wp

from warpmuscle.kernels.algebra.spatial import full, turn
from warpmuscle.kernels.contact.body_contact import mobility
from warpmuscle.kernels.contact.contact import ContactSum
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.object_structs import ObjectMotion, ObjectRow
from warpmuscle.kernels.objects.motion import momentum_of


@wp.struct
class Axle:
    """What an object turns about, and how hard it is to turn."""

    axis: wp.vec3  # unit vector, world
    arm: wp.vec3  # m, from the axis to the object's middle
    inertia: float  # kg m^2, about the axis


@func
def axle_of(row: ObjectRow, motion: ObjectMotion) -> Axle:
    """The axle of an object that has one."""
    a = Axle()
    a.axis = wp.quat_rotate(row.orientation, row.axis)
    a.arm = -wp.quat_rotate(motion.orientation, row.pivot)
    swept = wp.cross(a.axis, a.arm)
    own = wp.quat_rotate_inv(motion.orientation, a.axis)
    a.inertia = wp.dot(own, wp.cw_mul(row.inertia, own)) + row.mass * wp.dot(swept, swept)
    return a


@func
def object_mobility(direction: wp.vec3, arm: wp.vec3, row: ObjectRow, motion: ObjectMotion, hinged: bool) -> float:
    """How a point of an object gives way to a force there, 1/kg, see `contact.body_contact.mobility`.

    Args:
        direction: unit vector. arm: m, to the point from the middle. hinged: whether it turns about an axis alone.
    """
    if hinged:
        a = axle_of(row, motion)
        lever = wp.dot(a.axis, wp.cross(a.arm + arm, direction))
        return lever * lever / a.inertia
    return mobility(direction, arm, wp.quat_to_matrix(motion.orientation), row.inertia, row.mass)


@func
def turned_on(
    row: ObjectRow, motion: ObjectMotion, force: wp.vec3, moment: wp.vec3, contacts: ContactSum, kick: float, h: float
) -> ObjectMotion:
    """The motion of a hinged object after a step, by leapfrog; its axle bears all that does not turn it.

    Args:
        force: N, at its middle, of all but the ground. moment: N m, about it. contacts: with the ground, implicit.
        kick: time that accelerations act, s: a step, or half of it in the first one.
    """
    a = axle_of(row, motion)
    swept = wp.cross(a.axis, a.arm)
    inertia = a.inertia + wp.dot(a.axis, full(contacts.a) * a.axis)
    inertia += 2.0 * wp.dot(a.axis, contacts.b * swept) + wp.dot(swept, full(contacts.c) * swept)
    rate = wp.dot(a.axis, motion.spin)
    torque = wp.dot(a.axis, moment + contacts.moment) + wp.dot(swept, force + contacts.force) - row.bearing * rate
    rate += torque / (inertia + row.bearing * kick) * kick
    m = ObjectMotion()
    m.orientation = turn(motion.orientation, row.axis * rate, h)
    pivot = row.place + wp.quat_rotate(row.orientation, row.pivot)
    m.place = pivot - wp.quat_rotate(m.orientation, row.pivot)
    m.velocity = (m.place - motion.place) / h
    m.momentum = momentum_of(a.axis * rate, m.orientation, row)
    return m
