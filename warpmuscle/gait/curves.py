"""Curves of a walk over the gait cycle, and people's beside them: what figures draw and files hold."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.gait.centre_of_pressure import centre_of_pressure
from warpmuscle.gait.cycles import PERCENT, Strides, leg_angles, over_strides
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.gait.ground_force import forward_forces, vertical_forces
from warpmuscle.gait.joint_moments import PEOPLE, leg_moments, leg_powers
from warpmuscle.gait.pelvis_and_trunk import stride_turns
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.norms import FORCE

FORWARDS, PRESSURE = "Ground force forwards", "Centre of pressure"


class Curves(NamedTuple):
    """A quantity over the gait cycles of both sides, NaN where it is nowhere; and people's mean and deviation."""

    unit: str
    sides: Mapping[str, Floats]  # (S, 101) each, a row a cycle
    people: tuple[Floats, Floats] | None  # (101,) each


def gait_curves(recording: Recording, scene: Scene, cycles: dict[str, Strides]) -> dict[str, Curves]:
    """All curves by name: angles, moments and powers of the legs, ground force, pressure, turns of pelvis and trunk.

    People stand beside moments, powers and turns of the pelvis, at their own comfortable speed (Pinzone 2014). Legs of
    fewer than three joints have none of their own.

    Args:
        scene: without free parameters. cycles: of both sides, from contact to contact.
    """
    found = {
        name: Curves(unit, {side: over_strides(recording.time, sides[side], cycles[side]) for side in SIDES}, None)
        for name, (unit, sides) in frame_curves(recording, scene).items()
    }
    found |= {name: Curves("deg", sides, None) for name, sides in stride_turns(recording, scene, cycles).items()}
    for name in set(found) & set(PEOPLE):
        found[name] = found[name]._replace(people=(PEOPLE[name].mean(PERCENT), PEOPLE[name].sd(PERCENT)))
    return found


def frame_curves(recording: Recording, scene: Scene) -> dict[str, tuple[str, dict[str, Floats]]]:
    """The same over time: unit and both sides (F,) by name, but for turns of pelvis and trunk, which strides define."""
    frames: dict[str, tuple[str, dict[str, Floats]]] = {}
    try:
        frames |= {name: ("deg", sides) for name, sides in leg_angles(recording, scene).items()}
        frames |= {name: ("N m/kg", sides) for name, sides in leg_moments(recording, scene).items()}
        frames |= {name: ("W/kg", sides) for name, sides in leg_powers(recording, scene).items()}
    except Error:
        pass  # no hip, knee and ankle
    frames[FORCE] = ("body weights", vertical_forces(recording, scene))
    frames[FORWARDS] = ("body weights", forward_forces(recording, scene))
    frames[PRESSURE] = ("% of the foot", centre_of_pressure(recording, scene))
    return frames


def as_numbers(curves: Mapping[str, Curves]) -> dict[str, Any]:
    """Mean curves, fit for JSON: at every percent of the cycle, by name and side, null where there is nothing."""
    found: dict[str, Any] = {"percent": PERCENT.tolist()}
    for name, curve in curves.items():
        found[name] = {"unit": curve.unit} | {side: _numbers(mean_of(rows)) for side, rows in curve.sides.items()}
        if curve.people is not None:
            found[name] |= dict(zip(("people", "people_sd"), map(_numbers, curve.people), strict=True))
    return found


def mean_of(rows: Floats) -> Floats:
    """The mean (101,) of cycles (S, 101), where at least half of them have a value; else NaN."""
    known = np.isfinite(rows)
    often = known.sum(axis=0) >= 0.5 * len(rows)
    total = np.where(known, rows, 0.0).sum(axis=0)
    return np.where(often, total / np.maximum(known.sum(axis=0), 1), np.nan)


def _numbers(values: Floats) -> list[float | None]:
    return [round(float(value), 5) if np.isfinite(value) else None for value in values]
