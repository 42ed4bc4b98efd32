"""What walks of a sweep over conditions come to: metabolic power by several formulas, stride frequency, angles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from msgspec.structs import replace

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, ResultError
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.status import Status
from warpmuscle.gait.cycles import leg_angles, over_strides, steady_strides
from warpmuscle.gait.likeness import leg_length
from warpmuscle.gait.measures import measure
from warpmuscle.gait.muscle_effort import spent
from warpmuscle.optimization.best_scene import recorded_scene
from warpmuscle.results.recording import Recording
from warpmuscle.results.result import read as read_result
from warpmuscle.scene import Scene
from warpmuscle.scene.masses import body_mass

FORMULAS = {
    "Wang, positive work": ("wang", "positive"), "Wang, net work": ("wang", "net"),
    "Umberger, positive work": ("umberger", "positive"), "Umberger, net work": ("umberger", "net"),
    "Bhargava, positive work": ("bhargava", "positive"), "Bhargava, net work": ("bhargava", "net"),
    "Margaria, 25 and -120 % of work": ("margaria", "positive"),
}  # fmt: skip
TITLES = ("Hip flexion", "Knee flexion", "Ankle dorsiflexion")


@dataclass(frozen=True)
class Prediction:
    """A walk in numbers, dimensionless as in `records`."""

    power: dict[str, float]  # by formula
    frequency: float
    angles: tuple[Floats, ...] = ()  # hip, knee and ankle over the stride, degrees


def predicted(mass: float, file: Path) -> Prediction | str:
    """What the best walk of a run comes to, or why nothing is known of it.

    Args:
        mass: of the body without load, kg. file: the run's result.
    """
    try:
        result = read_result(file)
        best, evaluations = result.best, result.evaluations
        if best is None or evaluations is None or not result.replays:
            return "no candidate had ended"
        if Status(int(evaluations.status[best.index])) != Status.COMPLETED:
            return "fell"
        return prediction(result.replays[0], recorded_scene(result), mass)
    except (ResultError, Error) as error:
        return str(error)


def prediction(motion: Recording, scene: Scene, mass: float) -> Prediction:
    """A motion of a numeric scene in numbers; raises Error without legs or a whole gait cycle."""
    cycles = steady_strides(motion, scene)
    gait = measure(motion, scene)
    if gait.cadence is None:
        raise Error("no whole gait cycle")
    steady, gravity, leg = motion.window(gait.start), first_number(scene.gravity), leg_length(scene)
    unit = gravity**1.5 * math.sqrt(leg) * mass / body_mass(scene.character)
    power = {}
    for name, (model, work) in FORMULAS.items():
        objective = replace(scene.objective, metabolic_model=model, metabolic_work=work, basal_rate=None)
        found = spent(steady, replace(scene, objective=objective))
        if found is not None:
            power[name] = found.power / unit
    angles = leg_angles(motion, scene)
    curves = tuple(
        np.mean([over_strides(motion.time, angles[title][side], cycles[side]).mean(axis=0) for side in cycles], axis=0)
        for title in TITLES
        if title in angles
    )
    frequency = gait.cadence / 120.0 / math.sqrt(gravity / leg)
    return Prediction(power, frequency, curves if len(curves) == len(TITLES) else ())
