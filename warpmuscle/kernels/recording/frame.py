"""What a frame has beside the state: what the controller remembers, quantities of a scene, objects, belts, devices."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.contact.belts import record_belts
from warpmuscle.kernels.control.control import ControllerKind, record_controller_of
from warpmuscle.kernels.force.device_power import record_powers_of
from warpmuscle.kernels.force.extensions import extension_list
from warpmuscle.kernels.force.forces import ForceKind
from warpmuscle.kernels.object_structs import RECORDED
from warpmuscle.kernels.objects.record import record_objects_of
from warpmuscle.kernels.recording.record import RecordKind, custom_recorder_of, recorders_of
from warpmuscle.kernels.structs import ModelRef, RecordRef, ScratchRef, StateRef

BELTS = 2  # whose speeds are recorded


@cache
def frame_stage_of(kind: RecordKind, controller: ControllerKind, forces: tuple[ForceKind, ...], moves: bool) -> Any:
    """The Warp function that writes a frame, if one is due; memories of quantities go on in every step. No barrier.

    Args:
        moves: whether the ground does, as belts.
    """
    extensions_struct = extension_list((controller.extension, *(force.extension for force in forces)))
    _, record_stage = recorders_of(kind)
    recalled, quantities = kind.complete and controller.recorded, bool(kind.custom)
    record_controller = record_controller_of(controller) if recalled else None
    record_custom = custom_recorder_of(kind, False)
    record_world = record_world_of(kind, forces, moves) if kind.complete else None
    world = record_world is not None

    @wp.func(inline=True)
    def record_frame(
        instance: int, lane: int, lanes: int, step: int, frame: int, model: ModelRef, state: StateRef,
        record: RecordRef, work: ScratchRef, extensions: wp.ref[extensions_struct],
    ):  # fmt: skip
        record_stage(instance, lane, lanes, frame, model, state, record, work)
        if wp.static(recalled):  # noqa: SIM102, with `and` it would be compiled in all the same
            if lane == 0:
                record_controller(instance, frame, state, record, extensions.first)
        if wp.static(quantities) and lane == 0:
            record_custom(instance, frame, model, state, record, work)
        if wp.static(world):  # noqa: SIM102, as above
            if lane == 0 and frame >= 0:
                record_world(instance, step, frame, model, state, record, work, extensions.rest)

    return record_frame


@cache
def record_world_of(kind: RecordKind, forces: tuple[ForceKind, ...], moves: bool) -> Any:
    """The Warp function that writes objects, belts and powers of devices behind the quantities; None without any.

    One lane calls it, where a frame is due. Arguments are those of `frame_stage_of`.
    """
    extensions_struct = extension_list(tuple(force.extension for force in forces))
    objects = sum(force.objects.number for force in forces if force.objects)
    devices = any(force.device for force in forces)
    if not (objects or moves or devices):
        return None
    record_objects = record_objects_of(forces) if objects else None
    record_ground = record_belts if moves else None
    record_powers = record_powers_of(forces) if devices else None
    first_object = sum(3 if one.vector else 1 for one in kind.custom)  # column of `Record.custom`
    first_belt = first_object + RECORDED * objects
    first_power = first_belt + (BELTS if moves else 0)

    @wp.func(inline=True)
    def record_world(
        instance: int, step: int, frame: int, model: ModelRef, state: StateRef, record: RecordRef,
        work: ScratchRef, extensions: wp.ref[extensions_struct],
    ):  # fmt: skip
        if wp.static(objects > 0):
            record_objects(instance, frame, wp.static(first_object), model, state, record, work, extensions)
        row = record.slot[instance]
        if wp.static(moves):
            record_ground(instance, step, row, frame, wp.static(first_belt), model, record)
        if wp.static(devices):
            record_powers(instance, row, frame, wp.static(first_power), model, state, record, work, extensions)

    return record_world
