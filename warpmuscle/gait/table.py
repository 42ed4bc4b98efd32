"""A walk in numbers beside those of human walking, and beside other walks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.core.plain_text import rounded
from warpmuscle.gait.body_motion import CADENCE_AT_SPEED, FORCE_AT_SPEED
from warpmuscle.gait.device_work import POSITIVE, WORK
from warpmuscle.gait.device_work import UNIT as WORK_UNIT
from warpmuscle.gait.joint_moments import MOMENTS_AT
from warpmuscle.gait.muscle_effort import BHARGAVA_NET, BHARGAVA_STRICT
from warpmuscle.gait.quality import ACTIVE, AT, VARIABILITY, Measures
from warpmuscle.gait.swing import ARMS, CALF, CLEARANCE
from warpmuscle.scene.norms import FORCE, NORMS, REFERENCES, RUNNING, SOURCE
from warpmuscle.scene.people.pinzone import MOMENTS
from warpmuscle.scene.people.pinzone import SOURCE as PEOPLE

_CYCLE = "% of the cycle"
_BODY_WEIGHTS = "body weights"
_MOMENT = "N m/kg"
UNITS = {
    "speed": "m/s",
    "target speed": "m/s",
    "error of the speed": "m/s",
    "step length": "m",
    "step width": "m",
    "cadence": "steps/min",
    VARIABILITY: "mm",
    ACTIVE: "0 to 1",
    "stance": _CYCLE,
    "double support": _CYCLE,
    "flight": _CYCLE,
    "maximum vertical force": _BODY_WEIGHTS,
    "first hump of the force": _BODY_WEIGHTS,
    "valley of the force": _BODY_WEIGHTS,
    "second hump of the force": _BODY_WEIGHTS,
    "depth of the valley": _BODY_WEIGHTS,
    "hip moment in loading": _MOMENT,
    "knee moment in loading": _MOMENT,
    "knee moment before push-off": _MOMENT,
    "ankle moment, maximum": _MOMENT,
    "hip power, maximum": "W/kg",
    "knee power, maximum": "W/kg",
    "ankle power, maximum": "W/kg",
    "sway of the centre of mass": "cm",
    "bobbing of the centre of mass": "cm",
    "maximum braking force": _BODY_WEIGHTS,
    "maximum driving force": _BODY_WEIGHTS,
    FORCE_AT_SPEED: _BODY_WEIGHTS,
    CADENCE_AT_SPEED: "%",
    "travel of the centre of pressure": "% of the foot",
    CLEARANCE: "cm",
    ARMS: "deg",
    CALF: "%",
    "bodies inside each other": "cm",
    "time inside each other": "% of the time",
    "muscle mass": "kg",
    "metabolic power": "W/kg",
    "cost of transport": "J/(kg m)",
    "cost of transport at 0.25 MPa": "J/(kg m)",
    BHARGAVA_NET: "J/(kg m)",
    BHARGAVA_STRICT: "J/(kg m)",
    "share of passive force": "%",
    "mean activation": "0 to 1",
    "activation above 15 Hz": "% of the spectrum",
    "slide of the stance foot": "cm a step",
    "maximum slide of the stance foot": "cm a step",
    "drag of the trailing foot": "cm a step",
    "depth of the feet": "mm",
}
# Which point of which norm a measure is.
_POINTS = {
    "hip, minimum": ("Hip flexion", 1),
    "hip, maximum": ("Hip flexion", 2),
    "knee, maximum in stance": ("Knee flexion", 0),
    "knee, maximum in swing": ("Knee flexion", 2),
    "knee, minimum": ("Knee flexion", 3),
    "ankle, maximum in stance": ("Ankle dorsiflexion", 1),
    "ankle, minimum at push-off": ("Ankle dorsiflexion", 2),
    "first hump of the force": (FORCE, 1),
    "valley of the force": (FORCE, 2),
    "second hump of the force": (FORCE, 3),
    "maximum vertical force": (FORCE, 3),
}


DECIMALS = {
    "SD": 2, "m/s": 2, "m": 2, "steps/min": 0, "deg": 1, "half-widths": 2, "% of the cycle": 1, "body weights": 2,
    "N m/kg": 2, "cm": 1, "% of the time": 0, "correlation": 2,
    "W/kg": 1, "W": 0, "J/(kg m)": 1, "%": 0, "0 to 1": 3, "% of the spectrum": 1, "cm a step": 1, "mm": 1, "kg": 1,
    WORK_UNIT: 3, "% of the foot": 0, "% beyond chance": 0,
}  # fmt: skip
_RUNNING = {"stance": "40", "double support": "0", "flight": "20"}  # toe-off is at 40 % of the cycle


@dataclass(frozen=True)
class MeasureRow:
    """A measure of walks; None where a walk does not give it."""

    name: str
    unit: str
    values: tuple[float | None, ...]  # of each walk
    human: str  # of human walking, with unit where it differs; empty if unknown
    source: str  # of that

    @property
    def texts(self) -> tuple[str, ...]:
        """The values as they are shown, empty where there is none."""
        return tuple("" if value is None else _text(self.unit, value) for value in self.values)


def gait_table(walks: list[Measures], running: bool = False) -> list[MeasureRow]:
    """Rows of measures, in order, of one or several walks (see `gait_measures`) beside human walking, or running.

    A measure that no walk gives has no row.
    """
    names = dict.fromkeys(name for walk in walks for name, value in walk.items() if value is not None)
    return [
        MeasureRow(name, unit_of(name), tuple(walk.get(name) for walk in walks), *human(name, running))
        for name in names
    ]


def shown_rows(walks: list[Measures], running: bool = False) -> list[tuple[str, ...]]:
    """The same as texts: name, unit, people's, and each walk's; a value and the percent of the cycle are one text."""
    rows = []
    for row in gait_table(walks, running):
        if row.name.endswith((AT, "norm band")):
            continue
        known = row.human
        if (at := human(row.name + AT, running)[0]) and any(row.name + AT in walk for walk in walks):
            known += f" at {at} %"
        rows.append((row.name, row.unit, known, *(_cell(row.name, walk) for walk in walks)))
    return rows


def _cell(name: str, measures: Measures) -> str:
    """A value, and at what percent of the cycle it is."""
    value, at = measures.get(name), measures.get(name + AT)
    if value is None:
        return ""
    text = _text(unit_of(name), value)
    return text if at is None else f"{text} at {at:.0f} %"


def _text(unit: str, value: float) -> str:
    """A value with as many decimals as its unit is worth."""
    return rounded(value, DECIMALS[unit])


def unit_of(name: str) -> str:
    """Unit of a measure."""
    if name.startswith("deviation"):
        return "half-widths"
    if "outside the norms" in name or name.startswith("angles from") or name.endswith("from people"):
        return "SD"
    if name.startswith("likeness"):
        return "correlation"
    if name.startswith((WORK, POSITIVE)):
        return WORK_UNIT
    if name.startswith("timing of"):
        return "% beyond chance"
    return _CYCLE if name.endswith(("norm band", AT)) else UNITS.get(name, "deg")


def human(name: str, running: bool = False) -> tuple[str, str]:
    """What human walking, or running, has for a measure, and where it is known from; empty if that is not known."""
    if "outside the norms" in name:
        return "0", "the span of published means"
    if running:
        return _RUNNING.get(name, ""), RUNNING[0].source if name in _RUNNING else ""
    name = "cost of transport" if name in (BHARGAVA_NET, BHARGAVA_STRICT) else name  # what people's breath says of both
    if name in REFERENCES:
        known = REFERENCES[name]
        text = f"{known.low:g}" if known.low == known.high else f"{known.low:g} to {known.high:g}"
        return text, known.source
    title, index = _POINTS.get(name.removesuffix(AT), ("", 0))
    if title:
        percent, value = NORMS[title].points[index]
        return f"{percent:g}" if name.endswith(AT) else f"{value:g} ± {NORMS[title].half_width:g}", SOURCE
    if name == "depth of the valley":
        first, valley, second = (NORMS[FORCE].points[index][1] for index in (1, 2, 3))
        return f"{min(first, second) - valley:.2g}", SOURCE
    if name == "stance":
        return f"{NORMS[FORCE].points[-1][0]:g}", SOURCE
    if name in MOMENTS_AT:
        curve, percent = MOMENTS_AT[name]
        at, band = np.array([percent]), MOMENTS[curve]
        return f"{band.mean(at)[0]:.2f} ± {band.sd(at)[0]:.2f}", PEOPLE
    return ("100", SOURCE) if name.endswith("norm band") else ("", "")
