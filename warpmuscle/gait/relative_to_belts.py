"""Motions on a treadmill as they are seen from its belts: as if the ground stood still."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.treadmill.belt_motion import MEASURED_BELT, mean_shift

PLACES = ("root_position", "com", "body_position")


def over_belts(recording: Recording, scene: Scene) -> Recording:
    """The motion with all places relative to the belts, in their mean where they differ; itself on other ground.

    Velocities of centres of mass are recorded so. What comes back is not to be given again.
    """
    shift = belt_shift(recording, scene)
    if shift is None:
        return recording
    moved = {}
    for name in PLACES:
        places = getattr(recording, name)
        by = shift if places.ndim == 2 else shift[:, None]
        moved[name] = (places - by).astype(places.dtype)
    return recording.changed(**moved)


def belt_shift(recording: Recording, scene: Scene) -> Floats | None:
    """How far (F, 3) the belts have moved, m, world: those of the scene, or the one that was measured; None if none."""
    if scene.ground.treadmill is not None:
        return mean_shift(at_start(scene).ground, recording.time)
    names = recording.recorded_names
    if recording.frames == 0 or "recorded" in recording.missing or any(name not in names for name in MEASURED_BELT):
        return None
    velocity = recording.recorded[:, [names.index(name) for name in MEASURED_BELT]].astype(float)
    steps = 0.5 * (velocity[1:] + velocity[:-1]) * np.diff(recording.time)[:, None]
    shift = np.zeros((recording.frames, 3))
    shift[1:, [0, 2]] = np.cumsum(steps, axis=0)
    return shift
