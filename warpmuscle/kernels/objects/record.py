"""What recordings have of objects: where they are and how they move, by frame."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.force.extensions import extension_list
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.object_structs import RECORDED, ObjectExtension
from warpmuscle.kernels.objects.motion import motion_now
from warpmuscle.kernels.structs import ModelRef, RecordRef, ScratchRef, StateRef, at


@func
def record_object(
    instance: int, number: int, frame: int, column: int, model: ModelRef, state: StateRef, record: RecordRef,
    work: ScratchRef, own: ObjectExtension,
):  # fmt: skip
    """Write place, orientation, velocity and angular velocity of an object from a column on."""
    motion = motion_now(instance, number, at(own.row, instance, number), model, state, work, own)
    row = record.slot[instance]
    for i in range(3):
        record.custom[row, frame, column + i] = motion.place[i]
        record.custom[row, frame, column + 7 + i] = motion.velocity[i]
        record.custom[row, frame, column + 10 + i] = motion.spin[i]
    for i in range(4):
        record.custom[row, frame, column + 3 + i] = motion.orientation[i]


@cache
def record_objects_of(forces: tuple[Any, ...]) -> Any:
    """The Warp function (instance, frame, column, model, state, record, work, extensions) that writes all objects."""
    extensions_struct = extension_list(tuple(force.extension for force in forces))
    here = forces[0].objects is not None
    others = record_object if here else record_objects_of(forces[1:])
    count = forces[0].objects.number if here else 0

    @wp.func
    def record_objects(
        instance: int, frame: int, column: int, model: ModelRef, state: StateRef, record: RecordRef,
        work: ScratchRef, extensions: wp.ref[extensions_struct],
    ):  # fmt: skip
        if wp.static(here):
            for number in range(count):
                place = column + number * wp.static(RECORDED)
                record_object(instance, number, frame, place, model, state, record, work, extensions.first)
        else:
            others(instance, frame, column, model, state, record, work, extensions.rest)

    return record_objects
