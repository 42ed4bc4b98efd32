"""Motions of Python's users as pages, in a notebook or to save."""

from __future__ import annotations

from os import PathLike

from warpmuscle.core.arguments import as_kind, as_whole
from warpmuscle.core.errors import ArgumentError
from warpmuscle.formats import SceneLike, scene_of
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import Result
from warpmuscle.view.page import Page, replay_html
from warpmuscle.view.sources import of_replays, page_of_sights


def show(
    motion: Result | Recording,
    scene: SceneLike | None = None,
    replay: int | None = None,
    *,
    meshes: str | PathLike[str] | None = None,
) -> Page:
    """Recorded motion as a page that a notebook shows and `save` writes.

    Args:
        motion: a result, all of whose motions are shown side by side; or one recording.
        scene: that made the recording, or its name or file; free parameters count with their start values. A result
            knows its own.
        replay: the number of one motion of a result.
        meshes: folder with the files (.vtp, .stl, .obj) that a model of OpenSim is drawn with.

    Raises:
        ResultError: there is no such motion.
        Error: a recording has no frames, or they are of another character; the folder has no files of the model.
        ArgumentError: a recording without its scene, or a result with one; or a wrong type.
    """
    if isinstance(motion, Recording):
        if scene is None:
            raise ArgumentError("a recording needs the scene that made it: show(recording, scene)")
        if replay is not None:
            raise ArgumentError("a recording is one motion; replay chooses one of a result")
        return Page(replay_html(motion, scene_of(scene), meshes=meshes))
    result = as_kind(Result, motion, "motion")
    if scene is not None:
        raise ArgumentError("a result has its scene with it: show(result)")
    if replay is not None:
        replay = as_whole(replay, "replay", 0)
    return page_of_sights(of_replays(result, replay=replay), meshes=meshes)
