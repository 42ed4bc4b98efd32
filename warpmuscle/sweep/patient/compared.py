"""How far walks are from a patient's own strides, and what a change does to them, over seeds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.studies.conditions import Cell, Spread, cells_of, spread_of
from warpmuscle.sweep.patient.file import UNCHANGED
from warpmuscle.sweep.patient.gait import ANGLES, FORCES, MOMENTS, UNITS, Gait, unit_of
from warpmuscle.sweep.patient.recorded import Patient

BAND = 2.0  # standard deviations to either side, that nearly all strides are within
JUDGED = (*MOMENTS, *FORCES)  # curves that no search sees
JUDGED_POINTS = ("stride time", "stride length", "left stance", "right stance")
COST = "cost of transport"


@dataclass(frozen=True)
class Walk:
    """The best walk of a search, or a scene as it stands."""

    seed: int
    condition: str
    walked: bool  # to the end
    gait: Gait | None = None
    cost: float | None = None  # J/(kg m)
    why: str = ""  # no gait is known of it


@dataclass(frozen=True)
class Distance:
    """How far walks are from the patient's strides, in a curve of a side."""

    name: str
    side: str
    unit: str
    of_strides: float | None  # of the patient's strides from the mean of the others; None where there is one only
    before: float | None  # of the scene before the search
    found: Spread  # of the walks that the search found, over seeds
    within: Spread | None = None  # part of the cycle within the patient's band, %
    likeness: Spread | None = None  # correlation with the patient's curve


@dataclass(frozen=True)
class Changed:
    """A number of the gait: the patient's, the walks' that match, and of each condition after adapting."""

    name: str
    unit: str
    patient: float | None
    spread: float | None  # standard deviation of the patient's strides
    matched: Spread
    cells: tuple[Cell, ...]  # the first of them without a change, which others are compared with


def in_spread(curve: Floats, patient: Patient, name: str, side: str) -> float:
    """Root mean square distance of a curve (101,) from the patient's mean stride, in standard deviations."""
    away = (curve - patient.gait.mean(name, side)) / patient.spread[name][side]
    return float(np.sqrt(np.mean(away**2)))


def within(curve: Floats, patient: Patient, name: str, side: str) -> float:
    """Part of the cycle, %, in which a curve (101,) is within `BAND` standard deviations of the patient's mean."""
    away = np.abs(curve - patient.gait.mean(name, side)) / patient.spread[name][side]
    return 100.0 * float(np.mean(away <= BAND))


def stride_distance(patient: Patient, name: str, side: str) -> float | None:
    """Mean distance of each of the patient's strides from the mean of the others, in standard deviations."""
    return among_strides(patient.gait.curves[name][side], patient.spread[name][side])


def among_strides(rows: Floats, unit: Floats | float = 1.0) -> float | None:
    """Mean distance of each of a person's strides (S, 101) from the mean of the others; None of a single stride.

    Args:
        unit: that it is told in, such as standard deviations (101,).
    """
    if len(rows) < 2:
        return None
    rest = (rows.sum(axis=0) - rows) / (len(rows) - 1)
    return float(np.sqrt(np.mean(((rows - rest) / unit) ** 2, axis=1)).mean())


def angle_distance(gait: Gait, patient: Patient) -> float:
    """Mean over the three angles of both sides of `in_spread`."""
    each = [in_spread(gait.mean(name, side), patient, name, side) for name in ANGLES for side in SIDES]
    return float(np.mean(each))


def searched_distances(patient: Patient, before: Gait | None, walks: Sequence[Walk]) -> list[Distance]:
    """Distances of the angles, which the search was for, in the patient's own standard deviations."""
    gaits = [walk.gait for walk in walks if walk.gait is not None]
    found = []
    for name in ANGLES:
        for side in SIDES:
            curves = [gait.mean(name, side) for gait in gaits]
            found.append(
                Distance(
                    name, side, "SD", stride_distance(patient, name, side),
                    None if before is None else in_spread(before.mean(name, side), patient, name, side),
                    spread_of(np.array([in_spread(curve, patient, name, side) for curve in curves])),
                    spread_of(np.array([within(curve, patient, name, side) for curve in curves])),
                )
            )  # fmt: skip
    return found


def judged_distances(patient: Patient, before: Gait | None, walks: Sequence[Walk]) -> list[Distance]:
    """Distances of moments and forces, which no search saw: root mean square, in their unit, and correlations."""
    gaits = [walk.gait for walk in walks if walk.gait is not None]
    found = []
    for name in JUDGED:
        if name not in patient.gait.curves:
            continue
        for side in SIDES:
            mean = patient.gait.mean(name, side)
            curves = [gait.mean(name, side) for gait in gaits if name in gait.curves]
            found.append(
                Distance(
                    name, side, UNITS[name], among_strides(patient.gait.curves[name][side]),
                    None if before is None or name not in before.curves else rms(before.mean(name, side) - mean),
                    spread_of(np.array([rms(curve - mean) for curve in curves])),
                    likeness=spread_of(np.array([_correlation(curve, mean) for curve in curves])),
                )
            )  # fmt: skip
    return found


def rms(values: Floats) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def _correlation(one: Floats, other: Floats) -> float:
    """Of two curves; 0 where one does not change."""
    return float(np.corrcoef(one, other)[0, 1]) if min(one.std(), other.std()) > 1e-9 else 0.0


def numbers_of(walk: Walk) -> Mapping[str, float]:
    """Numbers of a walk, the mean of its strides."""
    if walk.gait is None:
        return {}
    cost = {} if walk.cost is None else {COST: walk.cost}
    return {name: float(values.mean()) for name, values in walk.gait.points.items()} | cost


def changed_numbers(patient: Patient, matched: Sequence[Walk], walks: Sequence[Walk]) -> list[Changed]:
    """All numbers over the conditions of the walks that adapted, in order."""
    own = patient.gait.points
    of_matched, of_walks = [numbers_of(walk) for walk in matched], [numbers_of(walk) for walk in walks]
    conditions, seeds = [walk.condition for walk in walks], [walk.seed for walk in walks]
    walked = np.array([walk.walked for walk in walks], dtype=bool)
    names = dict.fromkeys(name for numbers in of_walks for name in numbers)
    found = []
    for name in names:
        values = np.array([numbers.get(name, np.nan) for numbers in of_walks])
        cells = cells_of(values, walked, conditions, seeds, UNCHANGED)
        strides = own.get(name)
        several = strides is not None and len(strides) > 1
        found.append(
            Changed(
                name, unit_of(name),
                None if strides is None else float(strides.mean()),
                float(strides.std(ddof=1)) if strides is not None and several else None,
                spread_of(np.array([numbers.get(name, np.nan) for numbers in of_matched])),
                tuple(cells),
            )
        )  # fmt: skip
    return found
