"""What devices give to the joints and bodies that they act on, by frame of a recording."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.force.extensions import extension_list, of_body
from warpmuscle.kernels.force.forces import ForceKind, Wrench
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, RecordRef, ScratchRef, StateRef, at


@func
def effort_power(instance: int, body: int, effort: wp.vec3, model: ModelRef, state: StateRef) -> float:
    """Power of efforts along the speeds of a joint, W."""
    first = model.skeleton.plan[body].speed_start
    power = wp.float32(0.0)
    for k in range(model.skeleton.plan[body].speed_end - first):
        power += effort[k] * state.speeds[instance, first + k]
    return power


@func
def wrench_power(instance: int, body: int, wrench: Wrench, model: ModelRef, work: ScratchRef) -> float:
    """Power of a force at the centre of mass of a body and of a moment about it, W."""
    c = work.rotation[body] * at(model.skeleton.row, instance, body).com
    velocity = work.velocity[body] + wp.cross(work.angular_velocity[body], c)
    return wp.dot(wrench.force, velocity) + wp.dot(wrench.moment, work.angular_velocity[body])


@func
def nothing(
    instance: int, row: int, frame: int, column: int, model: ModelRef, state: StateRef, record: RecordRef,
    work: ScratchRef, extensions: int,
):  # fmt: skip
    """What is written behind the last kind."""


@cache
def power_of(force: ForceKind) -> Any:
    """The Warp function (instance, body, entry, model, state, work, extension) -> power of a device on a body, W."""
    effort, wrench, pair = force.effort is not None, force.wrench is not None, force.pair is not None
    extension_struct = force.extension
    acting = force.pair
    if not pair:
        acting = of_body(force.effort or force.wrench, wp.vec3 if effort else Wrench, force.parameters, force.extension)

    @wp.func
    def power(
        instance: int,
        body: int,
        entry: int,
        model: ModelRef,
        state: StateRef,
        work: ScratchRef,
        extension: wp.ref[extension_struct],
    ) -> float:
        if wp.static(effort):
            given = acting(instance, body, entry, model, state, work, extension)
            return effort_power(instance, body, given, model, state)
        elif wp.static(wrench):
            pushed = acting(instance, body, entry, model, state, work, extension)
            return wrench_power(instance, body, pushed, model, work)
        else:
            p = at(extension.parameters, instance, entry)
            other = extension.other[entry]
            here = acting(instance, body, other, extension.second[entry], model, state, work, p)
            there = acting(instance, other, body, 1 - extension.second[entry], model, state, work, p)
            return wrench_power(instance, body, here, model, work) + wrench_power(instance, other, there, model, work)

    return power


@cache
def record_powers_of(forces: tuple[ForceKind, ...]) -> Any:
    """The Warp function (instance, row, frame, column, model, state, record, work, extensions) that writes all powers.

    Those of devices stand one behind the other from a column of `Record.custom` on, by kind and then by body; one
    between two bodies is counted at the first of them. One lane calls it, where a frame is due.
    """
    extensions_struct = extension_list(tuple(force.extension for force in forces))
    device, pairs = bool(forces) and forces[0].device, bool(forces) and forces[0].pair is not None
    power = power_of(forces[0]) if device else nothing
    others = record_powers_of(forces[1:]) if forces else nothing

    @wp.func
    def record_powers(
        instance: int, row: int, frame: int, column: int, model: ModelRef, state: StateRef, record: RecordRef,
        work: ScratchRef, extensions: wp.ref[extensions_struct],
    ):  # fmt: skip
        place = int(column)
        if wp.static(device):
            for body in range(model.body_count):
                for entry in range(extensions.first.start[body], extensions.first.start[body + 1]):
                    counted = True
                    if wp.static(pairs):
                        counted = extensions.first.second[entry] == 0
                    if counted:
                        value = power(instance, body, entry, model, state, work, extensions.first)
                        record.custom[row, frame, place] = value
                        place += 1
        if wp.static(bool(forces)):
            others(instance, row, frame, place, model, state, record, work, extensions.rest)

    return record_powers
