"""Contact as the original program has it: a soft constraint on the velocity after the step, with restitution.

A point at depth d that moves along the normal at v is to leave at

    c = max(min(p (d - d_0)/h, 1 m/s), e (-v))        with h the time step, the second of approaching points only

and pushes with f = (c - v')/s, where v' = v + h a is its velocity after the step, p the penalty (ODE's ERP), s the
softness (ODE's CFM), d_0 = 1 mm a depth without a push, and e the restitution (Smith 2006, Open Dynamics Engine v0.5,
sections 3.7 and 7.3). That is the force f0 - K a of `contact.py` with K = h/s. Which points push, and how much friction
they bear, is decided at the start of the step; the original solves for both.
"""

import warp as wp

from warpmuscle.kernels.contact import ContactSum, contact_tensor, friction_damping, minus_skew_product
from warpmuscle.kernels.spatial import cross_rows
from warpmuscle.kernels.structs import ModelRef, ScratchRef, at

FREE_DEPTH = 0.001  # m, that is not pushed out
FASTEST = 1.0  # m/s, at which depth is pushed out
SLOWEST = 1.0e-5  # m/s, of a point that bounces


@wp.func
def leaving_speed(depth: float, speed: float, penalty: float, restitution: float, time_step: float) -> float:
    """Speed along the normal, m/s, that a point is to have after the step.

    Args:
        depth: penetration, m, positive inside the ground. speed: of the point along the normal, m/s.
    """
    pushed_out = wp.min(penalty / time_step * wp.max(depth - FREE_DEPTH, 0.0), FASTEST)
    if -speed > SLOWEST:
        return wp.max(pushed_out, -restitution * speed)
    return pushed_out


@wp.func
def soft_constraint_contacts(instance: int, body: int, model: ModelRef, work: ScratchRef) -> ContactSum:
    """All contacts of one body with the ground, as `contact.body_contacts`."""
    contacts = model.contacts
    h = model.time_step
    total = ContactSum()
    normal = at(contacts.normal, instance, 0)
    height = wp.dot(normal, work.position[body]) - at(contacts.height, instance, 0)
    if height > at(contacts.reach, instance, body):
        return total
    soft = at(contacts.soft, instance, 0)
    tangential_damping = at(contacts.ground, instance, 0).tangential_damping
    middle = work.velocity[body] - work.lag_velocity[body]  # as in `contact.body_contacts`
    spin = work.angular_velocity[body] - work.lag_angular[body]
    up = wp.transpose(work.rotation[body]) * normal
    plan = model.skeleton.plan[body]
    for k in range(plan.first_point, plan.end_point):
        point = at(contacts.point, instance, k)
        depth = point.radius - height - wp.dot(up, point.place)
        if depth > 0.0:
            r = work.rotation[body] * point.place - point.radius * normal
            velocity = middle + wp.cross(spin, r)
            speed = wp.dot(normal, velocity)
            along = (leaving_speed(depth, speed, soft.penalty, soft.restitution, h) - speed) / soft.softness
            if along > 0.0:
                slip = velocity - normal * speed
                across = friction_damping(along, wp.length(slip), tangential_damping, point.friction)
                force = normal * along - slip * across
                c = contact_tensor(normal, h / soft.softness, h * across)
                b = cross_rows(r, c)
                total.a += minus_skew_product(b, r)
                total.b += b
                total.c += c
                total.force += force
                total.moment += wp.cross(r, force)
    return total
