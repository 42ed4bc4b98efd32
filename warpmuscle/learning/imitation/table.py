"""What of an imitated gait kernels read: angles and forces over the cycle at each of some wanted speeds."""

from __future__ import annotations

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import to_device
from warpmuscle.core.errors import RolloutError
from warpmuscle.kernels.learning import reward_structs as kernels
from warpmuscle.learning.imitation.gait import BINS, Gait, with_norm
from warpmuscle.scene.learning import Imitation, Task
from warpmuscle.scene.norms import PERCENT_OF_BIN, is_run, running_force, running_stance, walking_force
from warpmuscle.simulation.rollout import Rollout

ROOT = "root"  # among the weights
SPEEDS = 12  # evenly over the wanted ones, for which there are tables


def table_speeds(task: Task) -> Floats:
    """Wanted speeds (n,), m/s, for which tables are made: one if nothing changes with the speed."""
    low, high = task.speed
    imitation = task.imitation or Imitation()
    changing = low < high and (imitation.moving or imitation.run is not None or task.rewards.force > 0.0)
    return np.linspace(low, high, SPEEDS) if changing else np.array([0.5 * (low + high)])


def smoothed_over_cycle(curve: Floats, cycle_time: float, time_constant: float) -> Floats:
    """A curve (BINS,) over a cycle after a low-pass of first order, once it goes round and round."""
    share = 1.0 - np.exp(-cycle_time / BINS / time_constant) if time_constant > 0.0 else 1.0
    value, found = float(curve.mean()), np.empty(BINS)
    for _ in range(3):  # rounds, of which the last is kept
        for k, now in enumerate(curve):
            value += share * (now - value)
            found[k] = value
    return found


def gait_table(gait: Gait, task: Task, rollout: Rollout) -> kernels.GaitTable:
    """The gait as kernels read it; raises RolloutError if nothing of it counts."""
    names, device, imitation = rollout.names, rollout.device, task.imitation or Imitation()
    first, end, weight = [], [], []
    for body, name in enumerate(names.joints, start=1):
        span = names.coordinate_start[body], names.coordinate_start[body + 1]
        if span[1] > span[0]:
            first.append(span[0])
            end.append(span[1])
            weight.append(imitation.weights.get(name, 1.0))
    upright = imitation.weights.get(ROOT, 1.0)
    total = sum(weight) + upright
    if not total > 0.0:
        raise RolloutError("no joint of the imitated gait has any weight")
    table = kernels.GaitTable()
    speeds = table_speeds(task)
    gaits = [gait_at(gait, task, rollout, v) for v in speeds.tolist()]
    table.coordinate = to_device(np.concatenate([one.coordinate for one in gaits]), float, device)
    table.up = to_device(gait.up, wp.vec3, device)
    table.force = to_device(np.stack([wanted_forces(gait, task, v) for v in speeds.tolist()]), float, device)
    table.right, table.speeds, table.first_speed = gait.right, len(speeds), float(speeds[0])
    table.speed_step = float(speeds[1] - speeds[0]) if len(speeds) > 1 else 1.0
    table.first, table.end = to_device(np.array(first), int, device), to_device(np.array(end), int, device)
    table.weight = to_device(np.array(weight) / total, float, device)
    table.up_weight = upright / total
    return table


def run_from(task: Task) -> float | None:
    """The wanted speed from which a gait is a run, m/s: between two of the table's; None where it never becomes one."""
    run = None if task.imitation is None else task.imitation.run
    if run is None:
        return None
    speeds = table_speeds(task)
    fast = int(np.searchsorted(speeds, run.above))
    return float(speeds[fast - 1 : fast + 1].mean())


def running_at(gait: Gait, task: Task, speed: float) -> Gait | None:
    """The run that a gait is at a wanted speed, m/s, if it is one there."""
    switch = run_from(task)
    return gait.running if switch is not None and speed >= switch else None


def gait_at(gait: Gait, task: Task, rollout: Rollout, speed: float) -> Gait:
    """The gait whose angles are imitated at a wanted speed, m/s."""
    imitation, run = task.imitation or Imitation(), running_at(gait, task, speed)
    one, norm = (gait, imitation.norm) if run is None or imitation.run is None else (run, imitation.run.norm)
    return with_norm(one, norm, rollout, speed) if imitation.moving else one


def wanted_forces(gait: Gait, task: Task, speed: float) -> Floats:
    """People's vertical force on the left foot at a speed, m/s, over the cycle (BINS,), smoothed as the body's is."""
    imitation = task.imitation or Imitation()
    run = running_at(gait, task, speed)
    one, clock = (gait, imitation) if run is None or imitation.run is None else (run, imitation.run)
    cycle = one.cycle_time * (max(speed, 0.1) / clock.clock_speed) ** -clock.cadence_power
    if run is not None or is_run(imitation.norm):
        force = running_force(PERCENT_OF_BIN, running_stance(speed))
    else:
        force = walking_force(PERCENT_OF_BIN, speed)
    return smoothed_over_cycle(force, cycle, task.rewards.force_smoothing)
