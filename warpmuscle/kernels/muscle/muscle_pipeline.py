"""What happens to a muscle in a step, in this order; `muscle_stage.py` puts the steps together.

- begin: what the step before has left.
- sense: how long the path is and how fast it lengthens, and what the joints ask of the muscle.
- want: the force that the controller makes of it, or an excitation given over time.
- excite: the excitation, and what of it the muscle hears now.
- activate, contract: activation and force, as the muscle's law says (`muscle_kind.MuscleLaw`).
- pull: what its joints gather.
- account: the state, the terms of the objective, and the frames.

Each is a function made for a kind of muscles, so that a step carries only what this kind needs. They are all inlined,
so that a `MuscleStep` stays in registers.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.control.control import ControllerKind, force_of
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.muscle.contraction import Contraction
from warpmuscle.kernels.muscle.muscle_control import (
    average_force,
    delayed,
    desired_force,
    heard_before,
    timed_excitation,
    within,
)
from warpmuscle.kernels.muscle.muscle_kind import MuscleKind
from warpmuscle.kernels.muscle.sharing import Places, kept, places_of, rescale
from warpmuscle.kernels.muscle.sharing_rules import activation_of
from warpmuscle.kernels.objective.causes import ENTRY, GIVEN_EXCITATION, blame, cause_of
from warpmuscle.kernels.objective.term_functions import MuscleWork
from warpmuscle.kernels.path.path import PathState, add_crossings
from warpmuscle.kernels.path.stretch import any_stretch_of
from warpmuscle.kernels.recording import recorded as recorded_as
from warpmuscle.kernels.structs import (
    LARGEST,
    ModelRef,
    MuscleRow,
    RecordRef,
    ScratchRef,
    StateRef,
    at,
    nonnegative,
    not_unrolled,
    recomputed,
)


@wp.struct
class MuscleStep:
    """What is known of a muscle, from one part of a step to the next."""

    step: int  # that its instance makes
    row: MuscleRow
    stretch: PathState
    heard: float  # excitation that its delay line gives out now
    desired: float  # N, force
    excitation: float
    activation: float  # of the step before, then of this one
    fibre: Contraction


MuscleStepRef = wp.ref[MuscleStep]


def stretch_stage_of(kind: MuscleKind) -> Any:
    """The Warp function of length, speed and moment arms of paths of a kind, see `path.stretch_of`."""
    return any_stretch_of(
        kind.paths, kind.pulleys, kind.conditions, kind.straight, kind.coordinate_joints, kind.followers
    )


@cache
def begin_of(late: bool) -> Any:
    """The Warp function (instance, m, muscle, model, state) that begins a muscle's step.

    Args:
        late: whether some muscles hear their excitation late.
    """

    @wp.func(inline=True)
    def begin(instance: int, m: int, muscle: MuscleStepRef, model: ModelRef, state: StateRef):
        muscle.step = state.step[instance]
        muscle.row = at(model.muscles.row, instance, m)
        muscle.activation = state.muscles.activation[instance, m]
        if wp.static(late):
            muscle.heard = heard_before(instance, m, muscle.step, muscle.row.delay_steps, state.muscles)

    return begin


def sense_of(kind: MuscleKind) -> Any:
    """The Warp function (instance, m, muscle, model, state, work) that puts in stretch and desired force."""
    if kind.shared > 0:
        return sense_share_of(places_of(kind.pulls_in_scratch))
    if kind.law.past_arms:
        return sense_past_arms_of(kind)
    if kind.apart:
        return sense_known_path_of(kind)
    return sense_path_of(kind)


@cache
def sense_share_of(places: Places) -> Any:
    """`sense` where torques are shared out: paths are known, and forces follow from the muscles' shares."""
    share = places.get

    @wp.func(inline=True)
    def sense(instance: int, m: int, muscle: MuscleStepRef, model: ModelRef, state: StateRef, work: ScratchRef):
        own = kept(instance, m, state)
        part = wp.abs(share(instance, m, state, work)) / wp.sqrt(at(model.muscles.mass, instance, m))
        muscle.desired = muscle.row.f_max * activation_of(part, own.idle)
        stretch = PathState()
        stretch.fixed = at(model.paths.fixed_length, instance, m)
        stretch.moving = own.moving
        stretch.speed = own.speed
        muscle.stretch = stretch

    return sense


@cache
def sense_path_of(kind: MuscleKind) -> Any:
    """`sense` where each muscle gives what its joints want on average, unless it is told its excitation."""
    stretch_stage, arms = stretch_stage_of(kind), places_of(kind.pulls_in_scratch).arms
    asked = not (kind.all_timed or kind.given)

    @wp.func(inline=True)
    def sense(instance: int, m: int, muscle: MuscleStepRef, model: ModelRef, state: StateRef, work: ScratchRef):
        stretch = stretch_stage(instance, m, model, state, work, arms(instance, state, work))
        muscle.stretch = stretch
        if wp.static(asked):
            muscle.desired = average_force(stretch.wanted)

    return sense


@cache
def sense_known_path_of(kind: MuscleKind) -> Any:
    """`sense` where a kernel of its own has found the path, see `path_kernels.py`."""
    asked = not (kind.all_timed or kind.given)

    @wp.func(inline=True)
    def sense(instance: int, m: int, muscle: MuscleStepRef, model: ModelRef, state: StateRef, work: ScratchRef):
        known = state.muscles.apart.stretch[instance, m]
        stretch = PathState()
        stretch.fixed = at(model.paths.fixed_length, instance, m)
        stretch.moving = known[0]
        if wp.static(asked):
            add_crossings(stretch, m, model, work, state.muscles.moment_arm[instance])
            muscle.desired = average_force(stretch.wanted)
        stretch.speed = known[1]
        muscle.stretch = stretch

    return sense


@cache
def sense_past_arms_of(kind: MuscleKind) -> Any:
    """The same along the moment arms of the step before, which are there until those of this step are."""
    stretch_stage, arms = stretch_stage_of(kind), places_of(kind.pulls_in_scratch).arms
    asked = not (kind.all_timed or kind.given)

    @wp.func(inline=True)
    def sense(instance: int, m: int, muscle: MuscleStepRef, model: ModelRef, state: StateRef, work: ScratchRef):
        if muscle.step > 0:
            muscle.desired = desired_force(instance, m, model, state, work)
        stretch = stretch_stage(instance, m, model, state, work, arms(instance, state, work))
        muscle.stretch = stretch
        if wp.static(asked) and muscle.step == 0:
            muscle.desired = average_force(stretch.wanted)

    return sense


@cache
def want_of(kind: MuscleKind, controller: ControllerKind) -> Any:
    """The Warp function (instance, m, muscle, model, state, work, extension) that changes the desired force.

    Args:
        controller: what excites the muscles, if it does.
    """
    wanted_force, extension_struct = force_of(controller), controller.extension
    excites, timed, timed_force = controller.excites, kind.timed, timed_force_of(kind.neural, kind.given)

    @wp.func(inline=True)
    def want(
        instance: int, m: int, muscle: MuscleStepRef, model: ModelRef, state: StateRef, work: ScratchRef,
        extension: wp.ref[extension_struct],
    ):  # fmt: skip
        if wp.static(excites):
            muscle.desired = wanted_force(instance, m, muscle.desired, muscle.row, model, state, work, extension)
        if wp.static(timed):
            muscle.desired = timed_force(instance, m, muscle.desired, muscle.step, muscle.row.f_max, model, state, work)

    return want


@cache
def timed_force_of(neural: bool, given: bool) -> Any:
    """The Warp function of the force of a muscle whose excitation is given over time, N; others keep theirs.

    Args:
        neural: whether a step takes the excitation of its middle. given: whether it comes from outside, unchecked.
    """

    @wp.func(inline=True)
    def timed_force(
        instance: int, m: int, desired: float, step: int, f_max: float, model: ModelRef, state: StateRef,
        work: ScratchRef,
    ) -> float:  # fmt: skip
        force = desired
        own = at(model.muscles.timed, instance, m)
        if own.end_knot > own.first_knot:
            time = float(step) * model.time_step
            if wp.static(neural):
                time -= 0.5 * model.time_step
            level = timed_excitation(model.muscles, own, instance, time)
            if wp.static(given):
                if not (wp.abs(level) >= 0.0):  # what is not a number
                    blame(instance, wp.static(cause_of(GIVEN_EXCITATION)) + m * wp.static(ENTRY), state, work)
                level = within(level)
            force = f_max * level
        return force

    return timed_force


@cache
def excite_of(late: bool, long_paths: bool) -> Any:
    """The Warp function (instance, m, muscle, model, state) that makes an excitation of the desired force.

    Args:
        late: whether some muscles hear it late. long_paths: whether paths are long, see `MuscleKind.long_paths`.
    """

    @wp.func(inline=True)
    def excite(instance: int, m: int, muscle: MuscleStepRef, model: ModelRef, state: StateRef):
        if wp.static(long_paths):
            muscle.row = at(model.muscles.row, recomputed(instance), m)  # not kept in registers all along the path
        muscle.excitation = wp.min(muscle.desired / muscle.row.f_max, 1.0)
        if wp.static(late):
            muscle.excitation = delayed(
                instance, m, muscle.step, muscle.row.delay_steps, muscle.excitation, muscle.heard, state.muscles
            )

    return excite


def pull_of(kind: MuscleKind) -> Any:
    """The Warp function (instance, m, muscle, model, state, work) that puts the force where the joints gather it."""
    if kind.shared > 0:
        return pull_shared_of(places_of(kind.pulls_in_scratch), kind.pulls_in_scratch)
    if kind.straight:
        return pull_straight
    if kind.pulls_in_scratch:
        return pull_torques_of(kind.apart)
    return pull_by_state


@func(inline=True)
def pull_by_state(instance: int, m: int, muscle: MuscleStepRef, model: ModelRef, state: StateRef, work: ScratchRef):
    """Into the state, which has the moment arms as well."""
    state.muscles.force[instance, m] = muscle.fibre.force


@func(inline=True)
def pull_straight(instance: int, m: int, muscle: MuscleStepRef, model: ModelRef, state: StateRef, work: ScratchRef):
    """The only joint of a straight path gets its torque at once."""
    work.pull[muscle.stretch.crossing] = muscle.stretch.arm * muscle.fibre.force
    state.muscles.force[instance, m] = muscle.fibre.force


@cache
def pull_torques_of(known: bool) -> Any:
    """The same as torques in the working set, of moment arms that are there, or `known` by the state."""

    @wp.func(inline=True)
    def pull(instance: int, m: int, muscle: MuscleStepRef, model: ModelRef, state: StateRef, work: ScratchRef):
        force = muscle.fibre.force
        span = model.paths.span[m]
        for k in range(span.first_crossing, span.end_crossing):
            not_unrolled()
            crossing = nonnegative(model.paths.of_muscle[nonnegative(k)].number)
            if wp.static(known):
                work.pull[crossing] = state.muscles.moment_arm[instance, crossing] * force
            else:
                work.pull[crossing] = work.pull[crossing] * force
        state.muscles.force[instance, m] = force

    return pull


@cache
def pull_shared_of(places: Places, in_scratch: bool) -> Any:
    """Moment arms that were scaled to share torques out become torques, or moment arms again."""
    arms = places.arms

    @wp.func(inline=True)
    def pull(instance: int, m: int, muscle: MuscleStepRef, model: ModelRef, state: StateRef, work: ScratchRef):
        force = muscle.fibre.force
        scale = kept(instance, m, state).scale
        rescale(instance, m, wp.where(in_scratch, force, 1.0) / scale, model, arms(instance, state, work))
        state.muscles.force[instance, m] = force

    return pull


@cache
def account_of(terms: Any, recorded: bool, excites: bool, implicit: bool) -> Any:
    """The Warp function (instance, m, muscle, frame, model, state, record, work) that ends a muscle's step.

    Args:
        terms: of the objective, see `term_sums.muscle_terms_of`. recorded: whether frames hold muscles.
        excites: whether the controller feels them. implicit: whether their damping is implicit.
    """

    @wp.func(inline=True)
    def account(
        instance: int, m: int, muscle: MuscleStepRef, frame: int, model: ModelRef, state: StateRef, record: RecordRef,
        work: ScratchRef,
    ):  # fmt: skip
        c = muscle.fibre
        row = muscle.row
        state.muscles.activation[instance, m] = muscle.activation
        if wp.static(excites):
            felt = wp.vec3(c.length / row.l_opt, c.speed / row.l_opt, c.force / row.f_max)
            state.muscles.sensed[instance, m] = felt
        if wp.static(implicit):
            state.muscles.damping[instance, m] = c.damping
        w = MuscleWork()
        w.activation = muscle.activation
        w.excitation = muscle.excitation
        w.length = c.length
        w.speed = c.speed
        w.force = c.force
        terms(instance, m, w, model, state, work)
        path_length = muscle.stretch.fixed + muscle.stretch.moving
        if not (path_length + muscle.desired + wp.abs(c.length) + wp.abs(c.speed) < LARGEST):
            work.flags[1] = 1
        if wp.static(recorded) and frame >= 0:
            record_muscle(instance, m, muscle, frame, record)

    return account


@func(inline=True)
def record_muscle(instance: int, m: int, muscle: MuscleStepRef, frame: int, record: RecordRef):
    """Write what a muscle does into a frame."""
    slot = record.slot[instance]
    record.muscle[slot, frame, recorded_as.PATH_LENGTH, m] = muscle.stretch.fixed + muscle.stretch.moving
    record.muscle[slot, frame, recorded_as.FIBRE_LENGTH, m] = muscle.fibre.length
    record.muscle[slot, frame, recorded_as.FIBRE_VELOCITY, m] = muscle.fibre.speed
    record.muscle[slot, frame, recorded_as.DESIRED_FORCE, m] = muscle.desired
    record.muscle[slot, frame, recorded_as.EXCITATION, m] = muscle.excitation
    record.muscle[slot, frame, recorded_as.ACTIVATION, m] = muscle.activation
    record.muscle[slot, frame, recorded_as.FORCE, m] = muscle.fibre.force
