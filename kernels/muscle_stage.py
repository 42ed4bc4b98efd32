"""The muscles of an instance in a step: from wanted torques to forces, one muscle a lane.

What kind of muscles there are is compiled in, so that a step carries only the curves and the tendon that it uses.
"""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.activation import activation_step
from warpmuscle.kernels.actuation import actuation_stage, implicit_damping_stage
from warpmuscle.kernels.lanes import synchronize
from warpmuscle.kernels.muscle import (
    bounded_fibre_length,
    compliant_force,
    compliant_step,
    fibre_damping,
    fibre_equilibrium,
    fibre_force,
    legacy_force,
    pennation_cosine,
    rigid_fibre_length,
    rigid_fibre_speed,
    switched_fibre_length,
    switched_fibre_speed,
)
from warpmuscle.kernels.muscle_control import activated, delayed, desired_force, neurally_activated, timed_excitation
from warpmuscle.kernels.objective_terms import MuscleWork, muscle_terms_of
from warpmuscle.kernels.path import Stretch, joint_velocities, stretch_of
from warpmuscle.kernels.structs import Model, Record, State, Work, at

RIGID, SWITCH, COMPLIANT = 0, 1, 2  # tendons
HILL, LEGACY, IDEAL = 0, 1, 2  # laws


class MuscleKind(NamedTuple):
    """What is compiled into a step."""

    curves: int  # LEE ... SARSHARI, see `curves.py`
    tendon: int  # RIGID, SWITCH or COMPLIANT
    law: int  # HILL, LEGACY or IDEAL
    pulleys: bool = False  # some muscles run on pulleys
    neural: bool = False  # neural dynamics before that of the activation
    implicit: bool = False  # damping linearised over the step, with rigid tendons


@wp.struct
class Contraction:
    """What a fibre does in a step."""

    length: float  # m
    speed: float  # m/s
    force: float  # N, along the tendon
    damping: float  # N s/m, of the force by the speed of the path, if implicit


@cache
def contraction_of(curves: int, tendon: int, implicit: bool = False) -> Any:
    """The Warp function (instance, muscle, activation, stretch, model, state) -> Contraction of a kind of muscles."""

    @wp.func
    def rigid(instance: int, m: int, activation: float, stretch: Stretch, model: Model, state: State) -> Contraction:
        muscles = model.muscles
        l_opt = at(muscles.l_opt, instance, m)
        slack = at(muscles.l_slack, instance, m) - stretch.fixed
        width = at(muscles.width, instance, m)
        c = Contraction()
        if wp.static(tendon == SWITCH):
            c.length = bounded_fibre_length(switched_fibre_length(stretch.moving, l_opt, slack), l_opt, 0.0)
            c.speed = switched_fibre_speed(stretch.moving, stretch.speed, l_opt, slack)
        else:
            c.length = rigid_fibre_length(stretch.moving, l_opt, slack, width)
            c.speed = rigid_fibre_speed(stretch.speed, c.length, width)
        x = c.length / l_opt
        speed = c.speed / (at(muscles.v_max, instance, m) * l_opt)
        force = fibre_force(curves, activation, x, speed, at(muscles.damping, instance, m))
        c.force = at(muscles.f_max, instance, m) * force * pennation_cosine(c.length, width)
        if wp.static(implicit):
            cosine = pennation_cosine(c.length, width)
            slope = fibre_damping(curves, activation, x, speed, at(muscles.damping, instance, m)) * cosine * cosine
            c.damping = slope * at(muscles.f_max, instance, m) / (at(muscles.v_max, instance, m) * l_opt)
        return c

    @wp.func
    def compliant(
        instance: int, m: int, activation: float, stretch: Stretch, model: Model, state: State
    ) -> Contraction:
        muscles = model.muscles
        l_opt = at(muscles.l_opt, instance, m)
        l_slack = at(muscles.l_slack, instance, m)
        width = at(muscles.width, instance, m)
        path_length = stretch.fixed + stretch.moving
        if state.step[instance] == 0:
            settled = fibre_equilibrium(curves, activation, path_length, l_opt, l_slack, width)
            state.muscles.fibre_length[instance, m] = settled
            state.muscles.previous_fibre_length[instance, m] = settled
        before = state.muscles.fibre_length[instance, m]
        c = Contraction()
        c.length = compliant_step(
            curves, activation, path_length, before, state.muscles.previous_fibre_length[instance, m],
            l_opt, l_slack, width, at(muscles.v_max, instance, m), at(muscles.damping, instance, m), model.time_step,
        )  # fmt: skip
        state.muscles.previous_fibre_length[instance, m] = before
        state.muscles.fibre_length[instance, m] = c.length
        c.speed = (c.length - before) / model.time_step
        tendon_force = compliant_force(curves, path_length, c.length, l_slack, width)
        c.force = at(muscles.f_max, instance, m) * tendon_force
        return c

    return compliant if tendon == COMPLIANT else rigid


@wp.func
def legacy_contraction(instance: int, m: int, activation: float, stretch: Stretch, model: Model, state: State):
    """As the program of Bergmann 2017 computed it: tendon switch, backward difference of the length, no bounds."""
    l_opt = at(model.muscles.l_opt, instance, m)
    c = Contraction()
    c.length = switched_fibre_length(stretch.moving, l_opt, at(model.muscles.l_slack, instance, m) - stretch.fixed)
    if state.step[instance] > 0:
        c.speed = (c.length - state.muscles.fibre_length[instance, m]) / model.time_step
    state.muscles.fibre_length[instance, m] = c.length
    c.force = legacy_force(at(model.muscles.f_max, instance, m), activation, c.length, c.speed, l_opt)
    return c


@wp.func
def no_muscles(
    instance: int, lane: int, lanes: int, frame: int, model: Model, state: State, record: Record, work: Work
):
    """The muscle stage of a character that torques alone drive."""


@cache
def muscle_stage_of(kind: MuscleKind, terms: tuple[str, ...] = (), recorded: bool = True) -> Any:
    """The Warp function that lets the muscles of a kind drive the joints, see `actuation`. It ends with a barrier.

    Args:
        kind: what is compiled in. terms: of the objective that are summed over muscles.
        recorded: whether frames hold what the muscles do.
    """
    add_terms = muscle_terms_of(terms)
    contraction = contraction_of(kind.curves, kind.tendon, kind.implicit)
    stretch_stage = stretch_of(kind.pulleys)
    law, neural, implicit = kind.law, kind.neural, kind.implicit

    @wp.func
    def one_muscle(instance: int, m: int, frame: int, model: Model, state: State, record: Record, work: Work):
        muscles = model.muscles
        step = state.step[instance]
        desired = wp.float32(0.0)
        if wp.static(law == LEGACY) and step > 0:
            desired = desired_force(instance, m, model, state, work)  # with the moment arms of the step before
        stretch = stretch_stage(instance, m, model, state, work, state.muscles.moment_arm)
        if wp.static(law != LEGACY) or step == 0:
            desired = desired_force(instance, m, model, state, work)
        f_max = at(muscles.f_max, instance, m)
        if muscles.knot_start[m + 1] > muscles.knot_start[m]:
            time = float(step) * model.time_step
            if wp.static(neural):
                time -= 0.5 * model.time_step  # the middle of the step that the activation is moved over
            desired = f_max * timed_excitation(muscles, instance, m, time)
        excitation = wp.min(desired / f_max, 1.0)
        c = Contraction()
        if wp.static(law == IDEAL):
            state.muscles.activation[instance, m] = excitation
            c.length = stretch.moving + (stretch.fixed - at(muscles.l_slack, instance, m))
            c.speed = stretch.speed
            c.force = desired
        else:
            excitation = delayed(instance, m, step, excitation, muscles, state.muscles)
            if wp.static(law == LEGACY):
                rate = 1.0 / at(muscles.rise_time, instance, m)
                a = activation_step(state.muscles.activation[instance, m], excitation, rate, model.time_step)
                state.muscles.activation[instance, m] = a
                c = legacy_contraction(instance, m, a, stretch, model, state)
            else:
                if wp.static(neural):
                    a = neurally_activated(instance, m, step, excitation, muscles, state.muscles)
                else:
                    a = activated(instance, m, excitation, model.time_step, muscles, state.muscles)
                c = contraction(instance, m, a, stretch, model, state)
        state.muscles.force[instance, m] = c.force
        if wp.static(implicit):
            state.muscles.damping[instance, m] = c.damping
        w = MuscleWork()
        w.activation = state.muscles.activation[instance, m]
        w.excitation = excitation
        w.length = c.length
        w.speed = c.speed
        w.force = c.force
        add_terms(instance, m, w, model, state)
        if wp.static(recorded) and frame >= 0:
            row = record.slot[instance]
            record.muscle[row, frame, 0, m] = stretch.fixed + stretch.moving
            record.muscle[row, frame, 1, m] = c.length
            record.muscle[row, frame, 2, m] = c.speed
            record.muscle[row, frame, 3, m] = desired
            record.muscle[row, frame, 4, m] = excitation
            record.muscle[row, frame, 5, m] = state.muscles.activation[instance, m]
            record.muscle[row, frame, 6, m] = c.force

    @wp.func
    def muscle_stage(
        instance: int, lane: int, lanes: int, frame: int, model: Model, state: State, record: Record, work: Work
    ):
        joint_velocities(lane, lanes, model, work)
        for m in range(lane, model.muscles.count, lanes):
            one_muscle(instance, m, frame, model, state, record, work)
        synchronize()
        actuation_stage(instance, lane, lanes, model, state, work)
        if wp.static(implicit):
            implicit_damping_stage(instance, lane, lanes, model, state, work)

    return muscle_stage
