"""The muscles of an instance in a step: from wanted torques to forces, one muscle a lane.

What kind of muscles there are is compiled in, so that a step carries only the curves and the tendon that it uses.
"""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels import recorded as recorded_as
from warpmuscle.kernels.activation import activation_step
from warpmuscle.kernels.actuation import actuation_stage_of, implicit_damping_stage_of, muscle_torque, pulled_torque
from warpmuscle.kernels.cables import cable_signals, terms_of_muscles, with_cables
from warpmuscle.kernels.causes import ENTRY, GIVEN_EXCITATION, blame, cause_of
from warpmuscle.kernels.contraction import COMPLIANT as COMPLIANT
from warpmuscle.kernels.contraction import EITHER as EITHER
from warpmuscle.kernels.contraction import RIGID as RIGID
from warpmuscle.kernels.contraction import SWITCH as SWITCH
from warpmuscle.kernels.contraction import Contraction, contraction_of, legacy_contraction
from warpmuscle.kernels.control import NO_CONTROLLER, Controller, force_of
from warpmuscle.kernels.coordinate_joint import coordinate_velocities
from warpmuscle.kernels.custom_curves import OwnCurves
from warpmuscle.kernels.muscle_control import (
    activated,
    average_force,
    delayed,
    desired_force,
    heard_before,
    neurally_activated,
    timed_excitation,
    within,
)
from warpmuscle.kernels.path import PathState, joint_velocities
from warpmuscle.kernels.polynomial_path import monomials_stage
from warpmuscle.kernels.scratch import synchronize
from warpmuscle.kernels.shaped_curves import Shaped
from warpmuscle.kernels.sharing import AT_HAND, IN_STATE, activation_of, kept, prepare_of, rescale, sharing_stage_of
from warpmuscle.kernels.springs import ANY_SPRINGS, SPRINGS
from warpmuscle.kernels.stretch import PathKind, any_stretch_of
from warpmuscle.kernels.structs import LARGEST, ModelRef, RecordRef, ScratchRef, StateRef, afresh, at, rolled, whole
from warpmuscle.kernels.term_functions import MuscleWork, muscle_terms_of
from warpmuscle.kernels.turns import in_turn, next_turn

HILL, LEGACY, IDEAL = 0, 1, 2  # laws


class MuscleKind(NamedTuple):
    """What is compiled into a step."""

    curves: int  # LEE ... SARSHARI, see `curve_sets.py`
    tendon: int  # RIGID, SWITCH, COMPLIANT or EITHER
    law: int  # HILL, LEGACY or IDEAL
    pulls_at_hand: bool = False  # moment arms and torques of all crossings are kept in the working set
    mixed: bool = True  # muscles, torques and spring-dampers may share a joint
    pulleys: bool = False  # some muscles run on pulleys
    conditions: bool = True  # some points of paths are conditional
    straight: bool = False  # all paths are straight, see `structs.Straight`; pulls are at hand
    timed: bool = True  # some excitations are given over time
    neural: bool = False  # neural dynamics before that of the activation
    implicit: bool = False  # damping linearised over the step, with rigid tendons
    told: bool = False  # and those of all muscles, so that it does not matter what joints want of them
    given: bool = False  # excitations come from outside, as they are
    own: OwnCurves | Shaped | None = None  # in place of some curves of the model
    floored: bool = False  # excitations and activations have a minimum
    coordinate_joints: bool = False  # some joints are as in `coordinate_joint.py`
    followers: bool = False  # and some follow others
    paths: PathKind = PathKind()
    delayed: bool = True  # some muscles hear their excitation late
    shared: int = 0  # torques are shared out, see `sharing.py`: driven joints that a muscle crosses at most

    @property
    def may_be_at_hand(self) -> bool:
        """Whether nothing wants to know moment arms later: legacy muscles do, of the step before, and damping."""
        return self.law != LEGACY and not self.implicit

    @property
    def long_paths(self) -> bool:
        """Whether paths take so much that registers are scarce."""
        return self.paths.routes is not None or self.paths.monomials > 0


@cache
def muscle_stage_of(
    kind: MuscleKind,
    terms: tuple[Any, ...] = (),
    recorded: bool = True,
    controller: Controller = NO_CONTROLLER,
    together: int = 0,
) -> Any:
    """The Warp function that lets the muscles of a kind drive the joints, see `actuation`. It ends with a barrier.

    Args:
        kind: what is compiled in. terms: of the objective, see `term_functions.muscle_functions`.
        recorded: whether frames hold what the muscles do. controller: what excites them.
        together: lanes of each instance in a warp, where warps share instances; 0: they do not.
    """
    add_terms = muscle_terms_of(terms)
    contraction = contraction_of(kind.curves, kind.tendon, kind.implicit, kind.own)
    cables = isinstance(kind.own, Shaped) and kind.own.cables
    if cables:
        contraction, add_terms = with_cables(contraction), terms_of_muscles(add_terms)
    torque = pulled_torque if kind.pulls_at_hand else muscle_torque
    springs = ANY_SPRINGS if kind.coordinate_joints else SPRINGS
    actuation_stage = actuation_stage_of(torque, springs, kind.mixed)
    implicit_damping_stage = implicit_damping_stage_of(springs)
    stretch_stage = any_stretch_of(
        kind.paths, kind.pulleys, kind.conditions, kind.straight, kind.coordinate_joints, kind.followers
    )
    law, neural, implicit, given, floored = kind.law, kind.neural, kind.implicit, kind.given, kind.floored
    all_told = kind.told or kind.given
    excites, sense, wanted_force = controller.excites, controller.sense, force_of(controller)
    senses, extension_struct = sense is not None, controller.extension
    at_hand, straight, timed = kind.pulls_at_hand, kind.straight, kind.timed
    coordinate_joints, ordered = kind.coordinate_joints, kind.long_paths
    polynomials, queued = kind.paths.monomials > 0, kind.long_paths and together > 0
    late = kind.delayed
    shared, places = kind.shared > 0, AT_HAND if at_hand else IN_STATE
    arms, share = places.arms, places.get
    sharing_stage = sharing_stage_of(places, kind.shared)
    elastic = kind.tendon in (COMPLIANT, EITHER)
    rigid = contraction_of(kind.curves, RIGID if elastic else kind.tendon, False, kind.own)
    prepare = prepare_of(places, stretch_stage, rigid, straight, law == IDEAL, elastic, floored)

    # Else, where paths are long, these would not be inlined, and what they are given by reference had to lie in memory.
    whole_function = wp.func(inline=True) if ordered else wp.func

    @whole_function
    def one_muscle(
        instance: int,
        m: int,
        frame: int,
        model: ModelRef,
        state: StateRef,
        record: RecordRef,
        work: ScratchRef,
        extension: wp.ref[extension_struct],
    ):
        muscles = model.muscles
        step = state.step[instance]
        row = at(muscles.row, instance, m)
        a = state.muscles.activation[instance, m]
        before = wp.float32(0.0)
        if wp.static(late):
            before = heard_before(instance, m, step, row.delay_steps, state.muscles)
        desired = wp.float32(0.0)
        if wp.static(shared):
            own_share = kept(instance, m, model, state)
            part = wp.abs(share(instance, m, model, state, work)) / wp.sqrt(at(muscles.mass, instance, m))
            desired = row.f_max * activation_of(part, own_share.idle)
            stretch = PathState()
            stretch.fixed = at(model.paths.fixed_length, instance, m)
            stretch.moving = own_share.moving
            stretch.speed = own_share.speed
        else:
            if wp.static(law == LEGACY) and step > 0:
                desired = desired_force(instance, m, model, state, work)  # with the moment arms of the step before
            stretch = stretch_stage(instance, m, model, state, work, arms(instance, state, work))
            if wp.static(not all_told) and (wp.static(law != LEGACY) or step == 0):
                desired = average_force(stretch.wanted)
        if wp.static(excites):
            desired = wanted_force(instance, m, desired, row, model, state, work, extension)
        if wp.static(timed):
            own = at(muscles.own, instance, m)
            if own.end_knot > own.first_knot:
                time = float(step) * model.time_step
                if wp.static(neural):
                    time -= 0.5 * model.time_step  # the middle of the step that the activation is moved over
                told = timed_excitation(muscles, own, instance, time)
                if wp.static(given):
                    if not (wp.abs(told) >= 0.0):  # what is not a number
                        blame(instance, wp.static(cause_of(GIVEN_EXCITATION)) + m * wp.static(ENTRY), state, work)
                    told = within(told)
                desired = row.f_max * told
        if wp.static(ordered):
            row = at(muscles.row, afresh(instance), m)  # not kept in registers all along the path
        excitation = wp.min(desired / row.f_max, 1.0)
        c = Contraction()
        if wp.static(law == IDEAL):
            a = excitation
            c.length = stretch.moving + (stretch.fixed - row.l_slack)
            c.speed = stretch.speed
            c.force = desired
        else:
            if wp.static(late):
                excitation = delayed(instance, m, step, row.delay_steps, excitation, before, state.muscles)
            if wp.static(floored):
                a = wp.max(a, at(muscles.shape, instance, m).minimum_activation)
            if wp.static(law == LEGACY):
                a = activation_step(a, excitation, 1.0 / row.rise_time, model.time_step)
                c = legacy_contraction(instance, m, a, stretch, row, model, state)
            else:
                if wp.static(neural):
                    if step > 0:  # the first activation is as given
                        after = neurally_activated(a, state.muscles.neural[instance, m], excitation, row)
                        state.muscles.neural[instance, m] = after[1]
                        a = after[0]
                else:
                    a = activated(a, excitation, model.time_step, row, muscles.scaled_rates)
                if wp.static(floored):  # as OpenSim does it: only the activation is held up, not the excitation
                    a = wp.max(a, at(muscles.shape, instance, m).minimum_activation)
                if wp.static(cables):
                    signals = cable_signals(instance, m, a, excitation, model)
                    a = signals[0]
                    excitation = signals[1]
                c = contraction(instance, m, a, stretch, row, model, state)
        if wp.static(shared):
            rescale(instance, m, wp.where(at_hand, c.force, 1.0) / own_share.scale, model, arms(instance, state, work))
        elif wp.static(straight):
            work.pull[stretch.crossing] = stretch.arm * c.force
        elif wp.static(at_hand):
            span = model.paths.span[m]
            for k in range(span.first_crossing, span.end_crossing):
                rolled()
                crossing = whole(model.paths.of_muscle[whole(k)].number)
                work.pull[crossing] = work.pull[crossing] * c.force
        state.muscles.activation[instance, m] = a
        state.muscles.force[instance, m] = c.force
        if wp.static(excites):
            felt = wp.vec3(c.length / row.l_opt, c.speed / row.l_opt, c.force / row.f_max)
            state.muscles.sensed[instance, m] = felt
        if wp.static(implicit):
            state.muscles.damping[instance, m] = c.damping
        w = MuscleWork()
        w.activation = a
        w.excitation = excitation
        w.length = c.length
        w.speed = c.speed
        w.force = c.force
        add_terms(instance, m, w, model, state, work)
        if not (stretch.fixed + stretch.moving + desired + wp.abs(c.length) + wp.abs(c.speed) < LARGEST):
            work.flags[1] = 1
        if wp.static(recorded) and frame >= 0:
            slot = record.slot[instance]
            record.muscle[slot, frame, recorded_as.PATH_LENGTH, m] = stretch.fixed + stretch.moving
            record.muscle[slot, frame, recorded_as.FIBRE_LENGTH, m] = c.length
            record.muscle[slot, frame, recorded_as.FIBRE_VELOCITY, m] = c.speed
            record.muscle[slot, frame, recorded_as.DESIRED_FORCE, m] = desired
            record.muscle[slot, frame, recorded_as.EXCITATION, m] = excitation
            record.muscle[slot, frame, recorded_as.ACTIVATION, m] = a
            record.muscle[slot, frame, recorded_as.FORCE, m] = c.force

    @whole_function
    def muscle_stage(
        instance: int,
        lane: int,
        lanes: int,
        frame: int,
        model: ModelRef,
        state: StateRef,
        record: RecordRef,
        work: ScratchRef,
        extension: wp.ref[extension_struct],
    ):
        if wp.static(queued):
            next_turn(1)
        joint_velocities(lane, lanes, model, work)
        if wp.static(coordinate_joints):
            coordinate_velocities(instance, lane, lanes, model, work)
        if wp.static(polynomials):
            monomials_stage(instance, lane, lanes, model, state, work)
        if wp.static(senses):
            sense(instance, lane, lanes, model, state, work)
        if wp.static(shared):
            for m in range(lane, model.muscles.count, lanes):
                prepare(instance, m, model, state, work)
            sharing_stage(instance, lane, lanes, model, state, work)
        if wp.static(queued):
            first = next_turn(0) * wp.static(together)
            while first < model.muscles.count:
                place = first + lane % wp.static(together)
                if place < model.muscles.count:
                    one_muscle(instance, whole(model.routes.order[place]), frame, model, state, record, work, extension)
                first = next_turn(0) * wp.static(together)
        elif wp.static(ordered):
            for k in range(lane, model.muscles.count, lanes):
                place = in_turn(k, lane, lanes, model.muscles.count)
                one_muscle(instance, whole(model.routes.order[place]), frame, model, state, record, work, extension)
        else:
            for m in range(lane, model.muscles.count, lanes):
                one_muscle(instance, m, frame, model, state, record, work, extension)
        synchronize()
        actuation_stage(instance, lane, lanes, model, state, work)
        if wp.static(implicit):
            implicit_damping_stage(instance, lane, lanes, model, state, work)

    return muscle_stage
