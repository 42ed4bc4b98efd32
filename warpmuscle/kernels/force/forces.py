"""Torques and forces that act on joints and bodies besides muscles and the controller: devices, drag, what one likes.

Each kind is a `ForceKind`, of a file like `devices.py` or of a user's module; a scene's `forces` say where they act.
They are explicit: a stiffness k and a damping d on an inertia I need a step shorter than d/k and I/d or so.
Joint springs of the actuation, which are implicit where PD or muscles are, stand in `springs.py`.
"""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.control.control import effort_torque
from warpmuscle.kernels.force.extensions import extension_list, extension_type, of_body, touch_extension
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.moved import of_former_names
from warpmuscle.kernels.object_structs import ObjectExtension
from warpmuscle.kernels.objective.causes import ENTRY, FORCE, blame, cause_of, checked_vector
from warpmuscle.kernels.objective.failure import is_somewhere
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, at
from warpmuscle.kernels.water_structs import WaterExtension


@wp.struct
class Wrench:
    """What acts on a body, world axes."""

    force: wp.vec3  # N, at the centre of mass
    moment: wp.vec3  # N m, about it


@func
def look_at(wrench: Wrench, instance: int, cause: int, state: StateRef, work: ScratchRef):
    """Let a force be to blame for a wrench that is none, or beyond all bounds."""
    if not (is_somewhere(wrench.force) and is_somewhere(wrench.moment)):
        blame(instance, cause, state, work)


class ForceKind(NamedTuple):
    """A kind of torque on joints, or of force on bodies: one Warp function, its parameters and its state.

    The function takes what is in brackets if it is declared: `parameters`, a `@wp.struct` of floats whose values stand
    with each force of the scene, and `state`, so many floats of each force, zero at the start of an instance. It is
    called once a step for each force, and may write that state. One between two bodies is called for each of them, has
    parameters, and no state. Bodies that touch, see `touching.py`, are of one kind at most, which has parameters.
    """

    effort: Any = None  # (instance, body, model, state, work [, parameters] [, state]) -> wp.vec3: of body's joint, N m
    wrench: Any = None  # the same, but of a body -> Wrench
    pair: Any = None  # (instance, body, other, second, model, state, work, parameters) -> Wrench on body
    parameters: Any = None
    state: int = 0
    touch: Any = None  # (instance, first, second, model, work, parameters) -> touching.Touch, of bodies that may touch
    positive: tuple[str, ...] = ()  # parameters that are divided by
    shipped: bool = False  # one of `devices.FORCES`, whose values need not be looked at
    of_angle: bool = False  # whether it is of a joint's first coordinate, which a ball joint has none of
    device: bool = False  # whether recordings have its power; of one without a state
    of_leg: bool = False  # whether it asks in which part of its gait cycle the foot beyond its joint is
    water: bool = False  # of water, all of it
    objects: Any = None  # of objects beside the character, all of them together: `objects.stage.ObjectsKind`

    @property
    def extension(self) -> Any:
        """Structure of the parameters and states of all forces of this kind."""
        if self.water:
            return WaterExtension
        if self.objects is not None:
            return ObjectExtension
        if self.touch is not None:
            return touch_extension(self.parameters)
        return extension_type(self.parameters, self.state, True, self.pair is not None)


@cache
def torque_of(forces: tuple[ForceKind, ...], place: int = 0) -> Any:
    """The Warp function (instance, body, torque, model, state, work, extensions) -> torque and all forces on its joint.

    Torques act on the parent, world, N m. `place` is that of the first force among all kinds.
    """
    looked_at, cause = bool(forces) and not forces[0].shipped, cause_of(FORCE, place)
    extensions_struct = extension_list(tuple(force.extension for force in forces))
    acts = bool(forces) and forces[0].effort is not None
    effort, others = effort_torque, effort_torque
    if acts:
        effort = of_body(forces[0].effort, wp.vec3, forces[0].parameters, forces[0].extension)
    if forces:
        others = torque_of(forces[1:], place + 1)

    @wp.func
    def total(
        instance: int,
        body: int,
        torque: wp.vec3,
        model: ModelRef,
        state: StateRef,
        work: ScratchRef,
        extensions: wp.ref[extensions_struct],
    ) -> wp.vec3:
        acting = torque
        if wp.static(acts):
            for entry in range(extensions.first.start[body], extensions.first.start[body + 1]):
                given = effort(instance, body, entry, model, state, work, extensions.first)
                if wp.static(looked_at):
                    number = wp.static(cause) + entry * wp.static(ENTRY)
                    given = checked_vector(given, instance, number, state, work)
                acting += effort_torque(instance, body, given, model, work)
        if wp.static(bool(forces)):
            acting = others(instance, body, acting, model, state, work, extensions.rest)
        return acting

    return total


@cache
def wrench_of(forces: tuple[ForceKind, ...], place: int = 0) -> Any:
    """The Warp function (instance, body, wrench, model, state, work, extensions) -> that and all forces on a body.

    `place` is that of the first force among all kinds.
    """
    looked_at, cause = bool(forces) and not forces[0].shipped, cause_of(FORCE, place)
    extensions_struct = extension_list(tuple(force.extension for force in forces))
    acts = bool(forces) and forces[0].wrench is not None
    wrench_on, others = effort_torque, effort_torque
    pairs = bool(forces) and forces[0].pair is not None
    of_pair = forces[0].pair if pairs else effort_torque
    if acts:
        wrench_on = of_body(forces[0].wrench, Wrench, forces[0].parameters, forces[0].extension)
    if forces:
        others = wrench_of(forces[1:], place + 1)

    @wp.func
    def total(
        instance: int,
        body: int,
        wrench: Wrench,
        model: ModelRef,
        state: StateRef,
        work: ScratchRef,
        extensions: wp.ref[extensions_struct],
    ) -> Wrench:
        acting = wrench
        if wp.static(acts):
            for entry in range(extensions.first.start[body], extensions.first.start[body + 1]):
                given = wrench_on(instance, body, entry, model, state, work, extensions.first)
                if wp.static(looked_at):
                    look_at(given, instance, wp.static(cause) + entry * wp.static(ENTRY), state, work)
                acting.force += given.force
                acting.moment += given.moment
        if wp.static(pairs):
            for entry in range(extensions.first.start[body], extensions.first.start[body + 1]):
                p = at(extensions.first.parameters, instance, entry)
                end = extensions.first.second[entry]
                pushed = of_pair(instance, body, extensions.first.other[entry], end, model, state, work, p)
                if wp.static(looked_at):
                    look_at(pushed, instance, wp.static(cause) + entry * wp.static(ENTRY), state, work)
                acting.force += pushed.force
                acting.moment += pushed.moment
        if wp.static(bool(forces)):
            acting = others(instance, body, acting, model, state, work, extensions.rest)
        return acting

    return total


@cache
def joint_forces_stage_of(forces: tuple[ForceKind, ...]) -> Any:
    """The stage that adds what acts on the joints to their torques, in the order of bodies. It ends with a barrier."""
    extensions_struct = extension_list(tuple(force.extension for force in forces))
    torque = torque_of(forces)

    @wp.func
    def joint_forces_stage(
        instance: int,
        lane: int,
        lanes: int,
        model: ModelRef,
        state: StateRef,
        work: ScratchRef,
        extensions: wp.ref[extensions_struct],
    ):
        for i in range(1 + lane, model.body_count, lanes):
            work.torque[i] = torque(instance, i, work.torque[i], model, state, work, extensions)
        synchronize()

    return joint_forces_stage


@cache
def body_forces_stage_of(forces: tuple[ForceKind, ...]) -> Any:
    """The stage that adds what acts on the bodies to their bias forces. It ends with a barrier."""
    extensions_struct = extension_list(tuple(force.extension for force in forces))
    wrench_on = wrench_of(forces)

    @wp.func
    def body_forces_stage(
        instance: int,
        lane: int,
        lanes: int,
        model: ModelRef,
        state: StateRef,
        work: ScratchRef,
        extensions: wp.ref[extensions_struct],
    ):
        for i in range(lane, model.body_count, lanes):
            acting = wrench_on(instance, i, Wrench(), model, state, work, extensions)
            c = work.rotation[i] * at(model.skeleton.row, instance, i).com
            work.bias_force[i] = work.bias_force[i] - acting.force
            work.bias_moment[i] = work.bias_moment[i] - acting.moment - wp.cross(c, acting.force)
        synchronize()

    return body_forces_stage


__getattr__ = of_former_names(__name__, {"Force": "ForceKind"})  # which users' modules may have
