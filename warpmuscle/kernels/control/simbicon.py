"""The SIMBICON controller: targets from a phase-driven state machine with balance feedback, PD torques, hip rules.

Yin, Loken, van de Panne 2007, as programmed in the Controller Editor Framework 1.5 (Coros, Beaudoin, van de Panne
2009). A joint torque acts positively on the parent and negatively on the child.
"""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.algebra.angles import pd_error
from warpmuscle.kernels.algebra.spatial import heading, symmetric, symmetric_rotated
from warpmuscle.kernels.algebra.spline import curve_value
from warpmuscle.kernels.body.joint import hinge_rotation
from warpmuscle.kernels.contact.ground_plane import above_ground
from warpmuscle.kernels.control.simbicon_equations import (
    clamp_torque,
    component_rotation,
    hip_damping,
    pd_inertia,
    pd_torque,
    stance_after,
    stance_share,
    strength_by_height,
    torque_bound,
    transition_due,
    unless_clamped,
)
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import any_lane, synchronize
from warpmuscle.kernels.structs import (
    RIGHT,
    ModelRef,
    RecordRef,
    ScratchRef,
    Simbicon,
    StateRef,
    at,
    nonnegative,
    not_unrolled,
)


@func
def balance_set_point(simbicon: Simbicon, instance: int, row: int, first: int, phase: float, stance: int) -> wp.vec3:
    """Desired d (first = 0) or v (first = 4) of a state; its x part changes sign in right stance."""
    k = simbicon.balance_knots
    x = curve_value(simbicon.knots, instance, k[row, first], k[row, first + 1], phase)
    z = curve_value(simbicon.knots, instance, k[row, first + 2], k[row, first + 3], phase)
    if stance == RIGHT:
        x = -x
    return wp.vec3(x, 0.0, z)


@func
def targets_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """Target orientation, strength and frame of every joint and the root. Ends with a barrier."""
    simbicon = model.simbicon
    for i in range(lane, model.body_count, lanes):
        not_unrolled()
        work.target[i] = wp.quat(0.0, 0.0, 0.0, 1.0)
        work.strength[i] = 1.0
        work.frame[i] = 0
    synchronize()
    stance = state.simbicon.stance[instance]
    row = state.simbicon.machine_state[instance]
    phase = wp.min(state.simbicon.phase[instance], 1.0)
    foot = model.feet.left
    if stance == RIGHT:
        foot = model.feet.right
    frame = heading(work.orientation[0])
    foot_center = work.position[foot] + work.rotation[foot] * at(model.skeleton.row, instance, foot).com
    distance = wp.quat_rotate_inv(frame, work.center[0] - foot_center)
    velocity = wp.quat_rotate_inv(frame, work.center[1])
    if simbicon.balance_knots[row, 7] >= 0:
        distance -= balance_set_point(simbicon, instance, row, 0, phase, stance)
        velocity -= balance_set_point(simbicon, instance, row, 4, phase, stance)
    control = simbicon.states[row]
    for t in range(control.first_trajectory + lane, control.end_trajectory, lanes):
        trajectory = simbicon.trajectories[t]
        body = wp.where(stance == RIGHT, trajectory.right_body, trajectory.left_body)
        q = wp.quat(0.0, 0.0, 0.0, 1.0)
        for c in range(trajectory.first_component, trajectory.end_component):
            q = component_rotation(simbicon, instance, c, phase, stance, distance, velocity) * q
        first = trajectory.first_knot
        end = trajectory.end_knot
        if body >= 0:
            work.target[body] = q
            work.frame[body] = trajectory.character_frame
            if not (wp.dot(q, q) < 2.0):
                work.flags[1] = 1  # no rotation; clamped torques would hide it
            if end > first:
                work.strength[body] = curve_value(simbicon.knots, instance, first, end, phase)
    synchronize()


@func
def joint_torque(instance: int, body: int, in_character_frame: bool, frame: wp.quat, model: ModelRef, work: ScratchRef):
    """PD torque of one joint, world axes, and its implicit joint inertia, into `work`."""
    simbicon = model.simbicon
    rotation = work.rotation[body]
    base = frame
    angular = work.angular_velocity[body] - work.lag_angular[body]
    if not in_character_frame:
        parent = nonnegative(model.skeleton.plan[body].parent)
        base = work.orientation[parent]
        angular = angular - work.angular_velocity[parent] + work.lag_angular[parent]
    error = pd_error(work.orientation[body], base * work.target[body])
    velocity = wp.transpose(rotation) * angular
    gains = at(simbicon.gains, instance, body)
    kp = gains.kp
    kd = gains.kd
    strength = work.strength[body]
    scale = gains.scale
    limit = gains.torque_limit
    work.stiffness[body] = symmetric(0.0)
    if model.implicit_pd == 1:
        torque = pd_torque(error, velocity, kp, kd + model.time_step * kp, strength, scale, limit)
        inertia = pd_inertia(kp, kd, strength, scale, model.time_step)
        work.stiffness[body] = symmetric_rotated(rotation, unless_clamped(inertia, torque, torque_bound(scale, limit)))
        work.torque[body] = rotation * torque
    else:
        work.torque[body] = rotation * pd_torque(error, velocity, kp, kd, strength, scale, limit)


@func
def root_torque(instance: int, frame: wp.quat, model: ModelRef, work: ScratchRef) -> wp.vec3:
    """Torque that keeps the root upright and on its heading, world, N m."""
    simbicon = model.simbicon
    rotation = work.rotation[0]
    facing = frame
    if simbicon.heading_control == 1:
        facing = hinge_rotation(wp.vec3(0.0, 1.0, 0.0), at(simbicon.hip, instance, 0).desired_heading)
    error = pd_error(work.orientation[0], facing * work.target[0])
    velocity = wp.transpose(rotation) * (work.angular_velocity[0] - work.lag_angular[0])
    gains = at(simbicon.gains, instance, 0)
    return rotation * pd_torque(error, velocity, gains.kp, gains.kd, 1.0, gains.scale, gains.torque_limit)


@func
def hip_share(share: float, torque: wp.vec3, part: wp.vec3, rotation: wp.mat33, bound: wp.vec3) -> wp.vec3:
    """A hip's torque with its share of the root's, within the limits along the thigh's axes, world, N m."""
    child = wp.transpose(rotation) * (torque + part * share)
    return rotation * clamp_torque(child, bound)


@func
def hip_bound(simbicon: Simbicon, instance: int, hip: int) -> wp.vec3:
    """Torque limits of a hip by axis of the thigh, N m."""
    gains = at(simbicon.gains, instance, hip)
    return torque_bound(gains.scale, gains.torque_limit)


@func
def hips_stage(instance: int, lane: int, frame: wp.quat, model: ModelRef, state: StateRef, work: ScratchRef):
    """Give the hips what the root needs: together with all torques on the root they make the root's PD torque."""
    simbicon = model.simbicon
    stance_hip = simbicon.left_hip
    swing_hip = simbicon.right_hip
    foot = model.feet.left
    stance_force = state.foot_force[instance, 0][1]
    swing_force = state.foot_force[instance, 1][1]
    if state.simbicon.stance[instance] == RIGHT:
        stance_hip = simbicon.right_hip
        swing_hip = simbicon.left_hip
        foot = model.feet.right
        stance_force = state.foot_force[instance, 1][1]
        swing_force = state.foot_force[instance, 0][1]
    if lane == 0:
        share = stance_share(stance_force, swing_force)
        strength = wp.clamp(work.strength[0], 0.0, 1.0)
        if share == -1.0:
            strength = 0.0
        hip = at(simbicon.hip, instance, 0)
        on_root = root_torque(instance, frame, model, work)
        for child in range(
            model.skeleton.plan[0].first_child, model.skeleton.plan[0].first_child + model.skeleton.plan[0].child_count
        ):
            not_unrolled()
            on_root += work.torque[child]
        foot_center = work.position[foot] + work.rotation[foot] * at(model.skeleton.row, instance, foot).com
        lateral = wp.quat_rotate_inv(frame, work.center[0] - foot_center)[0]
        missing = wp.quat_rotate(frame, wp.vec3(0.0, 0.0, hip.predictive_scale * 9.8 * lateral)) - on_root
        damping = 0.0
        if hip.damping > 0.0:
            spin = work.angular_velocity[0] - work.lag_angular[0]
            thigh = work.angular_velocity[stance_hip] - work.lag_angular[stance_hip]
            damping = hip_damping(spin[1] - thigh[1], hip.damping, hip.max_velocity)
        stance_torque = work.torque[stance_hip] + wp.vec3(0.0, damping, 0.0)
        work.torque[stance_hip] = hip_share(
            share * strength,
            stance_torque,
            missing,
            work.rotation[stance_hip],
            hip_bound(simbicon, instance, stance_hip),
        )
        work.torque[swing_hip] = hip_share(
            (1.0 - share) * strength,
            work.torque[swing_hip],
            missing,
            work.rotation[swing_hip],
            hip_bound(simbicon, instance, swing_hip),
        )
    synchronize()


class SimbiconStages(NamedTuple):
    """Warp functions of the controller."""

    torques: Any  # from the targets
    control: Any  # targets and torques
    held: Any  # the same, where targets are not renewed in every step


@cache
def simbicon_stages_of(above: Any) -> SimbiconStages:
    """The stages of the controller.

    Args:
        above: how far a point is above the ground, m: `above_ground`, or `above_terrain` where it is not flat.
    """

    @func
    def torques_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
        """Torque of every joint from the targets. Ends with a barrier."""
        simbicon = model.simbicon
        frame = heading(work.orientation[0])
        swing_hip = simbicon.right_hip
        if state.simbicon.stance[instance] == RIGHT:
            swing_hip = simbicon.left_hip
        if lane == 0:
            work.torque[0] = wp.vec3(0.0, 0.0, 0.0)
        for i in range(1 + lane, model.body_count, lanes):
            in_character_frame = work.frame[i] == 1 or i == swing_hip
            joint_torque(instance, i, in_character_frame, frame, model, work)
        synchronize()
        hips_stage(instance, lane, frame, model, state, work)
        factor = strength_by_height(above(instance, work.position[0], model))
        if factor < 1.0:
            for i in range(1 + lane, model.body_count, lanes):
                work.torque[i] = work.torque[i] * factor
                work.stiffness[i] = work.stiffness[i] * factor
        synchronize()

    @func
    def control_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
        """Targets and torques. Ends with a barrier."""
        targets_stage(instance, lane, lanes, model, state, work)
        torques_stage(instance, lane, lanes, model, state, work)

    @func
    def held_control_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
        """Torques towards the targets of the last step in which they were renewed. Ends with a barrier."""
        held = state.simbicon
        renewed = state.step[instance] % model.simbicon.every == 0
        if any_lane(renewed):  # neighbours at other steps pass its barriers, too
            targets_stage(instance, lane, lanes, model, state, work)
        for i in range(lane, model.body_count, lanes):
            not_unrolled()
            if renewed:
                held.target[instance, i] = work.target[i]
                held.target_plan[instance, i] = wp.vec2(work.strength[i], float(work.frame[i]))
            else:
                plan = held.target_plan[instance, i]
                work.target[i] = held.target[instance, i]
                work.strength[i] = plan[0]
                work.frame[i] = int(plan[1])
        synchronize()
        torques_stage(instance, lane, lanes, model, state, work)

    return SimbiconStages(torques_stage, control_stage, held_control_stage)


torques_stage, control_stage, held_control_stage = simbicon_stages_of(above_ground)


@func
def advance_machine(instance: int, model: ModelRef, state: StateRef):
    """Phase, state and stance after a step, with the foot forces of that step. One lane calls it."""
    simbicon = model.simbicon
    row = state.simbicon.machine_state[instance]
    stance = state.simbicon.stance[instance]
    time = at(simbicon.state_time, instance, row)
    phase = state.simbicon.phase[instance] + model.time_step / time[0]
    control = simbicon.states[row]
    if transition_due(phase, time[1], control.on_foot_down, state.foot_force[instance, 1 - stance][1]):
        row = control.next_state
        state.simbicon.machine_state[instance] = row
        state.simbicon.stance[instance] = stance_after(stance, simbicon.states[row].stance_rule)
        phase = 0.0
    state.simbicon.phase[instance] = phase


@func
def record_machine(instance: int, row: int, frame: int, state: StateRef, record: RecordRef):
    """Write phase, stance and state of the machine. One lane calls it."""
    record.simbicon.phase[row, frame] = state.simbicon.phase[instance]
    record.simbicon.stance[row, frame] = state.simbicon.stance[instance]
    record.simbicon.machine_state[row, frame] = state.simbicon.machine_state[instance]
