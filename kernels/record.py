"""Frames of chosen instances."""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.structs import ModelRef, RecordRef, ScratchRef, StateRef


class RecordKind(NamedTuple):
    """What a step records."""

    whole: bool = True  # everything; else the coordinates and speeds
    muscles: bool = True  # and what the muscles do
    motion: bool = True  # not nothing at all


NOTHING = RecordKind(False, False, False)


@wp.func
def frame_of(instance: int, step: int, record: RecordRef) -> int:
    """The frame to be written in this step, or -1: the instance is not recorded, or no frame is due."""
    if record.every == 0:
        return -1
    if record.slot[instance] < 0 or step % record.every != 0 or step / record.every >= record.coordinates.shape[1]:
        return -1
    return step / record.every


@wp.func
def record_desired(
    instance: int,
    lane: int,
    lanes: int,
    frame: int,
    model: ModelRef,
    state: StateRef,
    record: RecordRef,
    work: ScratchRef,
):
    """Write what the controller wants, if a frame is due. Ends without a barrier."""
    if frame < 0:
        return
    row = record.slot[instance]
    for i in range(lane, model.body_count, lanes):
        record.desired_torque[row, frame, i] = work.torque[i]
        record.target[row, frame, i] = work.target[i]


@wp.func
def record_stage(
    instance: int,
    lane: int,
    lanes: int,
    frame: int,
    model: ModelRef,
    state: StateRef,
    record: RecordRef,
    work: ScratchRef,
):
    """Write the state and the torques that act, if a frame is due. Ends without a barrier.

    Forces on the feet are those of the step before, as the controller sees them.
    """
    if frame < 0:
        return
    row = record.slot[instance]
    if lane == 0:
        record.phase[row, frame] = state.phase[instance]
        record.stance[row, frame] = state.stance[instance]
        record.machine_state[row, frame] = state.machine_state[instance]
        for i in range(2):
            record.com[row, frame, i] = work.center[i]
            record.foot_force[row, frame, i] = state.foot_force[instance, i]
    for i in range(lane, state.coordinates.shape[1], lanes):
        record.coordinates[row, frame, i] = state.coordinates[instance, i]
    for i in range(lane, state.speeds.shape[1], lanes):
        record.speeds[row, frame, i] = state.speeds[instance, i]
    for i in range(lane, model.body_count, lanes):
        record.orientation[row, frame, i] = work.orientation[i]
        record.position[row, frame, i] = work.position[i]
        record.angular_velocity[row, frame, i] = work.angular_velocity[i]
        record.torque[row, frame, i] = work.torque[i]


@wp.func
def record_motion(
    instance: int,
    lane: int,
    lanes: int,
    frame: int,
    model: ModelRef,
    state: StateRef,
    record: RecordRef,
    work: ScratchRef,
):
    """Write coordinates and speeds alone, if a frame is due. Ends without a barrier."""
    if frame < 0:
        return
    row = record.slot[instance]
    for i in range(lane, state.coordinates.shape[1], lanes):
        record.coordinates[row, frame, i] = state.coordinates[instance, i]
    for i in range(lane, state.speeds.shape[1], lanes):
        record.speeds[row, frame, i] = state.speeds[instance, i]


@wp.func
def record_nothing(
    instance: int,
    lane: int,
    lanes: int,
    frame: int,
    model: ModelRef,
    state: StateRef,
    record: RecordRef,
    work: ScratchRef,
):
    """Write nothing."""


@cache
def recorders_of(kind: RecordKind) -> tuple[Any, Any]:
    """The Warp functions that record what the controller wants, and the state, see `record_stage`."""
    if kind.whole:
        return record_desired, record_stage
    return record_nothing, record_motion if kind.motion else record_nothing
