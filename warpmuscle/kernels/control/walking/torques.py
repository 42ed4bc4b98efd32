"""Torques that make what the walking controller wants: PD, gravity borne, virtual forces, the pelvis upright."""

import warp as wp

from warpmuscle.kernels.body.joint import hinge_rotation
from warpmuscle.kernels.control.joint_values import joint_coordinate
from warpmuscle.kernels.control.simbicon_equations import stance_share
from warpmuscle.kernels.control.walking.body import (
    Leg,
    add_damping,
    add_torque,
    carried_mass,
    carried_moment,
    carry,
    damping_of,
    ground_height,
    leg_of,
    torque_on,
)
from warpmuscle.kernels.control.walking.leg import knee_angle, thigh_rotation, turned
from warpmuscle.kernels.control.walking.parameters import (
    CLEARANCE,
    FOOTHOLD,
    HEEL,
    LEG,
    LIFTED,
    LOAD,
    PHASE,
    SOLE,
    SPEED,
    STANCE,
    STANDS,
    TOE,
    Walking,
    WalkingJoint,
)
from warpmuscle.kernels.control.walking.plan import facing, standing_share, step_duration, swing_side
from warpmuscle.kernels.control.walking.pulls import Units, hinge_pull, lead_of, pull_to, turn_by, units_of
from warpmuscle.kernels.control.walking.stance import stance_leg
from warpmuscle.kernels.control.walking.swing import ARRIVES, BELOW, as_a_stair, lift, progress, way_height
from warpmuscle.kernels.control.walking.virtual_forces import gravity_torque
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at

GRIP = wp.constant(0.15)  # of a foot's length: the lever of the torque that friction bears about the vertical


@func
def hold_joint(
    body: int, own: WalkingJoint, lean: float, ahead: float, u: Units, model: ModelRef, work: ScratchRef,
    memory: wp.array[float],
) -> wp.vec3:  # fmt: skip
    """Torque on a body that is of no leg, or a toe: PD towards its place.

    Args:
        ahead: rad, by which the left thigh is ahead of the right one.
    """
    parent = model.skeleton.plan[body].parent
    base = work.orientation[parent]
    if own.upright > 0.5:
        base = facing(memory) * hinge_rotation(wp.vec3(1.0, 0.0, 0.0), lean)
    target = base * turn_by(wp.vec3(own.swing * ahead, 0.0, 0.0)) * turn_by(wp.vec3(own.x, own.y, own.z))
    relative = work.angular_velocity[body] - work.angular_velocity[parent]
    return pull_to(body, target, relative, own.kp * u.stiffness, own.kd * u.damping, work)


@func
def ankle_wanted(instance: int, phase: float, parameters: Walking, model: ModelRef, memory: wp.array[float]) -> wp.vec3:
    """Where the ankle that swings is to be at a phase, world, m."""
    lifted = wp.vec3(memory[LIFTED], memory[LIFTED + 1], memory[LIFTED + 2])
    foothold = wp.vec3(memory[FOOTHOLD], memory[FOOTHOLD + 1], memory[FOOTHOLD + 2])
    begins = as_a_stair(0.0, parameters.rise_first, (foothold[1] - lifted[1]) / memory[LEG])
    place = lifted + (foothold - lifted) * progress(phase, begins, ARRIVES)
    height = way_height(phase, lifted[1], foothold[1]) + parameters.step_height * memory[LEG] * lift(phase)
    height -= BELOW * memory[LEG] * wp.max(phase - ARRIVES, 0.0)
    if parameters.sight > 0.0 and phase < ARRIVES:
        forwards = wp.quat_rotate(facing(memory), wp.vec3(0.0, 0.0, 1.0))
        highest = ground_height(instance, place[0], place[2], model)
        toe = place + forwards * (memory[TOE] + 0.1 * memory[LEG] * (1.0 - phase))
        heel = place + forwards * memory[HEEL]
        highest = wp.max(highest, ground_height(instance, toe[0], toe[2], model))
        highest = wp.max(highest, ground_height(instance, heel[0], heel[2], model))
        over = highest + memory[SOLE] + 0.5 * parameters.step_height * memory[LEG]
        height = wp.max(height, height + (over - height) * progress(phase, 0.0, 0.25))
    return wp.vec3(place[0], height, place[2])


@func
def thigh_target(
    instance: int, leg: Leg, to_ankle: wp.vec3, angle: float, model: ModelRef, memory: wp.array[float]
) -> wp.quat:
    """Orientation of a thigh, world, at which its knee, at an angle, puts the ankle there, and bends forwards."""
    row = at(model.skeleton.row, instance, leg.shank)
    own_to_ankle = row.anchor + turned(at(model.skeleton.row, instance, leg.foot).anchor, row.axis_a, angle)
    axis = wp.quat_rotate(facing(memory), row.axis_a)
    return wp.quat_from_matrix(thigh_rotation(to_ankle, axis, own_to_ankle, row.axis_a))


@func
def ankle_from_hip(
    instance: int, leg: Leg, lead: float, duration: float, parameters: Walking, model: ModelRef, work: ScratchRef,
    memory: wp.array[float],
) -> wp.vec3:  # fmt: skip
    """Where the ankle that swings is to be in a moment, from where its hip is then, world, m."""
    place = ankle_wanted(instance, memory[PHASE] + lead / duration, parameters, model, memory)
    return place - work.position[leg.thigh] - work.velocity[leg.thigh] * lead


@func
def swing_leg(
    instance: int, leg: Leg, parameters: Walking, joints: wp.array[WalkingJoint], u: Units, model: ModelRef,
    state: StateRef, work: ScratchRef, memory: wp.array[float],
):  # fmt: skip
    """Torques of the leg that swings: its ankle is to be where the foot's way has it, its sole level."""
    gravity = at(model.gravity, instance, 0)
    duration = step_duration(parameters, memory[SPEED], memory[LEG], gravity)
    hip = joints[leg.thigh]
    knee = joints[leg.shank]
    ankle = joints[leg.foot]
    bend = ankle_from_hip(instance, leg, lead_of(knee, u), duration, parameters, model, work, memory)
    knee_row = at(model.skeleton.row, instance, leg.shank)
    shank = at(model.skeleton.row, instance, leg.foot).anchor
    sense = wp.where(at(model.skeleton.limits, instance, leg.shank).sine[0] < 0.0, -1.0, 1.0)
    angle = knee_angle(wp.length(bend), knee_row.anchor, shank, knee_row.axis_a, sense)
    reach = ankle_from_hip(instance, leg, lead_of(hip, u), duration, parameters, model, work, memory)
    straight = knee_angle(wp.length(reach), knee_row.anchor, shank, knee_row.axis_a, sense)
    target = thigh_target(instance, leg, reach, straight, model, memory)
    spin = work.angular_velocity[leg.thigh]
    torque = pull_to(leg.thigh, target, spin, hip.kp * u.stiffness, hip.kd * u.damping, work)
    bending = hinge_pull(instance, leg.shank, angle, knee, u, model, state, work)
    add_torque(leg.thigh, torque + bending, memory)  # the thigh does not feel what bends the knee
    add_torque(leg.shank, bending, memory)
    level = facing(memory) * hinge_rotation(
        wp.vec3(1.0, 0.0, 0.0), -parameters.toe_up * progress(memory[PHASE], 0.3, 1.0)
    )
    spin = work.angular_velocity[leg.foot]
    torque = pull_to(leg.foot, level, spin, ankle.kp * u.stiffness, ankle.kd * u.damping, work)
    add_torque(leg.foot, torque, memory)
    for n in range(3):
        body = wp.where(n == 0, leg.thigh, wp.where(n == 1, leg.shank, leg.foot))
        add_damping(body, wp.vec3(joints[body].kd * u.damping), memory)
        borne = gravity_torque(carried_mass(body, memory), carried_moment(body, memory), work.position[body], gravity)
        add_torque(body, borne, memory)
    sole = work.position[leg.foot] - wp.vec3(0.0, memory[SOLE], 0.0)
    memory[CLEARANCE] = sole[1] - ground_height(instance, sole[0], sole[2], model)


@func
def borne_by_hip(instance: int, thigh: int, model: ModelRef, work: ScratchRef, memory: wp.array[float]) -> wp.vec3:
    """Torque on the pelvis that bears all but the leg that stands about the hip of that, N m."""
    mass = carried_mass(0, memory) - carried_mass(thigh, memory)
    moment = carried_moment(0, memory) - carried_moment(thigh, memory)
    return gravity_torque(mass, moment, work.position[thigh], at(model.gravity, instance, 0))


@func
def keep_grip(
    instance: int, side: int, joints: wp.array[WalkingJoint], u: Units, model: ModelRef, state: StateRef,
    work: ScratchRef, memory: wp.array[float],
):  # fmt: skip
    """Let a leg that stands turn about itself by no more than what its foot's friction bears.

    A foot without load, which would spin, is turned forwards instead; that of a body that stands hangs below its hip.
    """
    leg = leg_of(side, model)
    hip = joints[leg.thigh]
    to_ankle = work.position[leg.foot] - work.position[leg.thigh]
    along = wp.normalize(to_ankle)
    if memory[STANCE] == STANDS:
        to_ankle = wp.vec3(0.0, -wp.length(to_ankle), 0.0)
    knee = joint_coordinate(instance, leg.shank, 0, model, state)
    target = thigh_target(instance, leg, to_ankle, knee, model, memory)
    spin = work.angular_velocity[leg.thigh]
    turns = pull_to(leg.thigh, target, spin, hip.kp * u.stiffness, hip.kd * u.damping, work)
    bears = 0.1 * u.weight
    if memory[STANCE] != STANDS:
        turns = along * wp.dot(along, turns)
        bears = 0.5 * u.weight
    now = wp.dot(along, torque_on(leg.thigh, memory))
    most = GRIP * (memory[TOE] - memory[HEEL]) * memory[LOAD + side]
    loaded = wp.clamp(memory[LOAD + side] / bears, 0.0, 1.0)
    add_torque(leg.thigh, along * (wp.clamp(now, -most, most) - now) + turns * (1.0 - loaded), memory)
    damping = wp.vec3(hip.kd * u.damping * (1.0 - loaded))
    if memory[STANCE] != STANDS:
        damping = wp.vec3(0.0, damping[1], 0.0)  # of the thigh, whose length is about that of the leg
    if wp.abs(now) > most:
        damping[1] -= damping_of(leg.thigh, memory)[1]  # a torque at its bound does not change with speed
    add_damping(leg.thigh, damping, memory)


@func
def turn_pelvis(
    instance: int, share: float, parameters: Walking, u: Units, model: ModelRef, state: StateRef, work: ScratchRef,
    memory: wp.array[float],
):  # fmt: skip
    """Give the hips what the pelvis needs to be upright on its heading, by their shares of the load (Yin 2007).

    Args:
        share: of the leg that stands, or of the left one, 0 to 1; -1: neither is loaded.
    """
    if share < 0.0:
        return
    side = 1 - swing_side(memory)
    stance = leg_of(side, model).thigh
    other = leg_of(1 - side, model).thigh
    target = facing(memory) * hinge_rotation(wp.vec3(1.0, 0.0, 0.0), parameters.lean)
    spin = work.angular_velocity[0]
    on_pelvis = pull_to(0, target, spin, parameters.root_kp * u.stiffness, parameters.root_kd * u.damping, work)
    turning = pull_to(0, target, spin, parameters.turn_kp * u.stiffness, parameters.turn_kd * u.damping, work)
    on_pelvis[1] = turning[1]
    on_pelvis += borne_by_hip(instance, stance, model, work, memory) * share
    on_pelvis += borne_by_hip(instance, other, model, work, memory) * (1.0 - share)
    plan = model.skeleton.plan[0]
    for child in range(plan.first_child, plan.first_child + plan.child_count):
        on_pelvis += torque_on(child, memory)
    add_torque(stance, -on_pelvis * share, memory)
    add_torque(other, -on_pelvis * (1.0 - share), memory)
    damping = wp.vec3(parameters.root_kd, parameters.turn_kd, parameters.root_kd) * u.damping
    add_damping(stance, damping * share, memory)
    add_damping(other, damping * (1.0 - share), memory)


@func
def thighs_apart(model: ModelRef, work: ScratchRef, memory: wp.array[float]) -> float:
    """By how much the left thigh is ahead of the right one, rad, about the axis across the heading."""
    frame = facing(memory)
    left = wp.quat_rotate_inv(frame, work.position[leg_of(0, model).shank] - work.position[leg_of(0, model).thigh])
    right = wp.quat_rotate_inv(frame, work.position[leg_of(1, model).shank] - work.position[leg_of(1, model).thigh])
    return wp.atan2(left[2], -left[1]) - wp.atan2(right[2], -right[1])


@func
def renew_torques(
    instance: int, parameters: Walking, joints: wp.array[WalkingJoint], model: ModelRef, state: StateRef,
    work: ScratchRef, memory: wp.array[float],
):  # fmt: skip
    """Torques of all joints on the bodies that they carry, into the memory."""
    u = units_of(instance, model, memory)
    carry(instance, model, work, memory)
    left = leg_of(0, model)
    right = leg_of(1, model)
    ahead = thighs_apart(model, work, memory)
    gravity = at(model.gravity, instance, 0)
    for body in range(1, model.body_count):
        of_left = body == left.thigh or body == left.shank or body == left.foot
        if not (of_left or body == right.thigh or body == right.shank or body == right.foot):
            held = hold_joint(body, joints[body], parameters.lean, ahead, u, model, work, memory)
            place = work.position[body]
            borne = gravity_torque(carried_mass(body, memory), carried_moment(body, memory), place, gravity)
            add_torque(body, held + borne, memory)
            add_damping(body, wp.vec3(joints[body].kd * u.damping), memory)
    side = 1 - swing_side(memory)
    share = stance_share(memory[LOAD + side], memory[LOAD + 1 - side])
    if memory[STANCE] == STANDS:
        share = standing_share(instance, parameters, model, work, memory)
        stance_leg(instance, side, share, parameters, joints, u, model, state, work, memory)
        stance_leg(instance, 1 - side, 1.0 - share, parameters, joints, u, model, state, work, memory)
        memory[CLEARANCE] = 0.0
    else:
        stance_leg(instance, side, 1.0, parameters, joints, u, model, state, work, memory)
        swing_leg(instance, leg_of(1 - side, model), parameters, joints, u, model, state, work, memory)
    turn_pelvis(instance, share, parameters, u, model, state, work, memory)
    keep_grip(instance, side, joints, u, model, state, work, memory)
    if memory[STANCE] == STANDS:
        keep_grip(instance, 1 - side, joints, u, model, state, work, memory)
