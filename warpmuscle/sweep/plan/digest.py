"""What tells whether a run of a sweep is the one that began under its name."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import msgspec

from warpmuscle.formats import toml
from warpmuscle.scene import Scene
from warpmuscle.sweep.plan.runs import SweepRun

Text = Callable[[Scene], object]  # all of a scene
Texts = dict[int, object]  # of scenes, by their identity


def digest(run: SweepRun, texts: Texts, text: Text) -> str:
    """A digest of all that the result of a run depends on.

    Args:
        texts: keeps those of scenes from one run to the next, of which many may have the same one.
        text: all of a scene, in which files are named as from the sweep's own.
    """
    if id(run.scene) not in texts:
        texts[id(run.scene)] = text(run.scene)
    options = sorted(asdict(run.options).items(), key=lambda item: item[0])
    parts: tuple[object, ...] = (texts[id(run.scene)], run.seed, options)
    if run.training is not None:
        parts = (*parts, run.training)
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:32]


class OlderDigests:
    """Digests as earlier versions made them: of files as they were given, or of the scene's TOML.

    The latter take a hundred times as long as ours, so that each is made only when it is asked for.
    """

    def __init__(self) -> None:
        self._made: list[tuple[Text, Texts]] = [(msgspec.msgpack.encode, {}), (toml.dumps, {})]

    def have(self, run: SweepRun, known: str) -> bool:
        """Whether an earlier version had this digest of a run."""
        return any(known == digest(run, texts, text) for text, texts in self._made)


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
