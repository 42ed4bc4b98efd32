"""A patient's strides from recordings, and the model that was recorded."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, SceneError
from warpmuscle.core.plain_text import readable
from warpmuscle.gait.cycles import Strides, body_weight, leg_angles, over_strides, strides
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.gait.measures import feet_of
from warpmuscle.gait.relative_to_belts import over_belts
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.files import read_coordinates
from warpmuscle.inverse.kinematics import inverse_kinematics
from warpmuscle.inverse.loads import read_loads
from warpmuscle.inverse.recordings.belt import loaded_velocity
from warpmuscle.inverse.recordings.motion import scene_with_feet
from warpmuscle.inverse.steps import frames_of, run_steps
from warpmuscle.optimization.best_scene import recorded_scene
from warpmuscle.results.recording import Recording
from warpmuscle.results.result import read as read_result
from warpmuscle.scene import Scene
from warpmuscle.sweep.patient import file as patient_file
from warpmuscle.sweep.patient.file import PatientFile
from warpmuscle.sweep.patient.gait import ANGLES, Gait, gait_of, pooled

HIP = ANGLES[0]
MARKERS = (".trc", ".c3d")
TRAVEL = 0.5  # m that a body goes over the ground
CLOSE = 0.02  # of a stride: what is missing at its ends


@dataclass(frozen=True)
class Patient:
    """What is known of a patient."""

    gait: Gait
    scene: Scene  # the model that was recorded, without free parameters
    pooled: Mapping[str, Mapping[str, Floats]]  # mean angles (101,), deg, of both sides over the cycle of the left foot
    spread: Mapping[str, Mapping[str, Floats]]  # standard deviations (101,), deg, by angle and side
    least_spread: float  # deg, that each of these is at least
    hip_offset: float = 0.0  # deg, that has been added to the recorded hip angles

    def strides(self, side: str) -> int:
        """How many strides of a side there are."""
        return len(self.gait.stride_time[side])

    def with_hips(self, offset: float) -> Patient:
        """The patient, whose hips are flexed by so much more, deg: the same thighs below a pelvis of other axes."""
        hips = {side: rows + offset for side, rows in self.gait.curves[HIP].items()}
        gait = replace(self.gait, curves={**self.gait.curves, HIP: hips})
        mean = {**self.pooled, HIP: {side: row + offset for side, row in self.pooled[HIP].items()}}
        return replace(self, gait=gait, pooled=mean, hip_offset=self.hip_offset + offset)


def read_patient(asked: PatientFile, device: str | None = None) -> Patient:
    """The strides of all recordings.

    Raises:
        Error: one cannot be read, has no whole stride of a foot, or does not tell a speed; with file, line and key.
    """
    gaits: list[Gait] = []
    over_left: list[dict[str, dict[str, Floats]]] = []
    scene: Scene | None = None
    for index, one in enumerate(asked.asked.recording):
        key = f"recording.{index}"
        try:
            for motion, model in _motions(asked, one, device):
                scene = scene or model
                cycles = _cycles(motion, model, one)
                speed = asked.asked.speed or _speed(motion, model, cycles)
                gaits.append(gait_of(motion, model, cycles, speed))
                over_left.append(_over_left(motion, model, cycles["left"]))
        except SceneError as error:
            raise error if error.file is not None and error.line else asked.error(str(error), f"{key}.motion") from None
        except Error as error:
            raise asked.error(str(error), f"{key}.motion") from None
    assert scene is not None
    gait, least = pooled(gaits), asked.asked.least_spread
    mean = {
        name: {side: np.concatenate([one[name][side] for one in over_left]).mean(axis=0) for side in SIDES}
        for name in ANGLES
    }
    spread = {name: {side: _spread(gait.curves[name][side], least) for side in SIDES} for name in ANGLES}
    return Patient(gait, scene, mean, spread, least)


def _spread(rows: Floats, least: float) -> Floats:
    """Standard deviation (101,) of strides (S, 101), but at least as much."""
    found = rows.std(axis=0, ddof=1) if len(rows) > 1 else np.zeros(rows.shape[1])
    return np.maximum(found, least)


def _motions(asked: PatientFile, one: patient_file.Recording, device: str | None) -> list[tuple[Recording, Scene]]:
    """Motions of a recording, each with its numeric scene."""
    path = asked.beside(one.motion)
    if not one.model:
        result = read_result(path)
        if not result.replays:
            raise Error(f"{path}: holds no motion; `warpmuscle inverse -o` and `simulate -o` write such files")
        scene = scene_with_feet(recorded_scene(result))
        return [(motion, scene) for motion in result.replays]
    body = BodyModel(str(asked.beside(one.model)), device)
    if path.suffix.lower() in MARKERS:
        coordinates = inverse_kinematics(body.scene, path, device=device).coordinates
    else:
        coordinates = read_coordinates(path, body.scene)
    loads = read_loads(asked.beside(one.loads)) if one.loads else None
    times = [frames_of(coordinates, -np.inf, np.inf, 1)]
    if loads is not None:
        inside = (times[0] >= loads.times[0]) & (times[0] <= loads.times[-1])
        times = [times[0][inside]]
    name = readable(Path(one.motion).stem)
    trial = run_steps(body, ("id",), [name], [coordinates], [loads], filter=one.filter, times=times, recorded=True)[0]
    assert trial.recording is not None
    return [(trial.recording, scene_with_feet(body.scene))]


def _cycles(motion: Recording, scene: Scene, one: patient_file.Recording) -> dict[str, Strides]:
    """Strides of both sides, by the events that are told, or else by the forces on the feet."""
    feet_of(scene)
    found: dict[str, Strides] = {}
    for side in SIDES:
        if one.events:
            begin, end = float(motion.time[0]), float(motion.time[-1])
            pairs = list(itertools.pairwise(one.events[side]))
            slack = {pair: CLOSE * (pair[1] - pair[0]) for pair in pairs}
            pairs = [p for p in pairs if p[0] >= max(begin, one.begin) - slack[p] and p[1] <= end + slack[p]]
        else:
            pairs = strides(motion, side, one.begin, body_weight(scene))
        if not pairs:
            how = "its events leave none" if one.events else "the force on it tells none; give `events`"
            raise Error(f"has no whole stride of the {side} foot: {how}")
        found[side] = pairs
    return found


def _speed(motion: Recording, scene: Scene, cycles: Mapping[str, Strides]) -> float:
    """Speed over the ground, m/s, on a treadmill over its belt, from the first touch-down to the last.

    A motion that does not tell its belt, as older files do not, has the one that its feet stand on.
    """
    begin = min(own[0][0] for own in cycles.values())
    end = max(own[-1][1] for own in cycles.values())
    given, motion = motion, over_belts(motion, scene)
    part = (motion.time >= begin) & (motion.time <= end)
    time, place = motion.time[part], motion.com[part, 2].astype(float)
    gone = float(np.interp(end, time, place) - np.interp(begin, time, place))
    if motion is not given:
        return gone / (end - begin)
    force = np.stack([motion[f"foot_force_{side}"][part, 1].astype(float) for side in SIDES], axis=1)
    if force.max() <= 0.0:
        if abs(gone) < TRAVEL:
            raise Error("does not tell how fast the patient walks on a belt: give `speed`")
        return gone / (end - begin)
    feet = [motion.body_names.index(foot) for foot in feet_of(scene)]
    moving = np.gradient(motion.body_position[part][:, feet].astype(float), time, axis=0)
    return gone / (end - begin) - float(loaded_velocity(moving, np.maximum(force, 0.0))[2])


def _over_left(motion: Recording, scene: Scene, cycles: Strides) -> dict[str, dict[str, Floats]]:
    """Angles (S, 101), deg, of both legs over the strides of the left foot."""
    angles = leg_angles(motion, scene)
    return {
        name: {side: over_strides(motion.time, sides[side], cycles) for side in SIDES} for name, sides in angles.items()
    }
