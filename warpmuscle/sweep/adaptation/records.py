"""Measured conditions of walking, as a JSON file has them: a list of objects, a condition each.

Dimensionless values are those of Hof 1996: frequencies over sqrt(g/l), powers over m g^1.5 sqrt(l), with the mass m of
the body without load and the leg length l.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.decoding import to_type
from warpmuscle.core.errors import Error, SceneError
from warpmuscle.core.files import read_file, unreadable
from warpmuscle.core.limits import check_size

USUAL_SPEED = 1.3  # m/s; of level walks at several speeds, the nearest to this is what others are compared with
ANGLES = {"hip_flexion_deg": 1.0, "knee_angle_deg": -1.0, "ankle_angle_deg": 1.0}  # signs that make them flexion
BACKPACK = "torso"  # where a load is that is said to be nowhere
LIMBS = ("femur", "tibia", "foot", "knee", "ankle")  # whose loads are those of each leg
GREATEST = {"speed_m_s": 20.0, "slope_pct": 100.0, "added_mass_kg": 500.0}


class _Entry(msgspec.Struct):
    study: str
    identifier: str
    speed_m_s: float
    subject_mass_kg: float
    leg_length_m: float
    slope_pct: float = 0.0
    added_mass_kg: float = 0.0
    added_mass_where: str | None = None
    metabolic_power_nd: float | None = None
    stride_frequency_nd: float | None = None
    curves_right: dict[str, Any] = {}


@dataclass(frozen=True)
class Record:
    """A condition, and what was measured in it; None where it was not."""

    name: str
    study: str
    speed: float  # m/s
    slope: float  # of the ground, rise over run
    load: float  # over the mass of the body; of limbs that of each leg
    place: str  # of the load; "" without one
    leg: float  # length of the subjects' legs, m
    power: float | None  # metabolic, dimensionless
    frequency: float | None  # of strides, dimensionless
    angles: tuple[Floats, ...] = ()  # hip, knee and ankle flexion over the stride, degrees

    @property
    def kind(self) -> str:
        """What differs from the condition that it is compared with."""
        if self.load:
            return "load"
        return "speed" if not self.slope else "uphill" if self.slope > 0.0 else "downhill"

    @property
    def described(self) -> str:
        """What was walked, in words."""
        words = [f"{self.speed:.2f} m/s"]
        if self.slope:
            words.append(f"{'up' if self.slope > 0.0 else 'down'} {100.0 * abs(self.slope):.0f} %")
        if self.load:
            where = f"each {self.place}" if self.place in LIMBS else f"the {self.place}"
            words.append(f"{100.0 * self.load:.0f} % of the body's mass on {where}")
        return ", ".join(words)


def read_records(path: Path) -> list[Record]:
    """The conditions of a file.

    Raises:
        Error: it cannot be read, or is not as it must be, with the condition and the key.
    """
    try:
        data = json.loads(read_file(path).decode("utf-8-sig"))
    except (OSError, ValueError, RecursionError) as error:
        text = unreadable(error) if isinstance(error, OSError) else f"not valid JSON: {error}"
        raise Error(f"{path}: {text}") from None
    if not isinstance(data, list) or not data:
        raise Error(f"{path}: is not a list of conditions")
    check_size("sweep", len(data), lambda text: Error(f"{path}: {text}"))
    records = []
    for number, one in enumerate(data, 1):
        try:
            records.append(_record(to_type(one, _Entry)))
        except (SceneError, ValueError) as error:
            text = error.message if isinstance(error, SceneError) else str(error)
            key = f".{error.key}" if isinstance(error, SceneError) and error.key else ""
            raise Error(f"{path}: condition {number}{key}: {text}") from None
    names = [record.name for record in records]
    if twice := next((number for number, name in enumerate(names) if name in names[:number]), 0):
        first = names.index(names[twice])
        raise Error(f"{path}: conditions {first + 1} and {twice + 1} have the same identifier, {names[twice]!r}")
    return records


def _record(entry: _Entry) -> Record:
    for name, limit in GREATEST.items():
        if not abs(getattr(entry, name)) <= limit:
            raise ValueError(f"{name} must be within {limit:g}, is {getattr(entry, name):g}")
    for name in ("speed_m_s", "subject_mass_kg", "leg_length_m"):
        if not (0.0 < getattr(entry, name) < math.inf):
            raise ValueError(f"{name} must be greater than 0, is {getattr(entry, name):g}")
    if entry.added_mass_kg < 0.0:
        raise ValueError(f"added_mass_kg must not be negative, is {entry.added_mass_kg:g}")
    for name in ("metabolic_power_nd", "stride_frequency_nd"):
        if getattr(entry, name) is not None and not math.isfinite(getattr(entry, name)):
            raise ValueError(f"{name} is not finite")
    place = entry.added_mass_where or BACKPACK
    return Record(
        entry.identifier, entry.study, entry.speed_m_s, entry.slope_pct / 100.0,
        entry.added_mass_kg / entry.subject_mass_kg, place if entry.added_mass_kg else "",
        entry.leg_length_m, entry.metabolic_power_nd, entry.stride_frequency_nd, _angles(entry.curves_right),
    )  # fmt: skip


def _angles(curves: dict[str, Any]) -> tuple[Floats, ...]:
    """Angles of all three joints at the same points of the stride; none unless all are there."""
    if not all(name in curves for name in ANGLES):
        return ()
    try:
        found = tuple(sign * np.array(curves[name], dtype=float) for name, sign in ANGLES.items())
    except (TypeError, ValueError):
        raise ValueError("curves_right has an angle that is not a list of numbers") from None
    if len({one.shape for one in found}) > 1 or found[0].ndim != 1 or len(found[0]) < 2:
        raise ValueError("the angles of curves_right are not lists of the same length, two points or more")
    if not np.isfinite(found).all():
        raise ValueError("curves_right has an angle that is not finite")
    return found


def reference_of(record: Record, records: Sequence[Record]) -> Record | None:
    """The condition that one is compared with: level, without load and as fast, or, if it is that, at a usual speed.

    Returns:
        None if it is that itself, or there is none in its study.
    """
    level = [one for one in records if one.study == record.study and not one.slope and not one.load]
    if record.slope or record.load:
        found = [one for one in level if abs(one.speed - record.speed) < 1e-3]
        return found[0] if found else None
    usual = min(level, key=lambda one: abs(one.speed - USUAL_SPEED))
    return None if usual.name == record.name else usual
