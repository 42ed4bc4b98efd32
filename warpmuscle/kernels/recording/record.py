"""Frames of chosen instances."""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.algebra.spatial import symmetric_times
from warpmuscle.kernels.body.coordinate_joint import coordinate_axis
from warpmuscle.kernels.body.joint_motion import has_motion
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import FOLLOWER, ModelRef, RecordRef, ScratchRef, StateRef, nonnegative, not_unrolled


class CustomQuantity(NamedTuple):
    """A recorded quantity of a scene's own."""

    function: Any  # (instance, model, state, work) -> float or wp.vec3
    column: int  # of its first number in `Record.custom`
    vector: bool  # whether it has three numbers
    accelerated: bool  # whether it sees accelerations
    remembers: bool  # whether it is called in every step, since it has a memory, and not for frames alone


class RecordKind(NamedTuple):
    """What a step records."""

    complete: bool = True  # everything; else the coordinates and speeds
    muscles: bool = True  # and what the muscles do
    motion: bool = True  # not nothing at all
    custom: tuple[CustomQuantity, ...] = ()

    @property
    def accelerated(self) -> bool:
        """Whether something that is recorded sees accelerations."""
        return any(one.accelerated for one in self.custom)


NOTHING = RecordKind(False, False, False)


@func
def frame_of(instance: int, step: int, record: RecordRef) -> int:
    """The frame to be written in this step, or -1: the instance is not recorded, or no frame is due."""
    if record.every == 0:
        return -1
    if record.slot[instance] < 0 or step % record.every != 0 or step / record.every >= record.coordinates.shape[1]:
        return -1
    return step / record.every


@func
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


@func
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
    """Write the state and the torques of the step's start, if a frame is due. Ends without a barrier.

    Forces on the feet are those of the step before, as the controller sees them. What torques give way over the step
    is added by `record_given_way_of`.
    """
    if frame < 0:
        return
    row = record.slot[instance]
    if lane == 0:
        for i in range(2):
            record.com[row, frame, i] = work.center[i]
            record.foot_force[row, frame, i] = state.foot_force[instance, i]
    for i in range(lane, state.coordinates.shape[1], lanes):
        record.coordinates[row, frame, i] = state.coordinates[instance, i]
    for i in range(lane, state.speeds.shape[1], lanes):
        record.speeds[row, frame, i] = state.speeds[instance, i]
    for i in range(lane, model.body_count, lanes):
        not_unrolled()
        record.orientation[row, frame, i] = work.orientation[i]
        record.position[row, frame, i] = work.position[i]
        record.angular_velocity[row, frame, i] = work.angular_velocity[i]
        record.torque[row, frame, i] = work.torque[i]
        record.stiffness[row, i] = work.stiffness[i]


@func
def turning_acceleration(instance: int, body: int, model: ModelRef, work: ScratchRef) -> wp.vec3:
    """Acceleration of what is not prescribed of a joint, along which its implicit inertia acts, world, rad/s^2."""
    parent = nonnegative(model.skeleton.plan[body].parent)
    return work.angular_acceleration[body] - work.angular_acceleration[parent] - work.bias[body]


@func
def any_acceleration(instance: int, body: int, model: ModelRef, work: ScratchRef) -> wp.vec3:
    """The same where there may be joints of one coordinate; of those that follow, which have no torque, nothing."""
    kind = model.skeleton.plan[body].joint_type
    if kind == FOLLOWER:
        return wp.vec3(0.0)
    if has_motion(kind):
        return coordinate_axis(instance, body, model, work) * work.factor_c[body][0]
    return turning_acceleration(instance, body, model, work)


@cache
def record_given_way_of(coordinate_joints: bool) -> Any:
    """The Warp function that makes of torques at a step's start those that act over it, if a frame is due. No barrier.

    These are K x more, by how the joint accelerates. K is the implicit inertia of all that drives the joint, without
    its stops; see `dynamics.py`.

    Args:
        coordinate_joints: whether there are joints as in `coordinate_joint.py`.
    """
    acceleration = any_acceleration if coordinate_joints else turning_acceleration

    @wp.func
    def record_given_way(
        instance: int, lane: int, lanes: int, frame: int, model: ModelRef, record: RecordRef, work: ScratchRef
    ):
        if frame < 0:
            return
        row = record.slot[instance]
        for i in range(1 + lane, model.body_count, lanes):
            not_unrolled()
            more = symmetric_times(record.stiffness[row, i], acceleration(instance, i, model, work))
            record.torque[row, frame, i] = record.torque[row, frame, i] + more

    return record_given_way


@func
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


@func
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
    if kind.complete:
        return record_desired, record_stage
    return record_nothing, record_motion if kind.motion else record_nothing


@func
def no_custom(instance: int, frame: int, model: ModelRef, state: StateRef, record: RecordRef, work: ScratchRef):
    """Nothing of the scene's own is recorded."""


def _and_custom(others: Any, one: CustomQuantity) -> Any:
    function, column, vector, remembers = one.function, one.column, one.vector, one.remembers

    @wp.func
    def put(instance: int, frame: int, model: ModelRef, state: StateRef, record: RecordRef, work: ScratchRef):
        others(instance, frame, model, state, record, work)
        if frame < 0 and wp.static(not remembers):
            return
        value = function(instance, model, state, work)
        if frame >= 0:
            row = record.slot[instance]
            if wp.static(vector):
                for k in range(3):
                    record.custom[row, frame, wp.static(column) + k] = value[k]
            else:
                record.custom[row, frame, wp.static(column)] = value

    return put


@cache
def custom_recorder_of(kind: RecordKind, accelerated: bool) -> Any:
    """The Warp function (instance, frame, model, state, record, work) that writes what the scene's own functions say.

    One lane calls it in every step.

    Args:
        accelerated: of those that see accelerations, else of the others.
    """
    every = no_custom
    for one in kind.custom:
        if one.accelerated == accelerated:
            every = _and_custom(every, one)
    return every
