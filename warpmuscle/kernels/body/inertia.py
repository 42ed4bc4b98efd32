"""Inertia of the bodies before any joint is eliminated, and what gravity, limits, contacts and pushes do to them."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import symmetric, symmetric_outer, symmetric_rotated, symmetric_times
from warpmuscle.kernels.body.limits import limit_stage
from warpmuscle.kernels.body.resistance import resistance_stage
from warpmuscle.kernels.contact.contact import contact_stage_of
from warpmuscle.kernels.contact.contact_laws import SPRING, TOUCHING, body_contacts_of
from warpmuscle.kernels.contact.terrain import FLAT
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.main_memory import ahead_of_inertia, rotation_of
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at


@func
def inertia_about_joint(rotation: wp.mat33, inertia: wp.vec3, mass: float, com: wp.vec3) -> symmetric:
    """Rotational inertia of a body about its joint, world axes, kg m^2: R diag(I) R^T + m (c.c - c c^T).

    Args:
        inertia: principal moments about the centre of mass. com: c, from the joint, world axes, m.
    """
    s = symmetric_rotated(rotation, inertia) + symmetric_outer(com, -mass)
    d = mass * wp.dot(com, com)
    return symmetric(s[0] + d, s[1], s[2], s[3] + d, s[4], s[5] + d)


@func
def gyroscopic_moment(angular_velocity: wp.vec3, inertia: symmetric) -> wp.vec3:
    """w x (I w), N m."""
    return wp.cross(angular_velocity, symmetric_times(inertia, angular_velocity))


@cache
def body_inertia_of(turned: bool) -> Any:
    """The Warp function of inertia of a body about its joint, and the force that gravity and its own motion ask for.

    Args:
        turned: whether the principal axes of some bodies are turned against those of their frames.
    """

    @wp.func
    def body_inertia(instance: int, body: int, model: ModelRef, work: ScratchRef):
        skeleton = model.skeleton
        row = at(skeleton.row, instance, body)
        rotation = rotation_of(body, work)
        angular = work.angular_velocity[body]
        mass = row.mass
        c = rotation * row.com
        if wp.static(turned):
            rotation = rotation * at(model.couplings.inertia_axes, instance, body)
        a = inertia_about_joint(rotation, row.inertia, mass, c)
        weight = wp.vec3(0.0, -mass * at(model.gravity, instance, 0), 0.0)
        work.block_a[body] = a
        work.block_b[body] = wp.skew(c * mass)
        work.block_c[body] = symmetric(mass, 0.0, 0.0, mass, 0.0, mass)
        work.bias_moment[body] = gyroscopic_moment(angular, a) - wp.cross(c, weight)
        work.bias_force[body] = wp.cross(angular, wp.cross(angular, c)) * mass - weight

    return body_inertia


@func
def push_now(instance: int, state: StateRef) -> wp.vec3:
    """Force that pushes the root in this step, N."""
    step = state.step[instance]
    if step >= state.push_steps[instance, 0] and step < state.push_steps[instance, 1]:
        return state.push[instance]
    return wp.vec3(0.0)


@cache
def inertia_stage_of(
    turned: bool = False, contact: int = SPRING, terrain: int = FLAT, resistance: bool = False, moves: bool = False
) -> Any:
    """The Warp function of inertia, gravity, velocity products, limits, contacts and pushes of every body.

    It ends with a barrier.

    Args:
        turned: see `body_inertia_of`. contact: law of the ground's contacts. terrain: see
            `contact.point_contacts_of`. resistance: whether some joints have armature or damping.
        moves: whether the ground moves along itself.
    """
    body_inertia = body_inertia_of(turned)
    resist = resistance_stage if resistance else None
    contact_stage = contact_stage_of(body_contacts_of(contact, terrain, moves), TOUCHING[contact])

    @wp.func
    def inertia_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
        if lane == 0:
            work.flags[0] = 0
        synchronize()
        step = 0
        if wp.static(moves):
            step = state.step[instance]
        for i in range(lane, model.body_count, lanes):
            ahead_of_inertia(wp.min(i + lanes, model.body_count - 1), work)
            body_inertia(instance, i, model, work)
            if i == 0:
                work.bias_force[0] = work.bias_force[0] - push_now(instance, state)
            if model.skeleton.plan[i].has_limits == 1:
                limit_stage(instance, i, model, state, work)
            if wp.static(resistance):
                resist(instance, i, model, state, work)
            contact_stage(instance, i, step, model, work)
        synchronize()

    return inertia_stage
