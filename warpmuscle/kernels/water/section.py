"""Buoyancy, drag and added mass of sections of a capsule, from tip to tip; its parts under water are whole sections.

A section is as thick as all others, and so wide that all of them have the volume of the capsule. It is under water by
the part of a disc that is below the surface, whose half height is that of the section. On each act, at its middle

    buoyancy    rho g V upwards (Archimedes)
    drag        -1/2 rho |v| (c_n A_n v_n + c_t A_t v_t), by the speeds across and along the capsule (Morison 1950)
    added mass  -M (a - w x v) - w x (M v), with M = rho V (k_n across, k_t along) of a spheroid (Lamb 1932, art. 114)

times the part that is under water. The added mass is inertia: it enters the body's articulated inertia, and no force
of the step before stands for it. Drag is linearised over the step, so that no speed is unstable.
"""

import warp as wp

from warpmuscle.kernels.algebra.spatial import cross_rows, symmetric_times
from warpmuscle.kernels.contact.body_contact import point_velocity
from warpmuscle.kernels.contact.contact import ContactSum, contact_tensor, minus_skew_product
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ScratchRef
from warpmuscle.kernels.water_structs import WaterRow

SECTIONS = 6


@func
def part_below(height: float, half_height: float) -> float:
    """Part of a disc that is below a surface, 0 to 1.

    Args:
        height: m, of its middle above the surface. half_height: m, of the disc.
    """
    s = -height / wp.max(half_height, 1.0e-9)
    if s >= 1.0:
        return 1.0
    if s <= -1.0:
        return 0.0
    return 0.5 + (wp.asin(s) + s * wp.sqrt(1.0 - s * s)) * wp.static(1.0 / 3.14159265358979)


@func
def squared_radius(place: float, half_length: float, radius: float) -> float:
    """Squared radius of a capsule, m^2, at a place along it from its middle, m.

    Args:
        half_length: m, from the middle to the tip.
    """
    into_end = wp.max(wp.abs(place) - (half_length - radius), 0.0)
    return wp.max(radius * radius - into_end * into_end, 0.0)


@func
def thickness(half_length: float) -> float:
    """Of a section, m."""
    return half_length * wp.static(2.0 / SECTIONS)


@func
def in_water(body: int, row: WaterRow, gravity: float, time_step: float, work: ScratchRef) -> ContactSum:
    """What water does to a part of a body: force and moment about its joint, and tensors as of contacts."""
    total = ContactSum()
    rotation = work.rotation[body]
    middle = rotation * row.middle
    half_length = row.reach
    axis = rotation * row.half / half_length
    thick = thickness(half_length)
    spin = work.angular_velocity[body]
    for k in range(SECTIONS):
        place = thick * (float(k) + 0.5) - half_length
        square = squared_radius(place, half_length, row.radius)
        r = middle + axis * place
        width = wp.sqrt(wp.max(square * (1.0 - axis[1] * axis[1]), 0.0)) + 0.5 * thick * wp.abs(axis[1])
        share = square * row.share
        part = part_below(work.position[body][1] + r[1] - row.level, width)
        if part > 0.0:
            displaced = row.density * row.volume * share * part
            velocity = point_velocity(body, r, work) - row.current
            speed = 0.5 * row.density * wp.length(velocity) * share * part
            drag = contact_tensor(axis, speed * row.along, speed * row.across)
            mass = contact_tensor(axis, displaced * row.added_along, displaced * row.added_across)
            full_velocity = work.velocity[body] + wp.cross(spin, r) - row.current
            turning = wp.cross(spin, full_velocity) - wp.cross(spin, wp.cross(spin, r))
            force = wp.vec3(0.0, displaced * gravity, 0.0) - symmetric_times(drag, velocity)
            force += symmetric_times(mass, turning) - wp.cross(spin, symmetric_times(mass, full_velocity))
            c = mass + drag * time_step
            b = cross_rows(r, c)
            total.a += minus_skew_product(b, r)
            total.b += b
            total.c += c
            total.force += force
            total.moment += wp.cross(r, force)
    return total
