"""Room on a device for all that changes while a batch runs."""

from __future__ import annotations

import math
from typing import Any

import warp as wp

from warpmuscle.core.arrays import instance_zeros, put
from warpmuscle.kernels import structs
from warpmuscle.model.controllers.table import controller_state
from warpmuscle.model.joint_groups import grouped_paths
from warpmuscle.model.muscles import ActuationMap, muscle_state, shared_joints
from warpmuscle.model.objective import term_arrays
from warpmuscle.model.paths import torque_parts
from warpmuscle.model.structure import Structure
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import greatest


def state_struct(
    scene: Scene, structure: Structure, instances: int, device: Any, side_by_side: bool = False, apart: bool = False
) -> structs.State:
    """The state of so many instances of a scene, all zero (see `kernels.structs.State`).

    Args:
        scene: checked scene, whose numbers may be free. side_by_side: see `core.arrays.instance_zeros`.
        apart: whether a kernel of its own finds paths of muscles.
    """

    def zeros(*shape: int, dtype: Any = float) -> wp.array:
        return instance_zeros(shape, dtype, device, side_by_side)

    n, names, objective, actuation = instances, structure.names, structure.objective, structure.actuation
    s = structs.State()
    s.coordinates = zeros(n, names.coordinates)
    s.speeds = zeros(n, names.speeds)
    s.accelerations = zeros(n, names.speeds)
    s.foot_force = zeros(n, 2, dtype=wp.vec3)
    s.start_height = zeros(n)
    s.start_heading = zeros(n)
    s.passed = zeros(n if objective.progress else 0, dtype=wp.vec3)
    s.push = zeros(n, dtype=wp.vec3)
    s.push_steps = zeros(n, 2, dtype=int)
    s.torque_integral = zeros(n, len(names.bodies), dtype=wp.float64)
    cycles = n if objective.follows_cycles else 0
    s.foot_cycle = zeros(cycles, 2, dtype=structs.FootCycle)
    for name in ("step", "status", "cause"):
        setattr(s, name, zeros(n, dtype=int))
    for place, array in controller_state(scene, n, names, zeros).items():
        put(s, place, array)
    table = actuation.table
    for name, array in term_arrays(objective, n, len(names.bodies), len(table.muscles), zeros).items():
        setattr(s, name, array)
    rows, floats = structure.parts.memory
    s.part_memory = zeros(n if rows else 0, rows, floats)
    capacity, excited = _ring_capacity(scene, actuation), structure.controller.excites
    sharing_bodies = len(names.bodies) if shared_joints(scene, names, actuation) > 0 else 0
    s.muscles = muscle_state(
        n, len(table.muscles), len(table.crossings), capacity, zeros, excited, sharing_bodies,
        len(names.bodies) if apart else 0, len(torque_parts(table)),
        len(grouped_paths(table, names, scene.character).groups),
    )  # fmt: skip
    return s


def _ring_capacity(scene: Scene, actuation: ActuationMap) -> int:
    """Steps that the delay lines hold: a power of two beyond the longest delay that a search may ask for."""
    muscles = [scene.character.muscles[name] for name in actuation.muscles]
    longest = max((greatest(scene, muscle.delay) for muscle in muscles), default=0.0)
    for impairment in scene.impairments.values():
        longest *= max(greatest(scene, impairment.delay), 1.0)
    return int(2 ** math.ceil(math.log2(longest / scene.time_step + 2.0)))
