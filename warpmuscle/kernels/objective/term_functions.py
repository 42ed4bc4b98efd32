"""Terms of the objective: what each adds in one step, and the stage that sums them up.

Each term is a function of one muscle, of one body, or of the whole instance; what else there is to say of it stands in
`objective_terms.py`. Which ones are summed is compiled in.
"""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.algebra.angles import pd_error
from warpmuscle.kernels.algebra.spatial import heading_angle, turn_about_x
from warpmuscle.kernels.body.limits import limit_stage
from warpmuscle.kernels.contact.contact import body_weight
from warpmuscle.kernels.contact.gait_cycle import foot_part, step_part
from warpmuscle.kernels.curve.curves import active_force_length, force_velocity
from warpmuscle.kernels.curve.custom_curves import OwnCurves, with_curves
from warpmuscle.kernels.curve.shaped_curves import Shaped
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.muscle.metabolics import bhargava_power, bhargava_strict_power, umberger_power, wang_power
from warpmuscle.kernels.muscle.muscle import LARGEST_SPEED, bounded_passive
from warpmuscle.kernels.objective.causes import TERM, cause_of, checked
from warpmuscle.kernels.objective.declaration import Scope
from warpmuscle.kernels.objective.failure import turn_between
from warpmuscle.kernels.objective.objective_terms import TERMS
from warpmuscle.kernels.structs import LARGEST, LEFT, RIGHT, ModelRef, ScratchRef, State, StateRef, at, rolled

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
def applied_torque(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """Magnitude of the torque that drives a joint, N m."""
    return wp.length(work.torque[body])


@func
def joint_limits(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    """Magnitude of the torque of a joint's limits, N m."""
    if model.skeleton.plan[body].has_limits == 0:
        return 0.0
    torque = work.torque[body]
    stiffness = work.stiffness[body]
    limit_stage(instance, body, model, state, work)
    excess = wp.length(work.torque[body] - torque)
    work.torque[body] = torque
    work.stiffness[body] = stiffness
    return excess


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
    to the next, at the same part of that cycle.
    """
    if model.reference_bins == 0:
        return 0.0
    part = step_part(instance, LEFT, state)
    if model.reference_by_contact == 1:
        part = foot_part(instance, LEFT, state)
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


def _functions(scope: Scope) -> dict[str, Any]:
    """The functions above that terms of a scope have, by the name of their sum."""
    names = [name for term in TERMS.values() if term.scope == scope for name in term.sums]
    if missing := [name for name in names if not isinstance(globals().get(name), wp.Function)]:
        raise TypeError(
            f"the term {missing[0]} of objective/objective_terms.py in kernels has no function "
            "in objective/term_functions.py"
        )
    return {name: globals()[name] for name in names}


MUSCLE_TERMS, BODY_TERMS, WHOLE_TERMS = _functions("muscle"), _functions("body"), _functions("whole")
CYCLE_TERMS = {term.name for term in TERMS.values() if term.follows_cycles}


@func
def sane(value: float, work: ScratchRef) -> wp.float64:
    """The value in double precision; nothing for what is too large or not a number, and the step has diverged."""
    if wp.abs(value) < LARGEST:
        return wp.float64(value)
    work.flags[1] = 1
    return wp.float64(0.0)


@func
def effort_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """Add this step's feedback torque of every joint to its integral (Bergmann 2017, section 6). No barrier.

    One sum a joint, in double precision, so that the result does not depend on lanes or on chunks of steps.
    """
    for i in range(1 + lane, model.body_count, lanes):
        rolled()
        effort = wp.length(work.torque[i])
        if effort < LARGEST:
            # not `+=`, which would be an atomic operation
            state.torque_integral[instance, i] = state.torque_integral[instance, i] + wp.float64(effort)
        else:
            work.flags[1] = 1


@func
def no_muscle_terms(instance: int, m: int, w: MuscleWork, model: ModelRef, state: StateRef, work: ScratchRef):
    """No term is summed over muscles."""


@func
def no_body_terms(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """No term is summed over bodies."""


@func
def no_whole_terms(instance: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """No term of the whole instance is summed."""


class ObjectiveKind(NamedTuple):
    """Names of the terms that a step sums up, in the order of their sums, and the functions of terms of others."""

    muscle: tuple[str, ...] = ()
    body: tuple[str, ...] = ()
    whole: tuple[str, ...] = ()
    own: tuple[tuple[str, Any], ...] = ()  # by name, Warp functions like those of `MUSCLE_TERMS` and so on
    desired: tuple[str, ...] = ()  # those of `whole` that see the torques which the controller wants
    conditions: tuple[tuple[str, Any], ...] = ()  # by name, failing conditions of others, see `failing_stage_of`
    progress: bool = False  # whether an instance that stands still has failed
    accelerated: tuple[str, ...] = ()  # those of `body` and `whole` that see accelerations
    cycles: bool = False  # whether some of others ask where feet are in their gait cycles
    earned: tuple[str, ...] = ()  # of those of others, that are to be great; what they sum up lowers the cost

    @property
    def follows_cycles(self) -> bool:
        """Whether a step has to follow the gait cycles of the feet."""
        return self.cycles or bool(CYCLE_TERMS & {*self.body, *self.whole})

    def cause(self, name: str) -> int:
        """The number of a term of others, see `causes.py`; 0 of any other."""
        names = [own for own, _ in self.own]
        return cause_of(TERM, names.index(name)) if name in names else 0


def muscle_functions(
    kind: ObjectiveKind, own: OwnCurves | Shaped | None = None, curves: int | None = None
) -> tuple[Any, ...]:
    """The Warp functions of the terms over muscles; metabolic powers with the curves that muscles have.

    Args:
        own, curves: as of `muscle_kind.MuscleKind`; no curves: those of all sets.

    With each stands its number if it is a term of others, see `causes.py`, else 0.
    """
    given = dict(kind.own)
    return tuple(
        (given[name], kind.cause(name)) if name in given else (with_curves(MUSCLE_TERMS[name], own, curves), 0)
        for name in kind.muscle
    )


@cache
def muscle_terms_of(terms: tuple[Any, ...]) -> Any:
    """The Warp function (instance, muscle, what it does, model, state, work) that adds a step to the terms' sums."""
    every = no_muscle_terms
    for index, (term, cause) in enumerate(terms):
        every = _and_muscle_term(every, term, index, cause)
    return every


def _counted(cause: int) -> Any:
    """The Warp function (value, instance, state, work) that takes a term's value into its sum, see `sane`.

    Args:
        cause: number of a term of others, which is to blame if it gives no number; 0 of any other.
    """

    @wp.func
    def of_others(value: float, instance: int, state: StateRef, work: ScratchRef) -> wp.float64:
        return sane(checked(value, instance, wp.static(cause), state, work), work)

    @wp.func
    def shipped(value: float, instance: int, state: StateRef, work: ScratchRef) -> wp.float64:
        return sane(value, work)

    return of_others if cause > 0 else shipped


def takes_state(function: Any) -> bool:
    """Whether the Warp function of a muscle takes the state, where the memory of a part of the scene's own is."""
    return any(kind is State or getattr(kind, "value_type", None) is State for kind in function.input_types.values())


def _and_muscle_term(others: Any, term: Any, index: int, cause: int) -> Any:
    counted, with_state = _counted(cause), takes_state(term)

    @wp.func
    def add(instance: int, m: int, w: MuscleWork, model: ModelRef, state: StateRef, work: ScratchRef):
        others(instance, m, w, model, state, work)
        if wp.static(with_state):
            value = counted(term(instance, m, w, model, state), instance, state, work)
        else:
            value = counted(term(instance, m, w, model), instance, state, work)
        state.muscle_terms[instance, index, m] = state.muscle_terms[instance, index, m] + value

    return add


def _and_body_term(others: Any, term: Any, index: int, cause: int) -> Any:
    counted = _counted(cause)

    @wp.func
    def add(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef):
        others(instance, body, model, state, work)
        value = counted(term(instance, body, model, state, work), instance, state, work)
        state.body_terms[instance, index, body] = state.body_terms[instance, index, body] + value

    return add


def _and_whole_term(others: Any, term: Any, index: int, cause: int) -> Any:
    counted = _counted(cause)

    @wp.func
    def add(instance: int, model: ModelRef, state: StateRef, work: ScratchRef):
        others(instance, model, state, work)
        value = counted(term(instance, model, state, work), instance, state, work)
        state.whole_terms[instance, index] = state.whole_terms[instance, index] + value

    return add


@cache
def objective_stage_of(kind: ObjectiveKind, accelerated: bool = False) -> Any:
    """The Warp function that adds a step of the terms of bodies and of the whole to their sums. No barrier.

    One sum a body, in double precision, so that results depend neither on lanes nor on chunks of steps.

    Args:
        accelerated: of those that see accelerations, else of all but these.
    """
    body_terms, whole_terms = no_body_terms, no_whole_terms
    own, other = dict(kind.own), set(kind.desired)
    for index, name in enumerate(kind.body):
        if (name in kind.accelerated) == accelerated:
            body_terms = _and_body_term(body_terms, own.get(name) or BODY_TERMS[name], index, kind.cause(name))
    for index, name in enumerate(kind.whole):
        if (name in kind.accelerated) == accelerated and name not in other:
            whole_terms = _and_whole_term(whole_terms, own.get(name) or WHOLE_TERMS[name], index, kind.cause(name))

    @wp.func
    def objective_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
        for i in range(1 + lane, model.body_count, lanes):
            body_terms(instance, i, model, state, work)
        if lane == 0:
            whole_terms(instance, model, state, work)

    return objective_stage


@cache
def desired_stage_of(kind: ObjectiveKind) -> Any:
    """The Warp function (instance, model, state, work) that adds a step of the terms that see desired torques.

    One lane calls it when the controller has put these into the working set, and no muscle has acted yet.
    """
    terms, own = no_whole_terms, dict(kind.own)
    for index, name in enumerate(kind.whole):
        if name in kind.desired:
            terms = _and_whole_term(terms, own[name], index, kind.cause(name))
    return terms
