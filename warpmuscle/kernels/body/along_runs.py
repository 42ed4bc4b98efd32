"""From the root to the tips along runs of bodies (`body_structs.BodyRun`), where no joint has more than one axis.

A lane that goes along a run keeps how the body before moves to itself: what it has just stored would take as long to
come back as all that the next body needs.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import rotation_matrix
from warpmuscle.kernels.body.dynamics import along_one, give_way
from warpmuscle.kernels.body.followed_reduction import followed_of
from warpmuscle.kernels.body.joint import universal_bias
from warpmuscle.kernels.body.joint_motion import has_motion
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.main_memory import ahead_of_accelerating, ahead_of_placing, rotation_of
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import FIXED, ModelRef, ScratchRef, at, nonnegative


@wp.struct
class Moving:
    """Where a body is, and how it moves; in world axes."""

    orientation: wp.quat
    rotation: wp.mat33
    position: wp.vec3
    velocity: wp.vec3
    angular: wp.vec3
    lag_velocity: wp.vec3
    lag_angular: wp.vec3


@wp.struct
class Accelerated:
    """How a body accelerates, and what that means for those that hang on it; in world axes."""

    angular_acceleration: wp.vec3
    acceleration: wp.vec3
    position: wp.vec3
    angular: wp.vec3


@func
def moving_of(body: int, work: ScratchRef) -> Moving:
    """How a body moves that has been placed."""
    m = Moving()
    m.orientation = work.orientation[body]
    m.rotation = rotation_of(body, work)
    m.position = work.position[body]
    m.velocity = work.velocity[body]
    m.angular = work.angular_velocity[body]
    m.lag_velocity = work.lag_velocity[body]
    m.lag_angular = work.lag_angular[body]
    return m


@func
def accelerated_of(body: int, work: ScratchRef) -> Accelerated:
    """How a body accelerates, as far as that is known."""
    m = Accelerated()
    m.angular_acceleration = work.angular_acceleration[body]
    m.acceleration = work.acceleration[body]
    m.position = work.position[body]
    m.angular = work.angular_velocity[body]
    return m


@func
def place_next(instance: int, body: int, m: wp.ref[Moving], model: ModelRef, work: ScratchRef):
    """`coordinate_joint.place_any` behind a body whose motion is m, which becomes that of this one."""
    coordinate = has_motion(model.skeleton.plan[body].joint_type)
    turned = work.turned[body]
    anchor = work.anchor[body]
    rate = work.rate[body]
    gain = work.gain[body]
    parent_rate = work.parent_rate[body]
    parent_gain = work.parent_gain[body]
    turning = wp.vec3(0.0)
    moving = wp.vec3(0.0)
    turning_drift = wp.vec3(0.0)
    drift = wp.vec3(0.0)
    now = wp.vec3(0.0)
    if coordinate:
        turning = work.coordinate_turning[body]
        moving = work.coordinate_moving[body]
        turning_drift = work.coordinate_turning_drift[body]
        drift = work.coordinate_drift[body]
        now = work.coordinate_state[body]
    before = m.rotation
    w = m.angular
    q = m.orientation * turned
    rotation = rotation_matrix(q)
    r = before * anchor
    rate_a = rotation * rate
    rate_b = before * parent_rate
    lag = rotation * gain + before * parent_gain
    bias = universal_bias(w, rate_a, rate_b)
    m.velocity = m.velocity + wp.cross(w, r)
    m.lag_velocity = m.lag_velocity + wp.cross(m.lag_angular, r)
    if coordinate:
        moving = before * moving
        m.velocity = m.velocity + moving * now[1]
        m.lag_velocity = m.lag_velocity + moving * now[2]
        bias = bias + before * turning_drift
        work.coordinate_turning[body] = before * turning
        work.coordinate_moving[body] = moving
        work.coordinate_drift[body] = before * drift + 2.0 * wp.cross(w, moving * now[1])
    m.orientation = q
    m.rotation = rotation
    m.position = m.position + r
    m.angular = w + (rate_a + rate_b)
    m.lag_angular = m.lag_angular + lag
    work.orientation[body] = q
    work.rotation[body] = rotation
    work.position[body] = m.position
    work.velocity[body] = m.velocity
    work.angular_velocity[body] = m.angular
    work.lag_velocity[body] = m.lag_velocity
    work.lag_angular[body] = m.lag_angular
    work.bias[body] = bias


@cache
def accelerate_next_of(hybrid: bool) -> Any:
    """The Warp function of `followed.accelerate_followed_of` behind a body whose acceleration is known.

    Args:
        hybrid: whether motions of some joints are prescribed.
    """
    followed = followed_of(hybrid)

    @func
    def accelerate_next(instance: int, body: int, m: wp.ref[Accelerated], model: ModelRef, work: ScratchRef):
        plan = model.skeleton.plan[body]
        own = followed(body, model)
        kind = plan.joint_type
        if wp.static(hybrid):
            kind = model.motion.remaining[body]
        position = work.position[body]
        angular = work.angular_velocity[body]
        bias = work.bias[body]
        r = position - m.position
        alpha = m.angular_acceleration
        a = m.acceleration + wp.cross(alpha, r)
        x = wp.float32(0.0)
        relative = wp.vec3(0.0)
        if own >= 0:
            x = work.followed_acceleration[own]
        elif kind != FIXED:
            x = along_one(work.factor_a[body], alpha, a)
        if has_motion(plan.joint_type):
            a = a + work.coordinate_drift[body] + work.coordinate_moving[body] * x
            relative = work.coordinate_turning[body] * x
        elif kind != FIXED:
            relative = rotation_of(body, work) * at(model.skeleton.row, instance, body).axis_a * x
        alpha = alpha + bias + relative
        a = a + wp.cross(m.angular, wp.cross(m.angular, r))
        work.angular_acceleration[body] = alpha
        work.acceleration[body] = a
        work.factor_c[body] = wp.vec3(x, 0.0, 0.0)
        give_way(plan.foot_slot, alpha, a, work)
        m.angular_acceleration = alpha
        m.acceleration = a
        m.position = position
        m.angular = angular

    return accelerate_next


@cache
def pass_along_runs_of(visit: Any, motion_of: Any, ahead: Any = ahead_of_accelerating) -> Any:
    """`dynamics.forward_pass_of` run by run: a lane goes along one from its first body without waiting for others.

    Args:
        visit: `place_next` or one of `accelerate_next_of`. motion_of: what it takes from the body before.
        ahead: asks for what it takes of a body itself.
    """

    @func
    def forward_pass(instance: int, lane: int, lanes: int, model: ModelRef, work: ScratchRef):
        runs = model.couplings.run
        for level in range(model.couplings.run_levels):
            for k in range(runs[nonnegative(level)].start + lane, runs[nonnegative(level)].end, lanes):
                run = runs[nonnegative(k)]
                body = nonnegative(run.first)
                motion = motion_of(nonnegative(model.skeleton.plan[body].parent), work)
                for _ in range(run.count):
                    following = model.skeleton.plan[body].first_child
                    ahead(nonnegative(following), work)
                    visit(instance, body, motion, model, work)
                    body = nonnegative(following)
            synchronize()

    return forward_pass


place_along_runs = pass_along_runs_of(place_next, moving_of, ahead_of_placing)
