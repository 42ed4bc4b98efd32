"""Motions of Python's users as pages, in a notebook or to save."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

from warpmuscle.core.arguments import answering, as_integer, as_kind, as_path, as_truth, in_words
from warpmuscle.core.errors import ArgumentError, Error
from warpmuscle.formats import SceneLike, scene_of
from warpmuscle.results.holders import HasRecordings, HasResult
from warpmuscle.results.partial_motion import demanding
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import Result
from warpmuscle.results.result import holds_trials
from warpmuscle.results.sweeps import read
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import at_start
from warpmuscle.view.page import Page
from warpmuscle.view.sources import Sight, is_result, of_replays, of_scene, page_of_sights, with_measured

ARGUMENTS = {
    **dict.fromkeys(("title", "name", "label"), "the page is called as its scene is"),
    **dict.fromkeys(("height", "size"), "a notebook takes page.height, px; see `Page`"),
    **dict.fromkeys(
        ("width", "camera", "speed", "loop"), "the page has the width of its window, and buttons for all else"
    ),
    **dict.fromkeys(("live", "port", "host"), "`warpmuscle view SCENE --live` runs one"),
    **dict.fromkeys(("save", "path", "output", "file"), "show(...).save('page.html') writes it"),
}  # by what is often tried
Shown = Result | Recording | HasResult | HasRecordings | Scene | str | PathLike[str]


@answering(ARGUMENTS)
def show(
    motion: Shown | list[Any] | tuple[Any, ...],
    scene: SceneLike | None = None,
    replay: int | None = None,
    *,
    meshes: str | PathLike[str] | None = None,
    over: bool = False,
) -> Page:
    """Show recorded motion as a page in a notebook, or `save` it.

    Args:
        motion: a result or its file, all of whose motions are shown side by side; a run; one recording; a rollout that
            has recorded some instances; a scene, its name or its file, which is simulated once; or a list of these.
        scene: that made the recording, or its name or file; free parameters count with their start values. A result
            knows its own, and so does a recording that a rollout has just made.
        replay: the number of one motion of a result.
        meshes: folder with the files (.vtp, .stl, .obj) that a model of OpenSim is drawn with.
        over: whether several motions are shown over one another, rather than side by side.

    Raises:
        ResultError: there is no such motion.
        Error: a recording has no frames, or they are of another character; the folder has no files of the model.
        ArgumentError: a recording without its scene, or a result with one; or a wrong type.
    """
    listed: list[Any] = list(motion) if isinstance(motion, list | tuple) else [motion]
    if not listed:
        raise ArgumentError("motion must be a result, a run, a recording, a scene or a list, not an empty one")
    over = as_truth(over, "over")
    folder = None if meshes is None else as_path(meshes, "meshes")
    sights: list[Sight] = []
    for number, one in enumerate(listed, 1):
        try:
            sights += _sights_of(one, scene, replay)
        except Error as error:
            if isinstance(motion, list | tuple):
                raise ArgumentError(f"motion {number} of the list: {error}") from None
            raise
    return page_of_sights(sights, meshes=folder, over=over)


def _second(given: object) -> str:
    """What is said where something is given with a result, which has its scene with it."""
    if isinstance(given, str | PathLike) and str(given).lower().endswith((".html", ".htm")):
        return f"a page is written by its save: show(result).save({str(given)!r})"
    if isinstance(given, Result | Recording | HasResult | HasRecordings):
        return "several motions are given as a list: show([a, b])"
    return "motion is a result and has its scene with it: show(result)"


def _sights_of(motion: Shown, scene: SceneLike | None, replay: int | None) -> list[Sight]:
    """The motions of one of them; see `show`."""
    if isinstance(motion, Recording):
        if scene is None and motion.origin is not None:
            scene = motion.origin()
        if scene is None:
            raise ArgumentError("a recording of a file needs the scene that made it: show(recording, scene)")
        if replay is not None:
            raise ArgumentError("motion is a recording, one motion; replay chooses one of a result")
        own = scene_of(scene)
        return [Sight(own.name, demanding(motion, "this recording"), at_start(own))]
    if replay is not None:
        replay = as_integer(replay, "replay", 0)
    if isinstance(motion, HasRecordings):
        if not motion.recorded_instances:
            raise ArgumentError("this rollout has recorded nothing to show: name instances in Rollout(..., record=[0])")
        return [sight for one in motion.recorded_instances for sight in _sights_of(motion.recording(one), scene, None)]
    if isinstance(motion, HasResult):
        motion = motion.result
    file = Path(motion) if isinstance(motion, str | PathLike) and is_result(str(motion)) else None
    if isinstance(motion, str | PathLike | Scene) and file is None:
        if scene is not None or replay is not None:
            raise ArgumentError("motion is a scene, which is simulated as it is: show(scene)")
        return of_scene(scene_of(motion, "motion"))
    if not isinstance(motion, Result) and file is None:
        raise ArgumentError(
            f"motion must be a run, a result or its file, a recording, or a scene or its name, not {in_words(motion)}"
        )
    result = as_kind(Result, motion if file is None else read(file, replay=replay), "motion")
    if scene is not None:
        raise ArgumentError(_second(scene))
    sights = of_replays(result, replay=replay)
    return with_measured(sights, file, result, replay) if file is not None and holds_trials(file) else sights
