"""The two sweeps of a patient's path: walks that match the recording, and walks that go on from them with a change."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, SceneError
from warpmuscle.core.files import replace_file
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.pose import about, twist_angle
from warpmuscle.formats import load, toml
from warpmuscle.formats.overrides import Override, overridden
from warpmuscle.formats.toml_layout import inline
from warpmuscle.gait.cycles import PERCENT
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.gait.pelvis_and_trunk import segments
from warpmuscle.kernels.objective.objective_terms import TERMS
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import leg_joints
from warpmuscle.scene.initial_pose import world_poses
from warpmuscle.scene.norms import FLEXION
from warpmuscle.scene.parameters import at_start
from warpmuscle.sweep.patient.body import changes_to_size, trunk_is_pelvis
from warpmuscle.sweep.patient.file import UNCHANGED, Adapt, Match, PatientFile
from warpmuscle.sweep.patient.freedom import feed_forward, within_reach
from warpmuscle.sweep.patient.gait import ANGLES
from warpmuscle.sweep.patient.recorded import Patient
from warpmuscle.sweep.plan import Plan, read

X = np.array([1.0, 0.0, 0.0])
AXIS = "run"  # of a sweep, that tells its list of runs apart
SEARCH = ("strategy", "candidates", "population", "sigma", "until")
KEEP = 'keep = "best"'  # of the candidates of each search


@dataclass(frozen=True)
class Files:
    """Where a patient's path keeps what it finds: a folder beside the page."""

    page: Path

    @property
    def folder(self) -> Path:
        return self.page.with_suffix(".patient")

    def of(self, name: str) -> Path:
        return self.folder / name

    @property
    def table(self) -> Path:
        return self.page.with_suffix(".csv")


def walk_plan(asked: PatientFile, patient: Patient, files: Files) -> Plan:
    """The sweep of one search for any walk at the patient's speed, by the scene's own objective; its file is written.

    Raises:
        Error: as of `match_plan`.
    """
    scene, match = _scene_of(asked), asked.asked.match
    numeric = at_start(scene)
    speed = first_number(numeric.objective.speed) or match.speed
    changes = _sizes(asked, numeric, patient) | {
        "duration": match.duration, "objective.target_speed": patient.gait.speed, "objective.speed": speed,
    }  # fmt: skip
    lines = [f"scene = {json.dumps(_named(asked))}", f"name = {json.dumps(f'{asked.name}, walk')}"]
    lines += [*_search(match), *_set(changes | match.set), "", "[grid]", "seed = [1]"]
    if match.walk is not None:
        lines[lines.index(f"candidates = {match.candidates}")] = f"candidates = {match.walk}"
    return _read(asked, files.of("walk.toml"), lines, "match", changes)


def match_plan(asked: PatientFile, patient: Patient, files: Files, first: Scene | None = None) -> Plan:
    """The sweep of searches for walks like the patient's, a run a seed; its files are written.

    Args:
        first: a scene of the patient's size that the searches begin from, in place of that of the file.

    Raises:
        Error: the scene cannot be used, has no legs, or a change of it cannot be made; with the key of the file.
    """
    scene = _scene_of(asked)
    numeric = at_start(scene)
    match, named = asked.asked.match, _named(asked)
    try:
        gait = _write_gait(files.folder, numeric, patient)
    except Error as error:
        raise asked.error(str(error), "scene") from None
    sizes = _sizes(asked, numeric, patient) if first is None else {}
    if first is not None:
        named = "walked.toml"
        toml.write(first, files.of(named))
    changes = sizes | {
        "duration": match.duration,
        "tracking": _tracking(gait, numeric, patient),
        "objective.tracking": 1.0 / match.duration,
        "objective.target_speed": patient.gait.speed,
        "objective.speed": match.speed,
    }
    own = {f"objective.{name}": 0.0 for name in _weights(numeric)}
    changes = own | changes | _freedom(asked, first or scene, patient)
    lines = [f"scene = {json.dumps(named)}", f"name = {json.dumps(f'{asked.name}, match')}", KEEP]
    lines += [*_search(match), *_set(changes | match.set)]
    lines += ["", "[grid]", f"seed = {list(range(1, asked.asked.seeds + 1))}"]
    plan = _read(asked, files.of("match.toml"), lines, "match", changes)
    check_changes(asked, plan.runs[0].scene)
    return plan


def _sizes(asked: PatientFile, numeric: Scene, patient: Patient) -> dict[str, Any]:
    """Changes that give the walker the patient's size; raises SceneError with the file's key."""
    try:
        return changes_to_size(numeric, patient.scene) if asked.asked.scaled else {}
    except Error as error:
        raise asked.error(str(error), "scene") from None


def _freedom(asked: PatientFile, scene: Scene, patient: Patient) -> dict[str, Any]:
    """What else the search may change in the scene that it begins from, and narrower intervals of its free numbers."""
    match = asked.asked.match
    found: dict[str, Any] = {}
    if match.reach is not None:
        found |= within_reach(scene, match.reach)
    if match.feed_forward is not None:
        try:
            found |= feed_forward(scene, match.feed_forward, float(patient.gait.stride_time["left"].mean()))
        except Error as error:
            raise asked.error(str(error), "match.feed_forward") from None
    return found


def hip_offset(asked: PatientFile, patient: Patient, walker: Scene, tilt: float | None) -> float:
    """How much more, deg, hips of a numeric scene are flexed than the patient's if their thighs stand alike.

    Unless the file tells it, pelves count as having the same axes, but where the trunk of the scene is one with its
    pelvis and that of the recorded model is not. There the pelvis of the scene leans as its trunk does, and hips
    differ by what the pelves' mean tilts do.

    Args:
        tilt: mean tilt of the scene's pelvis forwards, deg; None if it does not walk.
    """
    if asked.asked.hip_offset is not None:
        return asked.asked.hip_offset
    if not trunk_is_pelvis(walker) or trunk_is_pelvis(patient.scene):
        return 0.0
    return (start_tilt(walker) if tilt is None else tilt) - patient.gait.tilt


def start_tilt(scene: Scene) -> float:
    """Tilt of the pelvis of a numeric scene forwards at the start, deg."""
    _, turned = world_poses(scene)[segments(scene)["Pelvis"]]
    return float(np.degrees(twist_angle(np.asarray(turned)[None], (1.0, 0.0, 0.0))[0]))


def check_changes(asked: PatientFile, scene: Scene) -> None:
    """Raise SceneError, before anything is searched for, if a change cannot be made; with its key."""
    for index, change in enumerate(asked.changes.values()):
        try:
            overridden(scene, [Override(key, value) for key, value in (asked.asked.adapt.set | change).items()])
        except SceneError as error:
            if error.key in asked.asked.adapt.set:
                raise asked.error(error.message, f"adapt.set.{error.key}") from None
            key = f"change.{index}.{error.key}" if error.key in change else f"change.{index}"
            raise asked.error(error.message, key) from None


def adapt_plan(asked: PatientFile, matched: Mapping[int, Scene], files: Files) -> Plan:
    """The sweep of searches that go on from matched walks, by seed, with each change and without one.

    Raises:
        Error: a change cannot be made; with its key in the patient's file.
    """
    adapt, duration, scene = asked.asked.adapt, asked.asked.match.duration, _scene_of(asked)
    own = _weights(at_start(scene))
    changes = {"objective.speed": asked.asked.match.speed} | {f"objective.{name}": own[name] for name in own}
    changes["objective.tracking"] = adapt.habit / duration
    lines = [f"name = {json.dumps(f'{asked.name}, changes')}", KEEP]
    lines += _search(adapt) + _set(changes | adapt.set)
    for seed, scene in matched.items():
        toml.write(_beside(scene, files), files.of(f"matched_{seed}.toml"))
        lines += ["", "[[grid]]", f"seed = [{seed}]", f'scene = ["matched_{seed}.toml"]']
    for name, change in {UNCHANGED: {}, **asked.changes}.items():
        lines += ["", "[[run]]", f"name = {json.dumps(name)}"]
        lines += [f"{_key(key)} = {inline(value)}" for key, value in change.items()]
    plan = _read(asked, files.of("changes.toml"), lines, "adapt", changes)
    runs = tuple(replace(run, axes={AXIS: run.axes[AXIS], "seed": float(run.seed)}) for run in plan.runs)
    return replace(plan, runs=runs)


def _beside(scene: Scene, files: Files) -> Scene:
    """The scene with the patient's stride where it lies now; a search names it from the folder where it began."""
    if scene.tracking is None:
        return scene
    stride = files.folder / Path(scene.tracking.file).name
    return msgspec.structs.replace(scene, tracking=msgspec.structs.replace(scene.tracking, file=str(stride)))


def _weights(scene: Scene) -> dict[str, float]:
    """Weights of the terms that the objective of a numeric scene has."""
    weights = {name: first_number(getattr(scene.objective, name)) for name in TERMS}
    return {name: weight for name, weight in weights.items() if weight != 0.0}


def _scene_of(asked: PatientFile) -> Scene:
    """The scene that walks."""
    try:
        return load(_named(asked))
    except SceneError as error:
        if error.file is not None and error.line:
            raise
        raise asked.error(str(error), "scene") from None


def _named(asked: PatientFile) -> str:
    """The scene's name, or its file's whole path."""
    name = asked.asked.scene
    return str(asked.beside(name).absolute()) if Path(name).suffix else name


def _read(asked: PatientFile, file: Path, lines: list[str], table: str, own: Mapping[str, Any]) -> Plan:
    """Write a sweep's file and read it; what is wrong in it is told by the patient's file where it stands there."""
    replace_file(file, "\n".join(lines) + "\n")
    try:
        return read(file)
    except SceneError as error:
        raise _placed(asked, error, file, table, own) from None


def _placed(asked: PatientFile, error: SceneError, file: Path, table: str, own: Mapping[str, Any]) -> SceneError:
    """An error of a sweep's file at the place of the patient's file that it comes from."""
    if error.key.startswith("search"):
        option = next((f".{name}" for name in SEARCH if name in error.message.split()), "")
        return asked.error(error.message, f"{table}{error.key.removeprefix('search') or option}")
    for index, change in enumerate(asked.asked.change):
        if error.key in change:
            return asked.error(error.message, f"change.{index}.{error.key}")
    named = error.key.removeprefix("set.")
    if named in getattr(asked.asked, table).set:
        return asked.error(error.message, f"{table}.set.{named}")
    if named in own:
        return asked.error(f"{named}: {error.message}", "scene")
    return asked.error(error.message if Path(error.file or "") == file else str(error), "scene")


def _search(options: Match | Adapt) -> list[str]:
    """The options of the searches."""
    given = {name: value for name, value in msgspec.structs.asdict(options).items() if name in SEARCH}
    return ["", "[search]", *(f"{name} = {inline(value)}" for name, value in given.items() if value is not None)]


def _set(changes: Mapping[str, Any]) -> list[str]:
    return ["", "[set]", *(f"{_key(key)} = {inline(value)}" for key, value in changes.items())]


def _key(key: str) -> str:
    return json.dumps(key)


def _tracking(file: Path, scene: Scene, patient: Patient) -> dict[str, Any]:
    """The patient's mean stride as the gait that the objective tracks, in the patient's own spread.

    Squared angles count by the mean variance of their joint, so that the term is the mean square over joints of the
    distance in standard deviations. The file is named as from the current folder, so that a search that was interrupted
    finds it where all of it has been moved.
    """
    weights = {}
    for number, side in enumerate(SIDES):
        for name, joint in zip(ANGLES, leg_joints(scene, number), strict=True):
            spread = np.radians(patient.spread[name][side].mean())
            weights[joint] = round(float(1.0 / (2 * len(ANGLES) * spread**2)), 6)
    return {"file": str(file), "start": 0.0, "joints": list(weights), "weights": weights}


def _write_gait(folder: Path, scene: Scene, patient: Patient) -> Path:
    """The file of the patient's mean stride, as orientations of the scene's joints over the cycle of the left foot.

    Its name tells what is in it, so that searches for another stride are other searches.
    """
    period = np.array(patient.gait.stride_time["left"].mean())
    arrays: dict[str, Floats] = {"cycle": PERCENT[:-1] / 100.0, "period": period.round(6)}
    for number, side in enumerate(SIDES):
        joints = leg_joints(scene, number)
        if len(joints) < len(ANGLES):
            raise Error(f"{scene.name} has no hip, knee and ankle on its {side} side")
        for name, sign, joint in zip(ANGLES, FLEXION, joints, strict=True):
            arrays[joint] = about(X, np.radians(sign * patient.pooled[name][side][:-1])).round(6)
    digest = hashlib.sha256(b"".join(array.tobytes() for array in arrays.values())).hexdigest()
    content = io.BytesIO()
    np.savez(content, **arrays)  # type: ignore[arg-type]
    file = folder / f"gait-{digest[:8]}.npz"
    replace_file(file, content.getvalue())
    return file
