"""Predicted changes beside measured ones: what part of a change is predicted, and how far off."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.sweep.adaptation.predicted import FORMULAS, Prediction
from warpmuscle.sweep.adaptation.records import Record, reference_of

FREQUENCY = "stride frequency"
KINDS = ("speed", "uphill", "downhill", "load")


@dataclass(frozen=True)
class Change:
    """How a quantity differs from that of the condition compared with, in percent of what was measured there."""

    record: Record
    quantity: str  # a formula of metabolic power, or the stride frequency
    measured: float
    predicted: float  # median over seeds
    low: float  # 5 to 95 % of the seeds
    high: float
    seeds: int


@dataclass(frozen=True)
class Score:
    """How well changes of a quantity are predicted over the conditions of a kind."""

    quantity: str
    kind: str  # of KINDS, or one with the study, or where a load is, that alone is counted
    conditions: int
    part: float  # of the measured changes, by least squares through 0; not a number where none was measured
    error: float  # root mean square, percent


@dataclass(frozen=True)
class AngleChange:
    """Angles over the stride: root mean square of the error of predicted changes, and of the measured changes."""

    record: Record
    error: tuple[float, ...]  # hip, knee, ankle, degrees
    measured: tuple[float, ...]


Predictions = Mapping[str, Mapping[int, Prediction]]  # by name of the condition and seed


def changes(records: Sequence[Record], found: Predictions) -> list[Change]:
    """Changes of all measured quantities, of conditions that walked with a seed with which their reference did."""
    result = []
    for record in records:
        reference = reference_of(record, records)
        if reference is None:
            continue
        pairs = _pairs(record, reference, found)
        for quantity in (*FORMULAS, FREQUENCY):
            here, there = (_measured(one, quantity) for one in (record, reference))
            values = [(_value(a, quantity), _value(b, quantity)) for a, b in pairs]
            shifts = np.array([a - b for a, b in values if a is not None and b is not None])
            if here is None or there is None or there == 0.0 or not len(shifts):
                continue
            percent = 100.0 * shifts / there
            low, middle, high = np.percentile(percent, (5.0, 50.0, 95.0)).tolist()
            result.append(Change(record, quantity, 100.0 * (here / there - 1.0), middle, low, high, len(shifts)))
    return result


def scores(all_changes: Sequence[Change]) -> list[Score]:
    """How well each quantity is predicted by kind of condition, and, of several, by study and by where loads are."""
    result = []
    for quantity in dict.fromkeys(change.quantity for change in all_changes):
        for kind in KINDS:
            mine = [one for one in all_changes if one.quantity == quantity and one.record.kind == kind]
            if not mine:
                continue
            result.append(_score(quantity, kind, mine))
            studies = list(dict.fromkeys(one.record.study for one in mine))
            for study in studies if len(studies) > 1 else ():
                result.append(_score(quantity, f"{kind}, {study}", [one for one in mine if one.record.study == study]))
            places = list(dict.fromkeys(one.record.place for one in mine))
            for place in places if len(places) > 1 else ():
                result.append(_score(quantity, f"{kind}, {place}", [one for one in mine if one.record.place == place]))
    return result


def _score(quantity: str, kind: str, mine: Sequence[Change]) -> Score:
    """How well some changes of a quantity are predicted."""
    x, y = (np.array([getattr(one, name) for one in mine]) for name in ("measured", "predicted"))
    square = float(x @ x)
    part = float(x @ y) / square if square > 0.0 else float("nan")
    return Score(quantity, kind, len(mine), part, float(np.sqrt(np.mean((y - x) ** 2))))


def angle_changes(records: Sequence[Record], found: Predictions) -> list[AngleChange]:
    """Changes of the angles of conditions that have them, as their reference does: medians over seeds."""
    result = []
    for record in records:
        reference = reference_of(record, records)
        if reference is None or not record.angles or not reference.angles:
            continue
        pairs = [(a, b) for a, b in _pairs(record, reference, found) if a.angles and b.angles]
        if not pairs:
            continue
        errors, sizes = [], []
        for joint, (here, there) in enumerate(zip(record.angles, reference.angles, strict=True)):
            measured = here - there
            predicted = np.median([_resampled(a.angles[joint] - b.angles[joint], len(here)) for a, b in pairs], axis=0)
            errors.append(float(np.sqrt(np.mean((predicted - measured) ** 2))))
            sizes.append(float(np.sqrt(np.mean(measured**2))))
        result.append(AngleChange(record, tuple(errors), tuple(sizes)))
    return result


def _resampled(curve: Floats, points: int) -> Floats:
    """A curve over the stride at so many points from its start to its end."""
    places = np.linspace(0.0, 1.0, points), np.linspace(0.0, 1.0, len(curve))
    return np.asarray(np.interp(*places, curve))


def _pairs(record: Record, reference: Record, found: Predictions) -> list[tuple[Prediction, Prediction]]:
    here, there = found.get(record.name, {}), found.get(reference.name, {})
    return [(here[seed], there[seed]) for seed in here if seed in there]


def _measured(record: Record, quantity: str) -> float | None:
    return record.frequency if quantity == FREQUENCY else record.power


def _value(prediction: Prediction, quantity: str) -> float | None:
    return prediction.frequency if quantity == FREQUENCY else prediction.power.get(quantity)
