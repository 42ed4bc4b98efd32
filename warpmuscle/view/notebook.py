"""Motions of Python's users as pages, in a notebook or to save."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Protocol, runtime_checkable

from warpmuscle.core.arguments import as_kind, as_whole
from warpmuscle.core.errors import ArgumentError
from warpmuscle.formats import SceneLike, scene_of
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import Result
from warpmuscle.results.sweeps import read
from warpmuscle.scene import Scene
from warpmuscle.view.page import Page, replay_html
from warpmuscle.view.sources import is_result, of_replays, of_scene, page_of_sights


@runtime_checkable
class HasResult(Protocol):
    """What holds a result, as a run does."""

    @property
    def result(self) -> Result:
        """All that was recorded, with its scene."""


def show(
    motion: Result | Recording | HasResult | Scene | str | PathLike[str],
    scene: SceneLike | None = None,
    replay: int | None = None,
    *,
    meshes: str | PathLike[str] | None = None,
) -> Page:
    """Recorded motion as a page that a notebook shows and `save` writes.

    Args:
        motion: a result or its file, all of whose motions are shown side by side; a run; one recording; or a scene, its
            name or its file, which is simulated once.
        scene: that made the recording, or its name or file; free parameters count with their start values. A result
            knows its own, and so does a recording that a rollout has just made.
        replay: the number of one motion of a result.
        meshes: folder with the files (.vtp, .stl, .obj) that a model of OpenSim is drawn with.

    Raises:
        ResultError: there is no such motion.
        Error: a recording has no frames, or they are of another character; the folder has no files of the model.
        ArgumentError: a recording without its scene, or a result with one; or a wrong type.
    """
    if isinstance(motion, Recording):
        if scene is None and motion.origin is not None:
            scene = motion.origin()
        if scene is None:
            raise ArgumentError("a recording of a file needs the scene that made it: show(recording, scene)")
        if replay is not None:
            raise ArgumentError("motion is a recording, one motion; replay chooses one of a result")
        return Page(replay_html(motion, scene_of(scene), meshes=meshes))
    if isinstance(motion, HasResult):
        motion = motion.result
    if isinstance(motion, str | PathLike) and is_result(str(motion)):
        motion = as_kind(Result, read(Path(motion), replay=replay), "motion")
    if isinstance(motion, str | PathLike | Scene):
        if scene is not None or replay is not None:
            raise ArgumentError("motion is a scene, which is simulated as it is: show(scene)")
        return page_of_sights(of_scene(scene_of(motion, "motion")), meshes=meshes)
    result = as_kind(Result, motion, "motion")
    if scene is not None:
        raise ArgumentError("motion is a result and has its scene with it: show(result)")
    if replay is not None:
        replay = as_whole(replay, "replay", 0)
    return page_of_sights(of_replays(result, replay=replay), meshes=meshes)
