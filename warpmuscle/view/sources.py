"""What there is to see in result files and scenes, as motions with the scenes that made them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, ResultError
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.status import Status
from warpmuscle.inverse.recordings.measured import Measured, read_measured
from warpmuscle.optimization.best_scene import scene_in
from warpmuscle.results.partial_motion import demanding
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import Result
from warpmuscle.results.result import holds_trials, read
from warpmuscle.scene import Failure, Scene
from warpmuscle.scene.ground import plane
from warpmuscle.scene.initial_pose import plain_number
from warpmuscle.scene.parameters import at_start, start_values, substitute
from warpmuscle.view.bones.model_meshes import mesh_folder
from warpmuscle.view.crowd import Facts
from warpmuscle.view.lanes import MOST
from warpmuscle.view.packing import as_small
from warpmuscle.view.page import CROWD, Page, page_of
from warpmuscle.view.track import Track, track_of

NOTHING_KNOWN = Facts()
SUFFIXES = (".h5", ".hdf5")
RATE = 50.0  # frames a second that are shown
FEW = 8  # motions; of more of them half the frames are shown
EARLY, SAME_HEIGHT = 0.05, 0.02  # s before its end, of a motion that stopped; and of a height, that frames lie apart
NAMED = 3  # scenes, in the title of a page
MOST_FRAMES = 10_000  # of all motions of a crowd together, some 900 kB of a page


@dataclass(frozen=True)
class Sight:
    """A motion to look at."""

    label: str
    recording: Recording
    scene: Scene  # that made it, without free parameters
    facts: Facts = NOTHING_KNOWN
    measured: Measured | None = None


def is_result(path: str) -> bool:
    """Whether a source is a result file rather than a scene: by its name, or by its first bytes."""
    if Path(path).suffix.lower() in SUFFIXES:
        return True
    try:
        with open(path, "rb") as file:
            return file.read(8) == b"\x89HDF\r\n\x1a\n"
    except (OSError, ValueError):  # such as of a name with a null in it
        return False


def of_results(
    paths: Sequence[str],
    replay: int | None = None,
    candidates: int | None = None,
    run: str | None = None,
    device: str | None = None,
) -> list[Sight]:
    """The motions of result files.

    Args:
        replay: only this one of each file. candidates: in their place so many of the best candidates, which are run
            again on a device.
        run: which one of a sweep's file.

    Raises:
        ResultError: a file cannot be read, or holds no such motion.
    """
    sights = []
    for path in paths:
        result = read(path, run, replay=replay)
        name = Path(path).stem if len(paths) > 1 else ""
        if candidates is not None:
            sights += of_candidates(result, candidates, device, path, name)
        else:
            own = of_replays(result, path, name, replay)
            sights += with_measured(own, path, result, replay) if holds_trials(path) else own
    return sights


def of_replays(
    result: Result, path: str | Path = "the result", name: str = "", replay: int | None = None
) -> list[Sight]:
    """The recorded motions of a result, or one of them; raises ResultError if there is none."""
    if not result.replays:
        hint = "; --candidates N runs the N best again" if result.best is not None else ""
        raise ResultError(f"{path}: holds no motion to show{hint}")
    if replay is not None and replay >= len(result.replays):
        raise ResultError(f"{path} has {number_of(len(result.replays), 'motion')}, none with number {replay}")
    scene = scene_in(result)
    values = start_values(scene) if result.best is None else np.asarray(result.best.params, dtype=np.float64)
    numeric = substitute(scene, values)
    chosen = range(len(result.replays)) if replay is None else [replay]
    labels = {number: f"{scene.name} {number}" if len(result.replays) > 1 else scene.name for number in chosen}
    if len(result.replay_names) > 1:
        labels = {number: result.replay_names[number] for number in chosen}
    motions = {number: demanding(result.replays[number], str(path)) for number in chosen}
    searched = result.evaluations is not None
    facts = {n: NOTHING_KNOWN if searched else fall_of(motions[n], numeric) for n in chosen}
    return [Sight(name or labels[n], motions[n], numeric, facts[n]) for n in chosen]


def fall_of(recording: Recording, scene: Scene) -> Facts:
    """That a motion ended before its time with its centre of mass as low as who has fallen, and when.

    Args:
        scene: that made it, without free parameters.
    """
    if not recording.frames:
        return NOTHING_KNOWN
    end, limit = float(recording.time[-1]), plain_number(scene.failure.com_height)
    normal, height = plane(scene.ground)
    above = recording.com[[0, -1]] @ normal - height
    if end > scene.duration - EARLY or above[1] > (limit + SAME_HEIGHT) * above[0]:
        return NOTHING_KNOWN
    return _ended(Status.FELL, end)


def _ended(how: Status, end: float) -> Facts:
    """That a motion ended in some way, and when, s."""
    return Facts(None, f"{how.word} at {end:.1f} s", end)


def with_measured(sights: Sequence[Sight], path: str | Path, result: Result, replay: int | None = None) -> list[Sight]:
    """Motions of a file of `warpmuscle inverse`, or one of them, with the markers and forces that were measured."""
    names = result.replay_names or ("",)
    chosen = names if replay is None else names[replay : replay + 1]
    measured = [read_measured(path, name) for name in chosen]
    known = NOTHING_KNOWN  # a scene says nothing of when a recorded motion ends
    return [replace(sight, measured=one, facts=known) for sight, one in zip(sights, measured, strict=True)]


def of_candidates(result: Result, count: int, device: str | None, path: str | Path, name: str = "") -> list[Sight]:
    """So many of the best candidates of an optimisation, run again."""
    if result.evaluations is None or len(result.evaluations) == 0:
        raise ResultError(f"{path}: holds no candidates to run again")
    scene, evaluations = scene_in(result), result.evaluations
    last = evaluations.stage == evaluations.stage.max()
    order = [int(row) for row in np.argsort(evaluations.cost, kind="stable") if last[row]]
    rows: list[int] = []
    for row in order:
        if not any(np.array_equal(evaluations.params[row], evaluations.params[other]) for other in rows):
            rows.append(row)
        if len(rows) == count:
            break
    values = np.asarray(evaluations.params[rows], dtype=np.float64)
    motions, facts = _walked(scene, values, device)
    labels = [f"{name} candidate {row}, cost {evaluations.cost[row]:.4g}".strip() for row in rows]
    return [
        Sight(label, motion, substitute(scene, own), known._replace(cost=float(evaluations.cost[row])))
        for label, motion, own, known, row in zip(labels, motions, values, facts, rows, strict=True)
    ]


def _walked(scene: Scene, values: Floats, device: str | None) -> tuple[list[Recording], list[Facts]]:
    """Motions of a scene with rows of values, those that fail until they lie on the ground; and which these are."""
    from warpmuscle.simulation.rollout import Rollout

    def run(one: Scene, rows: Floats) -> Rollout:
        rollout = Rollout(one, len(rows), device, record=range(len(rows)), record_rate=RATE)
        if rows.shape[1]:
            rollout.set_parameters(rows)
        rollout.run()
        return rollout

    first = run(scene, values)
    motions = [first.recording(number) for number in range(len(values))]
    ends, words = first.end_time(), [Status(number) for number in first.status()]
    failed = [number for number, word in enumerate(words) if word != Status.COMPLETED]
    facts = [Facts()] * len(values)
    if failed:
        on = msgspec.structs.replace(scene, failure=Failure(com_height=0.0, heading=0.0))
        falls = run(on, values[failed])
        for place, number in enumerate(failed):
            motion = falls.recording(place)
            motions[number] = motion if motion.frames > motions[number].frames else motions[number]
            facts[number] = _ended(words[number], float(ends[number]))
    return motions, facts


def of_scene(scene: Scene, device: str | None = None) -> list[Sight]:
    """A scene, run once; where it fails, until it lies on the ground."""
    (motion,), (facts,) = _walked(scene, start_values(scene)[None], device)
    return [Sight(scene.name, motion, at_start(scene), facts)]


def tracks_of(sights: Sequence[Sight], rate: float | None = None) -> list[Track]:
    """What is drawn of motions; equal scenes share what does not move. Raises Error for more than 64 of them.

    Args:
        rate: frames a second, by default as many as are worth seeing of so many motions.
    """
    if len(sights) > MOST:
        raise Error(
            f"{number_of(len(sights), 'motion')} are more than can be seen at once: {MOST}; --replay chooses one "
            "of a file"
        )
    rate = rate or _usual_rate(sights)
    tracks: list[Track] = []
    for number, sight in enumerate(sights):
        same = next((k for k in range(number) if sights[k].scene is sight.scene), None)
        doll = tracks[same].doll if same is not None else None
        tracks.append(track_of(sight.recording, sight.scene, sight.label, rate, doll, sight.measured))
    return tracks


def _usual_rate(sights: Sequence[Sight]) -> float:
    """Frames a second of so many motions."""
    rate = RATE if len(sights) <= FEW else RATE / 2.0
    seconds = sum(float(sight.recording.time[-1]) for sight in sights if sight.recording.frames)
    return min(rate, MOST_FRAMES / seconds) if len(sights) > CROWD and seconds > 0.0 else rate


def page_of_sights(
    sights: Sequence[Sight],
    title: str = "",
    meshes: str | PathLike[str] | None = None,
    beside: Path | None = None,
    over: bool = False,
) -> Page:
    """A page of motions, by default called as the first one's scene; it has fewer frames where it would be too large.

    Args:
        over: whether they are shown over one another, rather than side by side.
        meshes: folder with the files of triangles that models of OpenSim are drawn with. beside: one that is looked at
            unasked.

    Motions without frames, such as that of a candidate which diverged at once, are left out beside others.

    Raises:
        Error: there are too many motions, or none with frames; the folder has no such files.
    """
    sights = [sight for sight in sights if sight.recording.frames] or sights
    scenes = [sight.scene for sight in sights]
    folder = mesh_folder(meshes, scenes[0], beside)
    names = list(dict.fromkeys(scene.name for scene in scenes))
    several = ", ".join(names) if len(names) <= NAMED else f"{', '.join(names[:NAMED])}, ..."
    name, facts = title or several, [sight.facts for sight in sights]

    def at(rate: float) -> str:
        return page_of(
            tracks_of(sights, rate), scenes, name, autoplay=True, plots=True, meshes=folder, over=over, facts=facts
        )

    return Page(as_small(at, _usual_rate(sights)))
