"""Which gait a task imitates, and at which part of its cycle an episode starts."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.learning.imitation.gait import Gait, gait_of, recorded_gait, seen_time
from warpmuscle.learning.imitation.people import by_norm_alone, people_gait
from warpmuscle.learning.poses import State
from warpmuscle.learning.starts import ControllerGait, controller_gait
from warpmuscle.learning.symmetry import BodySymmetry
from warpmuscle.scene.learning import Task
from warpmuscle.simulation.rollout import Rollout


def gait_of_controller(task: Task, rollout: Rollout, decision_steps: int, recorded: bool) -> ControllerGait:
    """The gait of the scene's own controller, as far as the task needs it, recorded to be imitated if asked for."""
    variation, imitation = task.variation, task.imitation
    seen = seen_time(imitation) if recorded else 0.0
    if by_norm_alone(rollout.scene, imitation) or not (variation.start_states or seen):
        return ControllerGait([], [], None)
    return controller_gait(rollout, variation.start_states, variation.start_after, decision_steps, seen)


def imitated_gait(task: Task, rollout: Rollout, own: ControllerGait, body: BodySymmetry | None) -> Gait | None:
    """The gait that is imitated, if any: that of a file, of people, or of the scene's controller."""
    imitation = task.imitation
    if imitation is None:
        return None
    if imitation.file:
        return recorded_gait(rollout, imitation, body)
    if by_norm_alone(rollout.scene, imitation):
        return people_gait(rollout, imitation, body)
    return None if own.recording is None else gait_of(own.recording, rollout, imitation, body)


def phases_of(task: Task, rollout: Rollout, gait: Gait | None, states: list[State], times: Floats) -> Floats:
    """The parts of the cycle at which the clock stands in starts of these states and times, s, of the gait."""
    if gait is None:
        return np.zeros(len(times))
    imitation = task.imitation
    if imitation is None or not (imitation.file or by_norm_alone(rollout.scene, imitation)):
        return gait.phases(times)
    coordinates = np.stack([np.ascontiguousarray(state["coordinates"]).view(np.float32) for state in states])
    return gait.nearest(coordinates, rollout)
