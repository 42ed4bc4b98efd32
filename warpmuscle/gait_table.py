"""A walk in numbers beside those of human walking, and beside another walk."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.errors import Error
from warpmuscle.gait import measure
from warpmuscle.norms import LEG_ANGLES, NORMS, REFERENCES, SOURCE
from warpmuscle.recording import Floats, Recording
from warpmuscle.scene import Scene
from warpmuscle.strides import (
    PERCENT,
    SIDES,
    body_weight,
    feet_of,
    leg_angles,
    over_strides,
    steady_strides,
)

TRANSPORT = "cost of transport"
_STANCE = PERCENT <= 60.0  # of the gait cycle, about


@dataclass(frozen=True)
class Row:
    """A measure of walks; None where a walk does not give it."""

    name: str
    unit: str
    values: tuple[float | None, ...]  # of each walk
    human: str  # of human walking, with unit where it differs; empty if unknown
    source: str  # of that


def gait_measures(recording: Recording, scene: Scene) -> dict[str, float | None]:
    """Measures of a walk by their names in `gait_table`.

    Args:
        scene: without free parameters.

    Raises:
        Error: no legs, or no whole gait cycle.
    """
    feet = feet_of(scene)
    cycles = steady_strides(recording, scene)
    gait = measure(recording, *feet)
    found: dict[str, float | None] = {
        "speed": gait.speed_forward,
        "step length": gait.step_length,
        "step width": gait.step_width,
        "cadence": gait.cadence,
    }
    curves: dict[str, Floats] = {}
    try:
        angles = leg_angles(recording, scene)
    except Error:
        angles = {}
    for name, sides in angles.items():
        means = [over_strides(recording.time, sides[side], cycles[side]).mean(axis=0) for side in SIDES]
        curves[name] = np.mean(means, axis=0)
    weight = body_weight(scene)
    forces = [over_strides(recording.time, recording[f"foot_force_{side}"][:, 1], cycles[side]) for side in SIDES]
    force = np.mean([part.mean(axis=0) for part in forces], axis=0) / weight
    found["greatest vertical force"] = float(force[_STANCE].max())
    for name in LEG_ANGLES if angles else ():
        joint = name.split()[0].lower()
        found[f"{joint}, least"], found[f"{joint}, greatest"] = float(curves[name].min()), float(curves[name].max())
    for name, curve in {**curves, "Vertical ground force": force}.items():
        norm = NORMS[name]
        inside = np.abs(curve - norm.mean(PERCENT)) <= norm.half_band
        found[f"{name.lower()} within the norm band"] = 100.0 * float(inside.mean())
    return found


def gait_table(walks: list[dict[str, float | None]]) -> list[Row]:
    """Rows of measures, in order, of one or several walks (see `gait_measures`) beside human walking."""
    names = dict.fromkeys(name for walk in walks for name in walk)
    return [Row(name, _unit(name), tuple(walk.get(name) for walk in walks), *_human(name)) for name in names]


def _unit(name: str) -> str:
    units = {"speed": "m/s", TRANSPORT: "J/(kg m)", "cadence": "steps/min", "greatest vertical force": "body weights"}
    if name.endswith("norm band"):
        return "% of the cycle"
    return units.get(name, "m" if name.startswith("step") else "deg")


def _human(name: str) -> tuple[str, str]:
    """What human walking has for a measure, and where it is known from."""
    if name in REFERENCES:
        known = REFERENCES[name]
        text = f"{known.low:g}" if known.low == known.high else f"{known.low:g} to {known.high:g}"
        return text, known.source
    joint, _, end = name.partition(", ")
    for title, norm in NORMS.items():
        values = [value for _, value in norm.points]
        if title.split()[0].lower() == joint and end:
            return f"{min(values) if end == 'least' else max(values):g} ± {norm.half_band:g}", SOURCE
        if name == "greatest vertical force" and title == "Vertical ground force":
            return f"{max(values):g} ± {norm.half_band:g}", SOURCE
    return ("100", SOURCE) if name.endswith("norm band") else ("", "")
