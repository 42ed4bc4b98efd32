"""The muscles of an instance in a step: from wanted torques to forces, one muscle a lane."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.body.coordinate_joint import coordinate_velocities, put_groups
from warpmuscle.kernels.control.control import NO_CONTROLLER, ControllerKind
from warpmuscle.kernels.force.actuation import (
    actuation_stage_of,
    implicit_damping_stage_of,
    muscle_torque,
    pulled_torque,
)
from warpmuscle.kernels.force.springs import ANY_SPRINGS, SPRINGS
from warpmuscle.kernels.force.torque_parts import parts_stage, torque_of_parts
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.memory.turns import in_turn, next_turn
from warpmuscle.kernels.muscle.cables import terms_of_muscles
from warpmuscle.kernels.muscle.muscle_kind import MuscleKind
from warpmuscle.kernels.muscle.muscle_laws import function_of
from warpmuscle.kernels.muscle.muscle_pipeline import (
    MuscleStep,
    account_of,
    begin_of,
    excite_of,
    pull_of,
    sense_of,
    stretch_stage_of,
    want_of,
)
from warpmuscle.kernels.muscle.sharing import places_of, prepare_of, sharing_stage_of
from warpmuscle.kernels.objective.term_sums import muscle_terms_of
from warpmuscle.kernels.path.path import joint_velocities
from warpmuscle.kernels.path.polynomial_path import monomials_stage
from warpmuscle.kernels.structs import ModelRef, RecordRef, ScratchRef, StateRef, nonnegative


@cache
def muscle_stage_of(
    kind: MuscleKind,
    terms: tuple[Any, ...] = (),
    recorded: bool = True,
    controller: ControllerKind = NO_CONTROLLER,
    lanes_in_warp: int = 0,
) -> Any:
    """The Warp function that lets the muscles of a kind drive the joints, see `actuation`. It ends with a barrier.

    Args:
        kind: what is compiled in. terms: of the objective, see `term_sums.muscle_functions`.
        recorded: whether frames hold what the muscles do. controller: what excites them.
        lanes_in_warp: lanes of each instance in a warp, where warps share instances; 0: they do not.
    """
    prepare_all = preparation_of(kind, controller)
    pull_all = every_muscle_of(kind, one_muscle_of(kind, terms, recorded, controller), controller, lanes_in_warp)
    springs = ANY_SPRINGS if kind.coordinate_joints else SPRINGS
    in_parts, torque = kind.parts > 0, pulled_torque if kind.pulls_in_scratch else muscle_torque
    add_parts = parts_stage if in_parts else None
    actuation_stage = actuation_stage_of(torque_of_parts if in_parts else torque, springs, kind.mixed)
    implicit, implicit_damping_stage = kind.implicit, implicit_damping_stage_of(springs) if kind.implicit else None
    queued, extension_struct = kind.long_paths and lanes_in_warp > 0, controller.extension
    begin_turns = next_turn if queued else None

    @inlined(kind)
    def muscle_stage(
        instance: int, lane: int, lanes: int, frame: int, model: ModelRef, state: StateRef, record: RecordRef,
        work: ScratchRef, extension: wp.ref[extension_struct],
    ):  # fmt: skip
        if wp.static(queued):
            begin_turns(1)
        prepare_all(instance, lane, lanes, model, state, work)
        pull_all(instance, lane, lanes, frame, model, state, record, work, extension)
        synchronize()
        if wp.static(in_parts):
            add_parts(instance, lane, lanes, model, state)
        actuation_stage(instance, lane, lanes, model, state, work)
        if wp.static(implicit):
            implicit_damping_stage(instance, lane, lanes, model, state, work)

    return muscle_stage


def inlined(kind: MuscleKind) -> Any:
    """Makes a Warp function, one that is surely inlined where paths are long: else what it refers to lay in memory."""
    return wp.func(inline=True) if kind.long_paths else wp.func


def one_muscle_of(kind: MuscleKind, terms: tuple[Any, ...], recorded: bool, controller: ControllerKind) -> Any:
    """The Warp function of a muscle's step, see `muscle_pipeline`."""
    add_terms = muscle_terms_of(terms)
    if kind.cables:
        add_terms = terms_of_muscles(add_terms)
    late = kind.delayed and kind.law.delayed
    begin, sense, want = begin_of(late), sense_of(kind), want_of(kind, controller)
    excite, activate = excite_of(late, kind.long_paths), function_of(kind, "activate")
    contract, pull = function_of(kind, "contract"), pull_of(kind)
    account = account_of(add_terms, recorded, controller.excites, kind.implicit)
    extension_struct = controller.extension

    @inlined(kind)
    def one_muscle(
        instance: int, m: int, frame: int, model: ModelRef, state: StateRef, record: RecordRef, work: ScratchRef,
        extension: wp.ref[extension_struct],
    ):  # fmt: skip
        muscle = MuscleStep()
        begin(instance, m, muscle, model, state)
        sense(instance, m, muscle, model, state, work)
        want(instance, m, muscle, model, state, work, extension)
        excite(instance, m, muscle, model, state)
        activate(instance, m, muscle, model, state)
        contract(instance, m, muscle, model, state)
        pull(instance, m, muscle, model, state, work)
        account(instance, m, muscle, frame, model, state, record, work)

    return one_muscle


def preparation_of(kind: MuscleKind, controller: ControllerKind) -> Any:
    """The stage of what all muscles need before the first of them: joint velocities, senses, shares of torques."""
    coordinate_joints, polynomials, shared = kind.coordinate_joints, kind.paths.monomials > 0, kind.shared > 0
    sense, senses = controller.sense, controller.sense is not None
    grouped = kind.paths.groups > 0 and not kind.apart
    join = put_groups if grouped else None
    places = places_of(kind.pulls_in_scratch)
    coordinate_speeds = coordinate_velocities if coordinate_joints else None
    find_monomials = monomials_stage if polynomials else None
    prepare = sharing_stage = None
    if shared:
        prepare = prepare_of(places, stretch_stage_of(kind), function_of(kind, "strength"), kind.straight)
        sharing_stage = sharing_stage_of(places, kind.shared)

    @inlined(kind)
    def prepare_all(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
        if wp.static(grouped):
            join(instance, lane, lanes, model, state, work)
        joint_velocities(lane, lanes, model, work)
        if wp.static(coordinate_joints):
            coordinate_speeds(instance, lane, lanes, model, work)
        if wp.static(polynomials):
            find_monomials(instance, lane, lanes, model, state, work)
        if wp.static(senses):
            sense(instance, lane, lanes, model, state, work)
        if wp.static(shared):
            for m in range(lane, model.muscles.count, lanes):
                prepare(instance, m, model, state, work)
            sharing_stage(instance, lane, lanes, model, state, work)

    return prepare_all


def every_muscle_of(kind: MuscleKind, one_muscle: Any, controller: ControllerKind, lanes_in_warp: int) -> Any:
    """The stage in which lanes take the muscles of an instance: from a queue, in turn by their work, or as they come.

    Args:
        lanes_in_warp: see `muscle_stage_of`.
    """
    queued, ordered, extension_struct = kind.long_paths and lanes_in_warp > 0, kind.long_paths, controller.extension
    take_turn, turn_of = next_turn if queued else None, in_turn if ordered and not queued else None

    @inlined(kind)
    def every_muscle(
        instance: int, lane: int, lanes: int, frame: int, model: ModelRef, state: StateRef, record: RecordRef,
        work: ScratchRef, extension: wp.ref[extension_struct],
    ):  # fmt: skip
        if wp.static(queued):
            first = take_turn(0) * wp.static(lanes_in_warp)
            while first < model.muscles.count:
                place = first + lane % wp.static(lanes_in_warp)
                if place < model.muscles.count:
                    one_muscle(
                        instance, nonnegative(model.routes.order[place]), frame, model, state, record, work, extension
                    )
                first = take_turn(0) * wp.static(lanes_in_warp)
        elif wp.static(ordered):
            for k in range(lane, model.muscles.count, lanes):
                place = turn_of(k, lane, lanes, model.muscles.count)
                one_muscle(
                    instance, nonnegative(model.routes.order[place]), frame, model, state, record, work, extension
                )
        else:
            for m in range(lane, model.muscles.count, lanes):
                one_muscle(instance, m, frame, model, state, record, work, extension)

    return every_muscle
