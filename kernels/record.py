"""Frames of chosen instances."""

import warp as wp

from warpmuscle.kernels.structs import Model, Record, State, Work


@wp.func
def record_stage(
    instance: int, lane: int, lanes: int, step: int, model: Model, state: State, record: Record, work: Work
):
    """Write a frame if this instance is recorded and this step is due. Ends without a barrier.

    Forces on the feet are those of the step before, as the controller sees them.
    """
    if record.every == 0:
        return
    row = record.slot[instance]
    frame = step / record.every
    if row < 0 or step % record.every != 0 or frame >= record.phase.shape[1]:
        return
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
        record.target[row, frame, i] = work.target[i]
