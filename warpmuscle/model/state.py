"""Room on a device for all that changes while a batch runs."""

from __future__ import annotations

import math
from typing import Any

import warp as wp

from warpmuscle.kernels import structs
from warpmuscle.model.controller import control_steps
from warpmuscle.model.muscles import ActuationMap, kept_rows, muscle_state
from warpmuscle.model.objective import term_arrays
from warpmuscle.model.structure import Structure
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import greatest


def state_struct(scene: Scene, structure: Structure, instances: int, device: Any) -> structs.State:
    """The state of so many instances of a scene, all zero (see `kernels.structs.State`).

    Args:
        scene: checked scene, whose numbers may be free.
    """
    n, names, objective, actuation = instances, structure.names, structure.objective, structure.actuation
    s = structs.State()
    s.coordinates = wp.zeros((n, names.coordinates), dtype=float, device=device)
    s.speeds = wp.zeros((n, names.speeds), dtype=float, device=device)
    s.accelerations = wp.zeros((n, names.speeds), dtype=float, device=device)
    s.phase = wp.zeros(n, dtype=float, device=device)
    s.foot_force = wp.zeros((n, 2), dtype=wp.vec3, device=device)
    s.start_height = wp.zeros(n, dtype=float, device=device)
    s.start_heading = wp.zeros(n, dtype=float, device=device)
    s.push = wp.zeros(n, dtype=wp.vec3, device=device)
    s.push_steps = wp.zeros((n, 2), dtype=int, device=device)
    s.torque_integral = wp.zeros((n, len(names.bodies)), dtype=wp.float64, device=device)
    cycles = n if objective.follows_cycles else 0
    s.foot_cycle = wp.zeros((cycles, 2), dtype=structs.FootCycle, device=device)
    held = n if control_steps(scene) > 1 else 0
    s.target = wp.zeros((held, len(names.bodies)), dtype=wp.quat, device=device)
    s.target_plan = wp.zeros((held, len(names.bodies)), dtype=wp.vec2, device=device)
    for name in ("stance", "machine_state", "step", "status"):
        setattr(s, name, wp.zeros(n, dtype=int, device=device))
    table = actuation.table
    for name, array in term_arrays(objective, n, len(names.bodies), len(table.muscles), device).items():
        setattr(s, name, array)
    capacity, excited = _ring_capacity(scene, actuation), structure.controller.excites
    arms = kept_rows(scene, names, actuation)
    s.muscles = muscle_state(n, len(table.muscles), arms, capacity, device, excited)
    return s


def _ring_capacity(scene: Scene, actuation: ActuationMap) -> int:
    """Steps that the delay lines hold: a power of two beyond the longest delay that a search may ask for."""
    muscles = [scene.character.muscles[name] for name in actuation.muscles]
    longest = max((greatest(scene, muscle.delay) for muscle in muscles), default=0.0)
    return int(2 ** math.ceil(math.log2(longest / scene.time_step + 2.0)))
