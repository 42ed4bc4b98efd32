"""Whether a recorded motion is one of a scene."""

from __future__ import annotations

from collections.abc import Container

from warpmuscle.core.errors import Error
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene


def check_motion_of(motion: Recording, scene: Scene, name: str = "the motion") -> None:
    """Error unless a scene's character has all parts that moved, and its controller all states that it was in."""
    character = scene.character
    known: dict[str, Container[str]] = {
        "joint": character.joints,
        "body": character.bodies,
        "muscle": character.muscles,
    }
    if any(part not in parts for what, parts in known.items() for part in getattr(motion, f"{what}_names")):
        raise Error(f"{name} is of another character than the scene {scene.name!r}")
    states = len(scene.simbicon.states) if scene.simbicon is not None else 0
    if states and motion.frames and "state" not in motion.missing and int(motion.state.max()) >= states:
        raise Error(f"{name} is in state {motion.state.max()}, but the controller of {scene.name!r} has {states}")
