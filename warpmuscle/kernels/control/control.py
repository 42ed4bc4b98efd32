"""What controls joints and muscles: what a controller has compiled into a step, and the stages that call it.

`model.controllers` makes the `ControllerKind` of a scene, from a table of all there are. One of one's own is a
`CustomController` in any module, which a scene names; those of `kernels.control.controllers` are made in the same way.
An effort of a joint is a generalised force: its power is that of effort times speed, for each of the joint's speeds.
A positive one turns the child, and the parent backwards, in the sense in which the speed is positive, N m.
"""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.algebra.spatial import symmetric, symmetric_outer, symmetric_rotated
from warpmuscle.kernels.force.extensions import (
    controller_extension,
    of_body,
    of_instance,
    takes_parameters,
    takes_table,
)
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.moved import of_former_names
from warpmuscle.kernels.muscle.muscle_control import within
from warpmuscle.kernels.objective.causes import (
    EFFORT,
    ENTRY,
    EXCITATION,
    GIVEN_TORQUE,
    cause_of,
    checked,
    checked_vector,
)
from warpmuscle.kernels.structs import (
    BALL,
    FIXED,
    UNIVERSAL,
    ModelRef,
    MuscleRow,
    RecordRef,
    ScratchRef,
    StateRef,
    at,
    not_unrolled,
)


class ExplicitDamping(NamedTuple):
    """How far the damping of a controller's joints may go where it is explicit, and where a scene has it.

    Speeds grow where the largest eigenvalue of h M^-1 C is beyond `bound`: h the step, M inertia, C damping. It is 2
    of speeds in the middle of the step before, and 1 where they are extrapolated to the start of the step (Adams and
    Bashforth's second order), as `joint_values.joint_speed` does it.
    """

    bound: float = 1.0
    parameter: str = "kd"  # of each joint, in `by_joint`, for all of its speeds
    of_body: bool = False  # in units of the body's weight, its leg and the time of a pendulum so long; else N m s/rad


class CustomController(NamedTuple):
    """A controller of one's own: Warp functions, those that it has, its parameters and its state.

    All functions take what is in brackets if it is declared: `parameters`, a `@wp.struct` of floats, whose values
    stand in the scene's `controller.parameters`; `own`, the same of the joint, body or muscle that they are asked for;
    and `state`, so many floats, zero at the start of an instance. `effort`, `damping` and `excitation` may read the
    state, `update` alone may write it; that may also take an array of what all joints, bodies or muscles have.
    In scenes with `implicit_pd`, damping is implicit, and stable in steps of any length.
    """

    effort: Any = None  # (instance, body, model, state, work [, parameters] [, own] [, state]) -> wp.vec3: joint, N m
    excitation: Any = None  # (instance, muscle, model, state, work [...]) -> float, 0..1; negative: as torques ask for
    update: Any = None  # (instance, model, state, work [...]): first in every step
    parameters: Any = None
    state: int = 0
    shipped: bool = False  # of warpmuscle itself, whose values need not be looked at
    by_joint: Any = None  # `@wp.struct` of floats of each joint, from `controller.by_joint`; for `effort`
    by_body: Any = None  # of each body; for `effort`
    by_muscle: Any = None  # of each muscle; for `excitation`
    state_a_body: int = 0  # further floats of its state, body by body, behind the others; the root's first
    recorded: tuple[tuple[str, str], ...] = ()  # names and units of the first floats of its state that frames hold
    defaults: tuple[tuple[str, float], ...] = ()  # parameters that a scene need not give, of all structures
    description: str = ""
    legs: bool = False  # whether it moves two legs: feet, hinged knees, hips of the root, joints of usual types
    damping: Any = None  # as `effort`: N m s/rad, how much less each effort is for its speed; for `implicit_pd`
    explicit: ExplicitDamping | None = None  # of a shipped one: that damping, where it is not implicit

    def values_of(self, function: Any) -> tuple[str, Any]:
        """Which of `by_joint`, `by_body` and `by_muscle` a function takes, and the structure; ("", None) if none."""
        for place in PLACES:
            struct = getattr(self, place)
            if takes_parameters(function, struct) or takes_table(function, struct):
                return place, struct
        return "", None

    def memory(self, bodies: int) -> int:
        """Floats of the state of an instance with so many bodies."""
        return self.state + self.state_a_body * bodies


PLACES = ("by_joint", "by_body", "by_muscle")  # that may have parameters of their own


class ControllerKind(NamedTuple):
    """What a controller has compiled into a step: Warp functions, None where it does nothing."""

    torques: Any  # stage (instance, lane, lanes, model, state, work): targets and torques; it ends with a barrier
    coordinates: Any = None  # stage (instance, lane, lanes, model, work): of joints of one coordinate, in their place
    advance: Any = None  # (instance, model, state): after the step, one lane calls it
    record: Any = None  # (instance, row, frame, state, record): what is recorded of its state, one lane calls it
    sense: Any = None  # stage of the same arguments as the first, before muscles; it ends with a barrier
    force: Any = None  # (instance, muscle, force that torques ask for, its row, model, state) -> force wanted of it, N
    renews: bool = False  # whether there are steps in which it has more to do than in others
    custom: CustomController = CustomController()  # what a scene names, in the place of the others

    @property
    def excites(self) -> bool:
        """Whether it excites muscles, which then tell what they feel."""
        return self.force is not None or self.custom.excitation is not None

    @property
    def extension(self) -> Any:
        """Structure of its own parameters and state."""
        own = self.custom
        memory = own.state + own.state_a_body
        return controller_extension(own.parameters, memory, own.by_joint, own.by_body, own.by_muscle)

    @property
    def recorded(self) -> bool:
        """Whether frames hold anything of its state."""
        return self.record is not None or bool(self.custom.recorded)


@func
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


@func
def last_change(instance: int, body: int, model: ModelRef, state: StateRef) -> wp.vec3:
    """By how much the speeds of a joint changed in the step before, rad/s.

    Damping c takes a speed extrapolated to now. As inertia h c it would brake by the speed of the next step; with h c
    times the last acceleration beside it, it does so only by what that has changed, and remains of second order.
    """
    first = model.skeleton.plan[body].speed_start
    change = wp.vec3(0.0)
    for k in range(model.skeleton.plan[body].speed_end - first):
        change[k] = state.accelerations[instance, first + k] * model.time_step
    return change


@func
def damped_inertia(instance: int, body: int, damping: wp.vec3, model: ModelRef, work: ScratchRef) -> symmetric:
    """What damping of a joint's speeds, N m s/rad, adds to its inertia over a step, kg m^2, world: h c by speed."""
    kind = model.skeleton.plan[body].joint_type
    rotation = work.rotation[body]
    inertia = damping * model.time_step
    if kind == BALL:
        return symmetric_rotated(rotation, inertia)
    if kind == FIXED:
        return symmetric(0.0)
    a = rotation * at(model.skeleton.row, instance, body).axis_a
    if kind == UNIVERSAL:  # dual axes, so that no speed feels the damping of the other one
        b = work.rotation[model.skeleton.plan[body].parent] * at(model.skeleton.row, instance, body).axis_b
        c = wp.dot(a, b)
        scale = 1.0 / (1.0 - c * c)
        return symmetric_outer((a - b * c) * scale, inertia[0]) + symmetric_outer((b - a * c) * scale, inertia[1])
    return symmetric_outer(a, inertia[0])


@func
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


@func
def no_torques_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """Neither targets nor torques. Ends with a barrier."""
    for i in range(lane, model.body_count, lanes):
        not_unrolled()
        work.target[i] = wp.quat(0.0, 0.0, 0.0, 1.0)
        work.torque[i] = wp.vec3(0.0, 0.0, 0.0)
        work.stiffness[i] = symmetric(0.0)
    synchronize()


NO_CONTROLLER = ControllerKind(no_torques_stage)


def asks_torques(controller: ControllerKind) -> bool:
    """Whether a controller may ask for torques of joints; else they are all 0."""
    custom = controller.custom
    own = custom.effort, custom.update, custom.damping, controller.coordinates
    return controller.torques is not no_torques_stage or any(function is not None for function in own)


@cache
def control_stage_of(controller: ControllerKind) -> Any:
    """The stage (instance, lane, lanes, model, state, work, extension) that says what is wanted of the joints.

    It puts that into the working set and ends with a barrier.
    """
    custom, extension_struct, torques = controller.custom, controller.extension, controller.torques
    has_effort, has_update, has_damping = (own is not None for own in (custom.effort, custom.update, custom.damping))
    effort = update = damping = None
    looked_at = not custom.shipped
    torque_of_effort, check = effort_torque if has_effort else None, checked_vector if looked_at else None
    change, inertia = (last_change, damped_inertia) if has_damping else (None, None)
    cause = cause_of(GIVEN_TORQUE if custom.effort is given_effort else EFFORT)
    if has_effort:
        effort = of_body(custom.effort, wp.vec3, custom.parameters, extension_struct, custom.values_of(custom.effort))
    if has_damping:
        damping = of_body(
            custom.damping, wp.vec3, custom.parameters, extension_struct, custom.values_of(custom.damping)
        )
    if has_update:
        update = of_instance(custom.update, custom.parameters, extension_struct, custom.values_of(custom.update))

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
                    wanted = check(wanted, instance, wp.static(cause) + i * wp.static(ENTRY), state, work)
                work.stiffness[i] = symmetric(0.0)
                if wp.static(has_damping):  # noqa: SIM102, what is not compiled may not be called
                    if model.implicit_pd == 1:
                        by_speed = damping(instance, i, 0, model, state, work, extension)
                        if wp.static(looked_at):
                            place = wp.static(cause) + i * wp.static(ENTRY)
                            by_speed = check(by_speed, instance, place, state, work)
                        wanted += wp.cw_mul(by_speed, change(instance, i, model, state))
                        work.stiffness[i] = inertia(instance, i, by_speed, model, work)
                work.torque[i] = torque_of_effort(instance, i, wanted, model, work)
            synchronize()
        else:
            torques(instance, lane, lanes, model, state, work)

    return stage


@cache
def record_controller_of(controller: ControllerKind) -> Any:
    """The Warp function (instance, frame, state, record, extension) that records what changes of a controller.

    It does so if a frame is due; one lane calls it.
    """
    record_custom, extension_struct = controller.record, controller.extension
    has_own, count = record_custom is not None, len(controller.custom.recorded)

    @wp.func
    def record_controller(
        instance: int, frame: int, state: StateRef, record: RecordRef, extension: wp.ref[extension_struct]
    ):
        if frame >= 0:
            row = record.slot[instance]
            if wp.static(has_own):
                record_custom(instance, row, frame, state, record)
            if wp.static(count > 0):
                for k in range(count):
                    record.memory[row, frame, k] = extension.memory[instance, 0, k]

    return record_controller


@cache
def force_of(controller: ControllerKind) -> Any:
    """The Warp function (instance, muscle, asked, row, model, state, work, extension) -> force wanted of a muscle, N.

    `asked` is what the joints' torques ask for, `row` the muscle's numbers.
    """
    custom, extension_struct, force = controller.custom, controller.extension, controller.force
    has_force, has_excitation = force is not None, custom.excitation is not None
    excitation, cause = force, cause_of(EXCITATION)
    if has_excitation:
        own = custom.values_of(custom.excitation)
        excitation = of_body(custom.excitation, float, custom.parameters, extension_struct, own)

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
            level = excitation(instance, muscle, 0, model, state, work, extension)
            level = checked(level, instance, wp.static(cause) + muscle * wp.static(ENTRY), state, work)
            if not (level < 0.0):
                wanted = row.f_max * within(level)
        return wanted

    return wanted_force


__getattr__ = of_former_names(__name__, {"Controller": "ControllerKind"})  # which users' modules may have
