"""Torques of muscles on joints that very many of them cross, in parts: else all lanes wait for a few of them."""

import warp as wp

from warpmuscle.kernels.force.actuation import torque_of_forces
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.memory.scratch import synchronize
from warpmuscle.kernels.structs import ModelRef, ScratchRef, StateRef, nonnegative

MANY_CROSSINGS = 128  # more muscles than that cross some joint of a model whose torques are added up in parts ...
PART = 32  # ... of so many muscles at most


@func
def parts_stage(instance: int, lane: int, lanes: int, model: ModelRef, state: StateRef):
    """The torque of each part of a joint's muscles, the largest parts first. It ends with a barrier."""
    arms = state.muscles.moment_arm[nonnegative(instance)]
    forces = state.muscles.force[nonnegative(instance)]
    for k in range(lane, model.paths.torque_part.shape[0], lanes):
        part = model.paths.torque_part[nonnegative(k)]
        torque = torque_of_forces(nonnegative(part.first), part.end, arms, forces, model.paths.crossing_muscle)
        state.muscles.part_torque[nonnegative(instance), nonnegative(part.place)] = torque
    synchronize()


@func
def torque_of_parts(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> wp.vec3:
    """`actuation.muscle_torque` from what `parts_stage` has left."""
    total = wp.vec3(0.0)
    for place in range(model.paths.torque_part_start[body], model.paths.torque_part_start[body + 1]):
        total += state.muscles.part_torque[nonnegative(instance), nonnegative(place)]
    return total
