"""What drives each joint: the controller's torque, its muscles, what is passive, or a mixture by axis.

A joint torque acts positively on the parent and negatively on the child, as in the original program.
"""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.algebra.spatial import full, symmetric, symmetric_outer, symmetric_part
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import (
    BALL,
    BY_TORQUE,
    MIXED,
    UNIVERSAL,
    ModelRef,
    ScratchRef,
    StateRef,
    at,
    nonnegative,
    not_unrolled,
)

IMPLICIT_SHARE = 0.55  # of a step that implicit damping looks ahead: 0.5 is most accurate, more settles faster


@wp.struct
class JointDrive:
    """What acts on a joint."""

    torque: wp.vec3  # N m, on the parent, world
    inertia: wp.mat33  # kg m^2, by which it is implicit, world


class PassiveForce(NamedTuple):
    """What acts besides on joints that are driven in several ways, with its part of the implicit inertia.

    The passive part is a projector, see `joint_projector`. Damping is asked for unless all PD is implicit.
    """

    add: Any  # (instance, body, parent, rotation, drive, passive part, model, work): adds its own to the `JointDrive`
    add_damping: Any  # (instance, body, inertia of muscles' damping, passive part, model, work) -> with that of its own


@func
def ball_projector(rotation: wp.mat33, weight: wp.vec3) -> wp.mat33:
    """Takes from a torque what acts about the child's axes, each times its weight."""
    return rotation * wp.diag(weight) * wp.transpose(rotation)


@func
def hinge_projector(axis: wp.vec3, weight: float) -> wp.mat33:
    """Takes from a torque what acts about a hinge, times the weight."""
    return wp.outer(axis, axis) * weight


@func
def universal_projector(a: wp.vec3, b: wp.vec3, weight: wp.vec3) -> wp.mat33:
    """Takes from a torque what acts about the axes a and b, each times its weight, without changing the other's part.

    With dual vectors a* and b*, so that a* . a = 1 and a* . b = 0: the torque w_a (a . T) a* + w_b (b . T) b*.
    """
    c = wp.dot(a, b)
    scale = 1.0 / (1.0 - c * c)
    return wp.outer((a - c * b) * scale, a) * weight[0] + wp.outer((b - c * a) * scale, b) * weight[1]


@func
def joint_projector(instance: int, body: int, weight: wp.vec3, model: ModelRef, work: ScratchRef) -> wp.mat33:
    """What a torque does about the degrees of freedom of a joint, each times its weight, world axes."""
    plan = model.skeleton.plan[body]
    row = at(model.skeleton.row, instance, body)
    kind = plan.joint_type
    rotation = work.rotation[body]
    if kind == BALL:
        return ball_projector(rotation, weight)
    a = rotation * row.axis_a
    if kind == UNIVERSAL:
        b = work.rotation[plan.parent] * row.axis_b
        return universal_projector(a, b, weight)
    return hinge_projector(a, weight[0])


@wp.func_native(
    snippet="""
auto total = wp::vec3();
#if defined(__CUDA_ARCH__)
#pragma unroll 8
#endif
for (int crossing = first; crossing < end; ++crossing)
    total += *wp::address(arm, crossing) * *wp::address(force, *wp::address(muscle, crossing));
return total;
"""
)
def torque_of_forces(
    first: int, end: int, arm: wp.array[wp.vec3], force: wp.array[float], muscle: wp.array[int]
) -> wp.vec3: ...  # the sum of F r of some crossings in order, of which a GPU fetches several at once


@func
def muscle_torque(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> wp.vec3:
    """Torque of the muscles on a joint, world, N m: the sum of F r (Bergmann 2017, eq. 8 and 9)."""
    paths = model.paths
    first = nonnegative(paths.crossing_start[body])
    end = paths.crossing_start[body + 1]
    arms = state.muscles.moment_arm[nonnegative(instance)]
    return torque_of_forces(first, end, arms, state.muscles.force[nonnegative(instance)], paths.crossing_muscle)


@func
def pulled_torque(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> wp.vec3:
    """The same from the F r of all crossings in the working set."""
    total = wp.vec3(0.0)
    for crossing in range(model.paths.crossing_start[body], model.paths.crossing_start[body + 1]):
        not_unrolled()
        total += work.pull[nonnegative(crossing)]
    return total


@cache
def mixed_torque_of(passive: PassiveForce) -> Any:
    """The Warp function (instance, body, muscles, model, work) for a joint that is driven in several ways.

    It puts torque and implicit inertia into the working set, which has the joint velocities; `muscles` is their torque,
    world, N m.
    """
    add_passive = passive.add

    @wp.func
    def mixed_torque(instance: int, body: int, muscles: wp.vec3, model: ModelRef, work: ScratchRef):
        actuation = model.actuation
        parent = nonnegative(model.skeleton.plan[body].parent)
        rotation = work.rotation[body]
        by_torque = joint_projector(instance, body, actuation.by_torque[body], model, work)
        by_muscles = joint_projector(instance, body, actuation.by_muscles[body], model, work)
        passive_part = joint_projector(instance, body, actuation.passive[body], model, work)
        drive = JointDrive()
        drive.torque = by_torque * work.torque[body] + by_muscles * muscles
        drive.inertia = by_torque * full(work.stiffness[body]) * wp.transpose(by_torque)
        add_passive(instance, body, parent, rotation, drive, passive_part, model, work)
        work.torque[body] = drive.torque
        work.stiffness[body] = symmetric_part(drive.inertia)

    return mixed_torque


@cache
def implicit_damping_stage_of(passive: PassiveForce) -> Any:
    """The stage that adds the damping of muscles, linearised over the step, to the inertia of their joints: h d r r^T.

    What a muscle's shortening at one joint does about another one stays explicit, which is stable for two joints. What
    is passive does the same, unless all PD is implicit. It ends with a barrier.
    """
    add_damping = passive.add_damping

    @wp.func
    def implicit_damping_stage(
        instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef
    ):
        paths = model.paths
        for i in range(1 + lane, model.body_count, lanes):
            drive = model.actuation.drive[i]
            if drive != BY_TORQUE:
                inertia = symmetric(0.0)
                for crossing in range(paths.crossing_start[i], paths.crossing_start[i + 1]):
                    damping = state.muscles.damping[instance, paths.crossing_muscle[crossing]]
                    inertia += symmetric_outer(
                        state.muscles.moment_arm[instance, crossing], damping * (IMPLICIT_SHARE * model.time_step)
                    )
                if drive == MIXED:
                    by_muscles = joint_projector(instance, i, model.actuation.by_muscles[i], model, work)
                    added = by_muscles * full(inertia) * wp.transpose(by_muscles)
                    if model.implicit_pd == 0:
                        passive_part = joint_projector(instance, i, model.actuation.passive[i], model, work)
                        added = add_damping(instance, i, added, passive_part, model, work)
                    inertia = symmetric_part(added)
                work.stiffness[i] = work.stiffness[i] + inertia
        synchronize()

    return implicit_damping_stage


@cache
def actuation_stage_of(muscle_torque: Any, passive: PassiveForce, mixed: bool = True) -> Any:
    """The Warp function that puts in place of the controller's torques what really drives the joints.

    It ends with a barrier.

    Args:
        muscle_torque: `muscle_torque`, or `pulled_torque` if the pulls are in the working set.
        passive: what acts on joints that are driven in different ways at once. mixed: whether any may be so.
    """
    mixed_torque = mixed_torque_of(passive)

    @wp.func
    def actuation_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
        for i in range(1 + lane, model.body_count, lanes):
            drive = model.actuation.drive[i]
            if drive != BY_TORQUE:
                torque = muscle_torque(instance, i, model, state, work)
                if wp.static(mixed) and drive == MIXED:
                    mixed_torque(instance, i, torque, model, work)
                else:
                    work.torque[i] = torque
                    work.stiffness[i] = symmetric(0.0)
        synchronize()

    return actuation_stage
