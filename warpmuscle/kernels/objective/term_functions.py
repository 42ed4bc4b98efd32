"""Terms of the objective: what each adds in one step.

Each term is a function of one muscle, of one body, or of the whole instance; what else there is to say of it stands in
`objective_terms.py`, and `term_sums.py` sums them up.
"""

from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.angles import pd_error
from warpmuscle.kernels.algebra.spatial import heading_angle, turn_about_x
from warpmuscle.kernels.body.limits import limit_stage
from warpmuscle.kernels.contact.contact import body_weight
from warpmuscle.kernels.contact.gait_cycle import foot_part, part_by_time, step_part
from warpmuscle.kernels.curve.curves import active_force_length, force_velocity
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.muscle.metabolics import (
    bhargava_power,
    bhargava_strict_power,
    margaria_power,
    umberger_power,
    wang_power,
)
from warpmuscle.kernels.muscle.muscle import LARGEST_SPEED, bounded_passive
from warpmuscle.kernels.objective.declaration import Scope
from warpmuscle.kernels.objective.failure import above_ground, turn_between
from warpmuscle.kernels.objective.objective_terms import TERMS
from warpmuscle.kernels.structs import LEFT, RIGHT, ModelRef, ScratchRef, StateRef, at

LARGEST_MISS = wp.constant(16.0)  # of a moment, squared standard deviations: beyond four, farther off is no worse
HUMAN_STEP_WIDTH = wp.constant(0.08)  # m, of people who walk (Murray et al. 1964, 1970: 0.071 to 0.081)


@wp.struct
class MuscleWork:
    """What a muscle does in a step."""

    activation: float
    excitation: float
    length: float  # m, of the fibre
    speed: float  # m/s, of the fibre, lengthening
    force: float  # N


@func
def effort_squared(instance: int, m: int, w: MuscleWork, model: ModelRef) -> float:
    """a^2."""
    return w.activation * w.activation


@func
def effort_cubed(instance: int, m: int, w: MuscleWork, model: ModelRef) -> float:
    """a^3."""
    return w.activation * w.activation * w.activation


@func
def mass_effort_squared(instance: int, m: int, w: MuscleWork, model: ModelRef) -> float:
    """a^2 of every kilogram of muscle, as of its volume."""
    return at(model.muscles.mass, instance, m) * w.activation * w.activation


@func
def mass_effort_cubed(instance: int, m: int, w: MuscleWork, model: ModelRef) -> float:
    """a^3 of every kilogram of muscle, as of its volume."""
    return at(model.muscles.mass, instance, m) * w.activation * w.activation * w.activation


@func
def curves_of(instance: int, m: int, model: ModelRef) -> int:
    """The curves of a muscle: those of all muscles, unless they have shapes of their own (see `shaped_curves.py`)."""
    return model.muscles.model


@func
def contractile_force(instance: int, m: int, w: MuscleWork, model: ModelRef) -> float:
    """Force of the active part of the fibre, N, never negative."""
    row = at(model.muscles.row, instance, m)
    l_opt = row.l_opt
    v = wp.clamp(w.speed / (l_opt * row.v_max), -LARGEST_SPEED, LARGEST_SPEED)
    curves = curves_of(instance, m, model)
    multiplier = active_force_length(curves, w.length / l_opt) * force_velocity(curves, v, w.activation)
    return wp.max(w.activation * multiplier * row.f_max, 0.0)


@func
def metabolic_wang(instance: int, m: int, w: MuscleWork, model: ModelRef) -> float:
    """Metabolic power, W, see `metabolics.wang_power`."""
    row = at(model.muscles.row, instance, m)
    l_opt = row.l_opt
    return wang_power(
        w.activation, w.excitation, w.length / l_opt, w.speed, contractile_force(instance, m, w, model), 0.0,
        row.slow_fibres, at(model.muscles.mass, instance, m), model.negative_share,
    )  # fmt: skip


@func
def metabolic_bhargava(instance: int, m: int, w: MuscleWork, model: ModelRef) -> float:
    """Metabolic power, W, see `metabolics.bhargava_power`."""
    row = at(model.muscles.row, instance, m)
    l_opt = row.l_opt
    return bhargava_power(
        w.activation, w.excitation, w.length / l_opt, w.speed, contractile_force(instance, m, w, model), 0.0,
        row.slow_fibres, at(model.muscles.mass, instance, m), model.negative_share,
    )  # fmt: skip


@func
def metabolic_bhargava_strict(instance: int, m: int, w: MuscleWork, model: ModelRef) -> float:
    """Metabolic power, W, see `metabolics.bhargava_strict_power`."""
    row = at(model.muscles.row, instance, m)
    l_opt = row.l_opt
    return bhargava_strict_power(
        w.activation, w.excitation, w.length / l_opt, w.speed, contractile_force(instance, m, w, model), 0.0,
        row.slow_fibres, at(model.muscles.mass, instance, m), model.negative_share,
    )  # fmt: skip


@func
def metabolic_margaria(instance: int, m: int, w: MuscleWork, model: ModelRef) -> float:
    """Metabolic power, W, see `metabolics.margaria_power`."""
    row = at(model.muscles.row, instance, m)
    l_opt = row.l_opt
    return margaria_power(
        w.activation, w.excitation, w.length / l_opt, w.speed, contractile_force(instance, m, w, model), 0.0,
        row.slow_fibres, at(model.muscles.mass, instance, m), model.negative_share,
    )  # fmt: skip


@func
def metabolic_umberger(instance: int, m: int, w: MuscleWork, model: ModelRef) -> float:
    """Metabolic power, W, see `metabolics.umberger_power`."""
    row = at(model.muscles.row, instance, m)
    l_opt = row.l_opt
    return umberger_power(
        w.activation, w.excitation, w.length / l_opt, w.speed, contractile_force(instance, m, w, model),
        active_force_length(curves_of(instance, m, model), w.length / l_opt), row.slow_fibres,
        at(model.muscles.mass, instance, m), model.negative_share, row.v_max, l_opt,
    )  # fmt: skip


@func
def passive_force(instance: int, m: int, w: MuscleWork, model: ModelRef) -> float:
    """Force of the passive fibre, N."""
    row = at(model.muscles.row, instance, m)
    return row.f_max * bounded_passive(curves_of(instance, m, model), w.length / row.l_opt)


@func
def fibre_range(instance: int, m: int, w: MuscleWork, model: ModelRef) -> float:
    """Squared optimal lengths by which a fibre is beyond those of active force, 0.5 to 1.5 (Zajac 1989)."""
    over = w.length / at(model.muscles.row, instance, m).l_opt
    beyond = wp.max(wp.max(0.5 - over, over - 1.5), 0.0)
    return beyond * beyond


@func
def applied_torque(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """Magnitude of the torque that drives a joint, N m."""
    return wp.length(work.torque[body])


@func
def torque_of_limits(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> wp.vec3:
    """Torque of a joint's limits, N m, world axes."""
    if model.skeleton.plan[body].has_limits == 0:
        return wp.vec3(0.0, 0.0, 0.0)
    torque = work.torque[body]
    stiffness = work.stiffness[body]
    limit_stage(instance, body, model, state, work)
    excess = work.torque[body] - torque
    work.torque[body] = torque
    work.stiffness[body] = stiffness
    return excess


@func
def joint_limits(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """Magnitude of the torque of a joint's limits, N m."""
    return wp.length(torque_of_limits(instance, body, model, state, work))


@func
def smoothness(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """Squared acceleration of a joint's speeds in the step before, rad^2/s^4."""
    total = wp.float32(0.0)
    for k in range(model.skeleton.plan[body].speed_start, model.skeleton.plan[body].speed_end):
        total += state.accelerations[instance, k] * state.accelerations[instance, k]
    return total


@func
def bin_of(part: float, bins: int) -> int:
    """Which of so many equal parts of a cycle a part of it, 0 to 1, is in."""
    return wp.clamp(int(part * float(bins)), 0, bins - 1)


@func
def tracking(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """Squared angle between a joint and that of the tracked gait, rad^2.

    Both are compared at the same phase of the same stance, or, if the gait is given from one contact of the left foot
    to the next, at the same part of that cycle. There, where no controller has a phase either, nothing but the time
    tells this part before the foot has landed twice: a gait of known period counts by it, another one not at all.
    """
    if model.reference_bins == 0:
        return 0.0
    part = step_part(instance, LEFT, state)
    if model.reference_by_contact == 1:
        part = foot_part(instance, LEFT, state)
        if state.foot_cycle[instance, LEFT].length <= 0.0 and instance >= state.simbicon.phase.shape[0]:
            if model.reference_period <= 0.0:
                return 0.0
            part = part_by_time(state.foot_cycle[instance, LEFT], model.reference_begin, model.reference_period)
    row = bin_of(part, 2 * model.reference_bins)
    relative = wp.quat_inverse(work.orientation[model.skeleton.plan[body].parent]) * work.orientation[body]
    error = pd_error(relative, model.reference[row, body])
    return model.tracked[body] * wp.dot(error, error)


@func
def norms(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """Squared difference of a joint's sagittal angle and that of human legs, in half-widths of the norm.

    Both are compared at the same part of the leg's gait cycle, from one contact of its foot to the next.
    """
    if model.norm_bins == 0 or model.norm_scale[body] == 0.0:
        return 0.0
    row = bin_of(foot_part(instance, model.norm_side[body], state), model.norm_bins)
    relative = wp.quat_inverse(work.orientation[model.skeleton.plan[body].parent]) * work.orientation[body]
    deviation = model.norm_scale[body] * turn_about_x(relative) - model.norm[row, body]
    return deviation * deviation


@func
def norm_moments(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """Squared difference of a leg joint's sagittal moment per mass and people's, in standard deviations, at most 16.

    The moment is what muscles, torques and the joint's limits do about the parent's x axis. Both are compared at the
    same part of the leg's gait cycle, from one contact of its foot to the next.
    """
    if model.norm_bins == 0 or model.moment_scale[body] == 0.0:
        return 0.0
    row = bin_of(foot_part(instance, model.norm_side[body], state), model.norm_bins)
    torque = work.torque[body] + torque_of_limits(instance, body, model, state, work)
    sagittal = wp.quat_rotate_inv(work.orientation[model.skeleton.plan[body].parent], torque)[0]
    per_mass = sagittal / at(model.skeleton.total_mass, instance, 0)
    deviation = model.moment_scale[body] * per_mass - model.norm_moment[row, body]
    return wp.min(deviation * deviation, LARGEST_MISS)


@func
def speed(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """Squared difference of the forward speed of the centre of mass and the target speed, m^2/s^2."""
    error = work.center[1][2] - at(model.objective, instance, 0).target_speed
    return error * error


@func
def heading(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """Squared difference of the heading and the desired heading, rad^2."""
    error = turn_between(heading_angle(work.orientation[0]), at(model.heading, instance, 0))
    return error * error


@func
def head(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """Squared angular velocity of the head, rad^2/s^2."""
    w = work.angular_velocity[model.head]
    return wp.dot(w, w)


@func
def ground_force(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """Vertical force on each foot beyond its bound, over body weight, summed, of the step before."""
    weight = body_weight(instance, model)
    bound = at(model.objective, instance, 0).ground_force_bound
    left = wp.max(state.foot_force[instance, 0][1] / weight - bound, 0.0)
    return left + wp.max(state.foot_force[instance, 1][1] / weight - bound, 0.0)


@func
def step_width(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """Squared difference of each foot's last step width and people's, m^2, summed; of a foot that has landed twice."""
    total = wp.float32(0.0)
    for side in range(LEFT, RIGHT + 1):
        cycle = state.foot_cycle[instance, side]
        if cycle.landings > 1:
            total += (cycle.width - HUMAN_STEP_WIDTH) * (cycle.width - HUMAN_STEP_WIDTH)
    return total


@func
def stride_speed(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """Squared difference of each foot's speed over its last stride and the target speed, m^2/s^2, summed.

    It leaves free how the speed changes within a stride. Before a foot has landed twice, the speed of the centre of
    mass counts in its place; that of a foot that does not land for longer than its last stride took goes down.
    """
    target = at(model.objective, instance, 0).target_speed
    total = wp.float32(0.0)
    for side in range(LEFT, RIGHT + 1):
        cycle = state.foot_cycle[instance, side]
        speed = work.center[1][2]
        if cycle.landings > 1:
            speed = (cycle.place[2] - cycle.before[2]) / wp.max(cycle.length, cycle.since)
        total += (speed - target) * (speed - target)
    return total


@func
def norm_force(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """Squared difference of each foot's vertical force and that of human walking, in half-widths, of the step before.

    Both are compared at the same part of the foot's gait cycle, from one of its contacts to the next.
    """
    if model.norm_bins == 0:
        return 0.0
    weight = body_weight(instance, model)
    total = wp.float32(0.0)
    for side in range(LEFT, RIGHT + 1):
        human = model.norm_force[bin_of(foot_part(instance, side, state), model.norm_bins)]
        error = state.foot_force[instance, side][1] / weight - human
        total += error * error
    return total / (model.norm_force_band * model.norm_force_band)


@func
def rise(instance: int, model: ModelRef, state: StateRef, work: ScratchRef, total: float) -> float:
    """What the centre of mass comes above the highest place that it has had, over the time step.

    Heights are above the plane of the ground, and `total` is the sum so far: how far it had come above its start.
    """
    above = above_ground(instance, work.center[0], model) - state.start_height[instance]
    return wp.max(above / model.time_step - total, 0.0)


SECOND: dict[Scope, str] = {"muscle": "m", "body": "body", "instance": "model"}  # argument of terms of a scope


def _functions(scope: Scope) -> dict[str, Any]:
    """The functions above that terms of a scope have, by the name of their sum."""
    names = [name for term in TERMS.values() if term.scope == scope for name in term.sums]
    if missing := [name for name in names if not isinstance(globals().get(name), wp.Function)]:
        raise TypeError(
            f"the term {missing[0]} of objective/objective_terms.py in kernels has no function "
            "in objective/term_functions.py, above what takes it there"
        )
    for name in names:
        taken = globals()[name].func.__code__.co_varnames[: globals()[name].func.__code__.co_argcount]
        if taken[1] != SECOND[scope]:
            raise TypeError(f"the term {name} is declared to be of each {scope}, but takes ({', '.join(taken)})")
    return {name: globals()[name] for name in names}


MUSCLE_TERMS, BODY_TERMS, INSTANCE_TERMS = _functions("muscle"), _functions("body"), _functions("instance")
CYCLE_TERMS = {term.name for term in TERMS.values() if term.follows_cycles}
