"""What tells whether a run of a sweep is the one that began under its name."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import msgspec

from warpmuscle.scene import Scene
from warpmuscle.sweep.plan.runs import SweepRun

Text = Callable[[Scene], object]  # all of a scene
Texts = dict[int, object]  # of scenes, by their identity


def digest(run: SweepRun, texts: Texts, text: Text) -> str:
    """A digest of all that the result of a run depends on.

    Args:
        texts: keeps those of scenes from one run to the next, of which many may have the same one.
        text: all of a scene. Files are named as from the sweep's own; sweeps that began with versions before this one
            have digests of them as they were given then, or of the scene's TOML, which takes a hundred times as long.
    """
    if id(run.scene) not in texts:
        texts[id(run.scene)] = text(run.scene)
    options = sorted(asdict(run.options).items(), key=lambda item: item[0])
    parts: tuple[object, ...] = (texts[id(run.scene)], run.seed, options)
    if run.training is not None:
        parts = (*parts, run.training)
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:32]


def named_from(folder: Path, scene: Scene) -> Scene:
    """The scene with the recorded gaits that it follows named from a folder on, so that both may be moved."""

    def name(file: str) -> str:
        try:
            return Path(os.path.relpath(file, folder)).as_posix() if file else file
        except ValueError:  # it is on another drive
            return file

    change = msgspec.structs.replace
    if scene.tracking is not None:
        scene = change(scene, tracking=change(scene.tracking, file=name(scene.tracking.file)))
    if scene.learning is not None and scene.learning.imitation is not None:
        imitation = change(scene.learning.imitation, file=name(scene.learning.imitation.file))
        scene = change(scene, learning=change(scene.learning, imitation=imitation))
    return scene
