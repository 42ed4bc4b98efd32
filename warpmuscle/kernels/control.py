"""What controls joints and muscles: SIMBICON, reflexes, torques from outside, or a controller of one's own.

Each is a `Controller`, what it has compiled into a step, which `model.controller` chooses. One of one's own is a
`CustomController` in any module; a scene names it.
An effort of a joint is a generalised force: its power is that of effort times speed, for each of the joint's speeds.
A positive one turns the child, and the parent backwards, in the sense in which the speed is positive, N m.
"""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.causes import EFFORT, ENTRY, EXCITATION, GIVEN_TORQUE, cause_of, checked, checked_vector
from warpmuscle.kernels.extensions import extension_type, of_body, of_instance
from warpmuscle.kernels.muscle_control import within
from warpmuscle.kernels.reflex import reflex_force, reflex_stage
from warpmuscle.kernels.scratch import synchronize
from warpmuscle.kernels.simbicon import advance_stage, control_stage, targets_stage, torques_stage
from warpmuscle.kernels.spatial import symmetric
from warpmuscle.kernels.structs import BALL, FIXED, UNIVERSAL, ModelRef, MuscleRow, ScratchRef, StateRef, at, rolled


class CustomController(NamedTuple):
    """A controller of one's own: Warp functions, those that it has, its parameters and its state.

    All functions take what is in brackets if it is declared: `parameters`, a `@wp.struct` of floats, whose values
    stand in the scene's `custom_controller_parameters`, and `state`, so many floats, zero at the start of an instance.
    `effort` and `excitation` may read the state, `update` alone may write it.
    """

    effort: Any = None  # (instance, body, model, state, work [, parameters] [, state]) -> wp.vec3: of body's joint, N m
    excitation: Any = None  # (instance, muscle, model, state, work [...]) -> float, 0..1; negative: as torques ask for
    update: Any = None  # (instance, model, state, work [...]): first in every step
    parameters: Any = None
    state: int = 0
    shipped: bool = False  # of warpmuscle itself, whose values need not be looked at


class Controller(NamedTuple):
    """What a controller has compiled into a step: Warp functions, None where it does nothing."""

    torques: Any  # stage (instance, lane, lanes, model, state, work): targets and torques; it ends with a barrier
    advance: Any = None  # (instance, model, state): after the step, one lane calls it
    sense: Any = None  # stage of the same arguments as the first, before muscles; it ends with a barrier
    force: Any = None  # (instance, muscle, force that torques ask for, its row, model, state) -> force wanted of it, N
    custom: CustomController = CustomController()  # what a scene names, in the place of the others

    @property
    def excites(self) -> bool:
        """Whether it excites muscles, which then tell what they feel."""
        return self.force is not None or self.custom.excitation is not None

    @property
    def extension(self) -> Any:
        """Structure of its own parameters and state."""
        return extension_type(self.custom.parameters, self.custom.state)


@wp.func
def effort_torque(instance: int, body: int, effort: wp.vec3, model: ModelRef, work: ScratchRef) -> wp.vec3:
    """Torque on the parent of a joint, world, N m, that does what the efforts of its speeds ask for."""
    kind = model.skeleton.plan[body].joint_type
    rotation = work.rotation[body]
    if kind == BALL:
        return -(rotation * effort)
    a = rotation * at(model.skeleton.row, instance, body).axis_a
    if kind == UNIVERSAL:
        b = work.rotation[model.skeleton.plan[body].parent] * at(model.skeleton.row, instance, body).axis_b
        c = wp.dot(a, b)
        return (a * (c * effort[1] - effort[0]) + b * (c * effort[0] - effort[1])) / (1.0 - c * c)
    if kind == FIXED:
        return wp.vec3(0.0)
    return -(a * effort[0])


@wp.func
def given_effort(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> wp.vec3:
    """Efforts of a joint as given from outside."""
    first = model.skeleton.plan[body].speed_start
    count = model.skeleton.plan[body].speed_end - first
    column = first - model.skeleton.plan[1].speed_start
    effort = wp.vec3(0.0)
    if count > 0:  # one by one, so that they stay in registers
        effort[0] = at(model.actuation.effort, instance, column)
    if count > 1:
        effort[1] = at(model.actuation.effort, instance, column + 1)
    if count > 2:
        effort[2] = at(model.actuation.effort, instance, column + 2)
    return effort


@wp.func
def held_control_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """Torques of SIMBICON towards the targets of the last step in which it renewed them. Ends with a barrier."""
    renewed = state.step[instance] % model.control.every == 0
    if renewed:
        targets_stage(instance, lane, lanes, model, state, work)
    for i in range(lane, model.body_count, lanes):
        rolled()
        if renewed:
            state.target[instance, i] = work.target[i]
            state.target_plan[instance, i] = wp.vec2(work.strength[i], float(work.frame[i]))
        else:
            plan = state.target_plan[instance, i]
            work.target[i] = state.target[instance, i]
            work.strength[i] = plan[0]
            work.frame[i] = int(plan[1])
    synchronize()
    torques_stage(instance, lane, lanes, model, state, work)


SIMBICON = Controller(control_stage, advance_stage)
HELD = SIMBICON._replace(torques=held_control_stage)


def with_reflexes(controller: Controller) -> Controller:
    """The controller with reflexes of muscles besides."""
    return controller._replace(sense=reflex_stage, force=reflex_force)


def driven_from_outside(controller: Controller) -> Controller:
    """The controller with efforts that are given from outside in the place of its torques."""
    return controller._replace(custom=controller.custom._replace(effort=given_effort))


@cache
def control_stage_of(controller: Controller) -> Any:
    """The stage (instance, lane, lanes, model, state, work, extension) that says what is wanted of the joints.

    It puts that into the working set and ends with a barrier.
    """
    custom, extension_struct, torques = controller.custom, controller.extension, controller.torques
    has_effort, has_update = custom.effort is not None, custom.update is not None
    effort, update = advance_stage, advance_stage
    looked_at = not custom.shipped
    cause = cause_of(GIVEN_TORQUE if custom.effort is given_effort else EFFORT)
    if has_effort:
        effort = of_body(custom.effort, wp.vec3, custom.parameters, extension_struct)
    if has_update:
        update = of_instance(custom.update, custom.parameters, extension_struct)

    @wp.func
    def stage(
        instance: int,
        lane: int,
        lanes: int,
        model: ModelRef,
        state: StateRef,
        work: ScratchRef,
        extension: wp.ref[extension_struct],
    ):
        if wp.static(has_update):
            if lane == 0:
                update(instance, model, state, work, extension)
            synchronize()
        if wp.static(has_effort):
            if lane == 0:
                work.target[0] = wp.quat(0.0, 0.0, 0.0, 1.0)
                work.torque[0] = wp.vec3(0.0)
                work.stiffness[0] = symmetric(0.0)
            for i in range(1 + lane, model.body_count, lanes):
                work.target[i] = wp.quat(0.0, 0.0, 0.0, 1.0)
                wanted = effort(instance, i, 0, model, state, work, extension)
                if wp.static(looked_at):
                    wanted = checked_vector(wanted, instance, wp.static(cause) + i * wp.static(ENTRY), state, work)
                work.torque[i] = effort_torque(instance, i, wanted, model, work)
                work.stiffness[i] = symmetric(0.0)
            synchronize()
        else:
            torques(instance, lane, lanes, model, state, work)

    return stage


@cache
def force_of(controller: Controller) -> Any:
    """The Warp function (instance, muscle, asked, row, model, state, work, extension) -> force wanted of a muscle, N.

    `asked` is what the joints' torques ask for, `row` the muscle's numbers.
    """
    custom, extension_struct, force = controller.custom, controller.extension, controller.force
    has_force, has_excitation = force is not None, custom.excitation is not None
    excitation, cause = force, cause_of(EXCITATION)
    if has_excitation:
        excitation = of_body(custom.excitation, float, custom.parameters, extension_struct)

    @wp.func
    def wanted_force(
        instance: int,
        muscle: int,
        asked: float,
        row: MuscleRow,
        model: ModelRef,
        state: StateRef,
        work: ScratchRef,
        extension: wp.ref[extension_struct],
    ) -> float:
        wanted = asked
        if wp.static(has_force):
            wanted = force(instance, muscle, asked, row, model, state)
        if wp.static(has_excitation):
            told = excitation(instance, muscle, 0, model, state, work, extension)
            told = checked(told, instance, wp.static(cause) + muscle * wp.static(ENTRY), state, work)
            if not (told < 0.0):
                wanted = row.f_max * within(told)
        return wanted

    return wanted_force
