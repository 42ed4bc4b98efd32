"""Which gait a task imitates, and at which part of its cycle an episode starts."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.learning.imitation.gait import Gait, imitated, measured_gait, recorded_gait, seen_time
from warpmuscle.learning.imitation.kept_gaits import kept
from warpmuscle.learning.imitation.people import by_norm_alone, people_gait
from warpmuscle.learning.poses import State
from warpmuscle.learning.starts import ControllerGait, controller_gait
from warpmuscle.learning.symmetry import BodySymmetry
from warpmuscle.results.learned import KeptGait
from warpmuscle.scene.learning import Task
from warpmuscle.simulation.rollout import Rollout

LAST_FRAME = 0.02  # s, before the end of what was recorded whole


def gait_of_controller(task: Task, rollout: Rollout, decision_steps: int, recorded: bool) -> ControllerGait:
    """The gait of the scene's own controller, as far as the task needs it, recorded to be imitated if asked for."""
    variation, imitation = task.variation, task.imitation
    seen = seen_time(imitation) if recorded else 0.0
    if by_norm_alone(rollout.scene, imitation) or not (variation.start_states or seen):
        return ControllerGait([], [], None)
    return controller_gait(rollout, variation.start_states, variation.start_after, decision_steps, seen)


def imitated_gait(
    task: Task, rollout: Rollout, own: ControllerGait, body: BodySymmetry | None, known: Gait | None
) -> tuple[Gait | None, KeptGait | None]:
    """The gait that is imitated, if any: that of a file, of people, or of the scene's controller.

    Args:
        known: what the controller makes, where that need not be measured.

    Returns:
        The gait, and what a policy's file keeps of it, if the controller has just made it.
    """
    imitation = task.imitation
    if imitation is None:
        return None, None
    if imitation.file:
        return recorded_gait(rollout, imitation, body), None
    if by_norm_alone(rollout.scene, imitation):
        return people_gait(rollout, imitation, body), None
    made = None
    if known is None:
        if own.recording is None:
            return None, None
        known = measured_gait(own.recording, rollout, imitation)
        if own.recording.end > seen_time(imitation) - LAST_FRAME:  # it did not fail before
            made = kept(known, rollout.scene, imitation)
    return imitated(known, rollout, imitation, body), made


def phases_of(task: Task, rollout: Rollout, gait: Gait | None, states: list[State], times: Floats) -> Floats:
    """The parts of the cycle at which the clock stands in starts of these states and times, s, of the gait."""
    if gait is None:
        return np.zeros(len(times))
    imitation = task.imitation
    if imitation is None or not (imitation.file or by_norm_alone(rollout.scene, imitation)):
        return gait.phases(times)
    coordinates = np.stack([np.ascontiguousarray(state["coordinates"]).view(np.float32) for state in states])
    return gait.nearest(coordinates, rollout)
