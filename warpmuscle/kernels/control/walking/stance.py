"""Torques of the leg that stands: its knee lifts and lowers the body and bears it, its ankle bears virtual forces."""

import warp as wp

from warpmuscle.kernels.control.walking.body import Leg, add_damping, add_torque, leg_of
from warpmuscle.kernels.control.walking.leg import knee_angle, reaching_length, turned
from warpmuscle.kernels.control.walking.parameters import (
    FOOTHOLD,
    HALF_WIDTH,
    HEEL,
    KNEE,
    LEG,
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
from warpmuscle.kernels.control.walking.plan import LANDS, facing, middle_of_foot, step_duration
from warpmuscle.kernels.control.walking.pulls import Units, hinge_pull, pull_to
from warpmuscle.kernels.control.walking.swing import ARRIVES, LOWERS, PUSHED, PUSHES, as_a_stair, progress
from warpmuscle.kernels.control.walking.virtual_forces import force_torque, within_foot
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at

REACHES = wp.constant(0.98)  # of a leg's length, how far from its hip the ankle that swings is put


@func
def balance_force(parameters: Walking, u: Units, model: ModelRef, work: ScratchRef, memory: wp.array[float]) -> wp.vec3:
    """Virtual force on the centre of mass, world, N: it has the wanted speed, or stays between both feet."""
    frame = facing(memory)
    velocity = wp.quat_rotate_inv(frame, work.center[1])
    force = wp.vec3(0.0)
    if memory[STANCE] == STANDS:
        middle = 0.5 * (
            middle_of_foot(model.feet.left, parameters, memory, work)
            + middle_of_foot(model.feet.right, parameters, memory, work)
        )
        off = wp.quat_rotate_inv(frame, work.center[0] - middle)
        per_metre = 2.0 * u.weight / memory[LEG]
        force = wp.vec3(0.0, 0.0, -off[2] * per_metre - 2.0 * u.force * velocity[2])
    else:
        force = wp.vec3(0.0, 0.0, parameters.speed_gain * u.force * (memory[SPEED] - velocity[2]))
    return wp.quat_rotate(frame, force)


@func
def lowered_knee(
    instance: int, leg: Leg, parameters: Walking, model: ModelRef, work: ScratchRef, memory: wp.array[float]
) -> float:
    """Angle of the knee that stands at which the hip is as low as the leg that swings must have it, rad."""
    duration = step_duration(parameters, memory[SPEED], memory[LEG], at(model.gravity, instance, 0))
    hip = work.position[leg.thigh]
    going = work.velocity[leg.thigh] * (wp.max(LANDS - memory[PHASE], 0.0) * duration)
    foothold = wp.vec3(memory[FOOTHOLD], memory[FOOTHOLD + 1], memory[FOOTHOLD + 2])
    to_foothold = foothold - hip - wp.vec3(going[0], 0.0, going[2])
    reach = REACHES * (memory[LEG] - memory[SOLE])
    length = reaching_length(to_foothold, work.position[leg.foot] - hip, reach)
    row = at(model.skeleton.row, instance, leg.shank)
    sense = wp.where(at(model.skeleton.limits, instance, leg.shank).sine[0] < 0.0, -1.0, 1.0)
    angle = knee_angle(length, row.anchor, at(model.skeleton.row, instance, leg.foot).anchor, row.axis_a, sense)
    return sense * wp.max(sense * angle, parameters.stance_knee)


@func
def straightening_knee(instance: int, leg: Leg, parameters: Walking, model: ModelRef, memory: wp.array[float]) -> float:
    """Angle of the knee that stands as it lifts the body from where its foot came down, evenly by its length, rad."""
    row = at(model.skeleton.row, instance, leg.shank)
    shank = at(model.skeleton.row, instance, leg.foot).anchor
    short = wp.length(row.anchor + turned(shank, row.axis_a, memory[KNEE]))
    long = wp.length(row.anchor + turned(shank, row.axis_a, parameters.stance_knee))
    done = progress(
        memory[PHASE], 0.0, as_a_stair(parameters.straightens, parameters.lifts, (long - short) / memory[LEG])
    )
    sense = wp.where(at(model.skeleton.limits, instance, leg.shank).sine[0] < 0.0, -1.0, 1.0)
    return knee_angle(short + (long - short) * done, row.anchor, shank, row.axis_a, sense)


@func
def push_of(parameters: Walking, memory: wp.array[float], gravity: float) -> float:
    """How far the centre of pressure is on its way to the toes of the leg that pushes off, 0 to 1."""
    relative = memory[SPEED] / wp.sqrt(gravity * memory[LEG])
    return wp.clamp(parameters.push_off * relative, 0.0, 1.0) * progress(memory[PHASE], PUSHES, PUSHED)


@func
def stance_leg(
    instance: int, side: int, share: float, parameters: Walking, joints: wp.array[WalkingJoint], u: Units,
    model: ModelRef, state: StateRef, work: ScratchRef, memory: wp.array[float],
):  # fmt: skip
    """Torques of knee and ankle of a leg that stands, straight, with its share of virtual forces; hips come last."""
    leg = leg_of(side, model)
    knee = joints[leg.shank]
    ankle = joints[leg.foot]
    force = balance_force(parameters, u, model, work, memory) * share
    along_leg = wp.normalize(work.position[leg.thigh] - work.position[leg.foot])
    bears = along_leg * (parameters.weight_support * u.weight * share)
    bent = parameters.stance_knee
    if memory[STANCE] != STANDS:
        bent = straightening_knee(instance, leg, parameters, model, memory)
        low = lowered_knee(instance, leg, parameters, model, work, memory)
        bent += (low - bent) * progress(memory[PHASE], LOWERS, ARRIVES)
    torque = hinge_pull(instance, leg.shank, bent, knee, u, model, state, work)
    torque += force_torque(bears, work.position[leg.thigh], work.position[leg.shank])
    add_torque(leg.shank, torque, memory)
    add_damping(leg.shank, wp.vec3(knee.kd * u.damping), memory)
    load = memory[LOAD + side]
    rotation = work.rotation[leg.foot]
    spin = work.angular_velocity[leg.foot] - work.angular_velocity[leg.shank]
    torque = force_torque(force, work.center[0], work.position[leg.foot]) - spin * (ankle.kd * u.damping)
    load *= parameters.sole_use
    within = within_foot(wp.transpose(rotation) * torque, load, memory[HEEL], memory[TOE], memory[HALF_WIDTH])
    if memory[STANCE] != STANDS:
        push = push_of(parameters, memory, at(model.gravity, instance, 0))
        within[0] = within[0] + push * (memory[LOAD + side] * memory[TOE] - within[0])
    loaded = wp.clamp(memory[LOAD + side] / (0.2 * u.weight), 0.0, 1.0)
    level = pull_to(
        leg.foot, facing(memory), work.angular_velocity[leg.foot], ankle.kp * u.stiffness, ankle.kd * u.damping, work
    )
    add_torque(leg.foot, rotation * within * loaded + level * (1.0 - 0.7 * loaded), memory)
    add_damping(leg.foot, wp.vec3(ankle.kd * u.damping * (1.0 - 0.7 * loaded)), memory)
