"""Muscle reflexes: excitations from what muscles, joints, feet and trunk feel, leg by leg in stance and in swing.

After Geyer and Herr 2010, A muscle-reflex model that encodes principles of legged mechanics produces human walking
dynamics and muscle activities, appendix I. A muscle hears its reflexes after its own neural delay; so all that they
sense is of the present, and the delay line of the muscle makes it late.
"""

import warp as wp

from warpmuscle.kernels.algebra.spatial import heading
from warpmuscle.kernels.contact.contact import body_weight
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.reflex_structs import (
    ALWAYS,
    ANGLE,
    BY_LOAD,
    BY_OTHER_LOAD,
    CONSTANT,
    FALLING,
    FORCE,
    LEAN,
    LEAN_AT_LIFT,
    LENGTH,
    LOAD,
    NEGATIVE,
    POSITIVE,
    RISING,
    STANCE,
    SWING,
    VELOCITY,
    ReflexPlan,
    ReflexRow,
)
from warpmuscle.kernels.structs import ModelRef, MuscleRow, ScratchRef, StateRef, at


@func
def forward_lean(up: wp.vec3, velocity: wp.vec3, frame: wp.quat) -> wp.vec2:
    """How far a body leans forward, rad, and how fast, rad/s.

    Args:
        up: the axis of the body that points up when it stands, world. velocity: its angular velocity, world, rad/s.
        frame: the character's heading.
    """
    seen = wp.quat_rotate_inv(frame, up)
    return wp.vec2(wp.atan2(seen[2], seen[1]), wp.quat_rotate_inv(frame, velocity)[0])


@func
def part_of_signal(signal: wp.vec2, row: ReflexRow, part: int) -> float:
    """The signal beyond its offset, looked ahead by its rate: all of it, or its positive or negative part."""
    value = signal[0] - row.offset + row.lead * signal[1]
    if part == POSITIVE:
        return wp.max(value, 0.0)
    if part == NEGATIVE:
        return wp.min(value, 0.0)
    return value


@func
def acts(plan: ReflexPlan, rate: float, stance: bool, trailing: bool) -> bool:
    """Whether a reflex acts in this phase of its leg, and with its signal moving this way."""
    if plan.moving == RISING and rate <= 0.0:
        return False
    if plan.moving == FALLING and rate >= 0.0:
        return False
    if plan.during == ALWAYS:
        return True
    if plan.during == STANCE:
        return stance
    if plan.during == SWING:
        return not stance
    return trailing


@func
def reflex_term(
    plan: ReflexPlan, row: ReflexRow, signal: wp.vec2, stance: bool, trailing: bool, load: float, other_load: float
) -> float:
    """What a reflex adds to the excitation of its muscle.

    Args:
        signal: what it senses, and its rate, 1/s. stance: whether the leg is loaded. trailing: whether the other one
            has landed since it did. load, other_load: of both legs, body weights.
    """
    if not acts(plan, signal[1], stance, trailing):
        return 0.0
    value = row.gain * part_of_signal(signal, row, plan.part)
    if plan.times == BY_LOAD:
        value *= load
    elif plan.times == BY_OTHER_LOAD:
        value *= other_load
    return value


@func
def leg_load(instance: int, side: int, model: ModelRef, state: StateRef) -> float:
    """Vertical ground force on a leg in the step before, body weights."""
    weight = body_weight(instance, model)
    return wp.max(state.foot_force[instance, side][1], 0.0) / weight


@func
def of_fibre(signal: int) -> bool:
    """Whether a signal comes from a muscle."""
    return signal >= FORCE and signal <= VELOCITY


@func
def sensed_signal(
    instance: int,
    plan: ReflexPlan,
    side: int,
    lean: wp.vec2,
    load: float,
    other_load: float,
    model: ModelRef,
    state: StateRef,
) -> wp.vec2:
    """What a reflex senses, and its rate: muscles as they were in the step before, all else as it is."""
    kind = plan.signal
    if kind == CONSTANT:
        return wp.vec2(1.0, 0.0)
    if kind == LEAN:
        return lean
    if kind == LEAN_AT_LIFT:
        return wp.vec2(state.muscles.lean_at_lift[instance, side], 0.0)
    if kind == ANGLE:
        joint = model.skeleton.plan[plan.source]
        return wp.vec2(state.coordinates[instance, joint.coordinate_start], state.speeds[instance, joint.speed_start])
    if of_fibre(kind):
        fibre = state.muscles.sensed[instance, plan.source]
        if kind == FORCE:
            return wp.vec2(fibre[2], 0.0)
        if kind == LENGTH:
            return wp.vec2(fibre[0], fibre[1])
        return wp.vec2(fibre[1], 0.0)
    return wp.vec2(wp.where(kind == LOAD, load, other_load), 0.0)


@func
def trunk_lean(model: ModelRef, work: ScratchRef) -> wp.vec2:
    """Lean of the trunk and its rate, see `forward_lean`."""
    body = model.reflexes.trunk
    up = work.rotation[body] * wp.vec3(0.0, 1.0, 0.0)
    return forward_lean(up, work.angular_velocity[body], heading(work.orientation[0]))


@func
def feel_ground(instance: int, lean: wp.vec2, model: ModelRef, state: StateRef):
    """Which legs stand, which one landed last, and the lean at which each left the ground. One lane calls it."""
    threshold = at(model.reflexes.bounds, instance, 0)[0]
    stance = state.simbicon.stance[instance]
    for k in range(2):
        side = wp.where(k == 0, 1 - stance, stance)  # of legs that land together, the controller's stance leg leads
        stands = leg_load(instance, side, model, state) > threshold
        stood = state.muscles.stands[instance, side] == 1
        if stands and not stood:
            state.muscles.landed[instance] = side
        if stood and not stands:
            state.muscles.lean_at_lift[instance, side] = lean[0]
        state.muscles.stands[instance, side] = wp.where(stands, 1, 0)


@func
def reflex_excitation(instance: int, muscle: int, lean: wp.vec2, model: ModelRef, state: StateRef) -> float:
    """Excitation of a muscle by its reflexes, from the least one to 1."""
    reflexes = model.reflexes
    span = reflexes.span[muscle]
    side = span.side
    stance = state.muscles.stands[instance, side] == 1
    trailing = stance and state.muscles.stands[instance, 1 - side] == 1 and state.muscles.landed[instance] != side
    load = leg_load(instance, side, model, state)
    other_load = leg_load(instance, 1 - side, model, state)
    total = wp.float32(0.0)
    for k in range(span.first, span.end):
        plan = reflexes.plan[k]
        signal = sensed_signal(instance, plan, side, lean, load, other_load, model, state)
        if state.step[instance] > 0 or not of_fibre(plan.signal):  # before the first step no fibre has been felt
            total += reflex_term(plan, at(reflexes.row, instance, k), signal, stance, trailing, load, other_load)
    return wp.clamp(total, at(reflexes.bounds, instance, 0)[1], 1.0)


@func
def reflex_force(instance: int, muscle: int, asked: float, row: MuscleRow, model: ModelRef, state: StateRef) -> float:
    """Force that is wanted of a muscle, N: by its reflexes if it has any, else what torques ask for."""
    wanted = asked
    span = model.reflexes.span[muscle]
    if span.end > span.first:
        wanted = row.f_max * state.muscles.reflex[instance, muscle]
    return wanted


@func
def added_reflex_force(
    instance: int, muscle: int, asked: float, row: MuscleRow, model: ModelRef, state: StateRef
) -> float:
    """Force that is wanted of a muscle, N: what torques ask for, and what its reflexes add."""
    wanted = asked
    span = model.reflexes.span[muscle]
    if span.end > span.first:
        wanted = asked + row.f_max * state.muscles.reflex[instance, muscle]
    return wanted


@func
def as_asked(instance: int, muscle: int, asked: float, row: MuscleRow, model: ModelRef, state: StateRef) -> float:
    """Force that is wanted of a muscle, N: what torques ask for. So where only what it feels is to be told."""
    return asked


@func
def reflex_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """Excitations of all muscles that have reflexes. Ends with a barrier."""
    lean = trunk_lean(model, work)
    if lane == 0:
        feel_ground(instance, lean, model, state)
    synchronize()
    for m in range(lane, model.muscles.count, lanes):
        span = model.reflexes.span[m]
        if span.end > span.first:
            state.muscles.reflex[instance, m] = reflex_excitation(instance, m, lean, model, state)
    synchronize()
