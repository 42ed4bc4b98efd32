"""Motions on a treadmill as they are seen from its belts: as if the ground stood still."""

from __future__ import annotations

from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.treadmill.belt_motion import mean_shift

PLACES = ("root_position", "com", "body_position")


def over_belts(recording: Recording, scene: Scene) -> Recording:
    """The motion with all places relative to the belts, in their mean where they differ; itself on other ground.

    Velocities of centres of mass are recorded so.
    """
    if scene.ground.treadmill is None:
        return recording
    shift = mean_shift(at_start(scene).ground, recording.time)
    moved = {}
    for name in PLACES:
        places = getattr(recording, name)
        by = shift if places.ndim == 2 else shift[:, None]
        moved[name] = (places - by).astype(places.dtype)
    return recording.changed(**moved)
