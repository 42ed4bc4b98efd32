"""Walks in numbers, beside people's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from warpmuscle.core.errors import Error
from warpmuscle.gait.curves import as_numbers, gait_curves
from warpmuscle.gait.cycles import steady_strides
from warpmuscle.gait.quality import LEAST_FLIGHT, Measures, gait_measures
from warpmuscle.gait.table import human, shown_rows, unit_of
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import installed_versions
from warpmuscle.scene import Scene
from warpmuscle.scene.accounting import accounting


@dataclass(frozen=True)
class MeasuredWalk:
    """A walk and its measures."""

    name: str
    duration: float  # s
    measures: Measures
    running: bool
    energy: str  # how its cost is counted; empty where there is none
    rate: float  # frames/s
    curves: dict[str, Any]  # over the gait cycle, see `gait.curves.as_numbers`


FINE = 200.0  # frames/s, between which a peak of the force hardly hides


def measured(name: str, motion: Recording, scene: Scene) -> MeasuredWalk:
    """Measure a walk of a scene without free parameters.

    Raises:
        Error: no legs, or no whole gait cycle.
    """
    try:
        measures = gait_measures(motion, scene)
        curves = as_numbers(gait_curves(motion, scene, steady_strides(motion, scene)))
    except Error as error:
        raise Error(f"{name}: {error}") from None
    gait, flight = scene.objective.gait, measures.get("flight") or 0.0
    running = gait == "run" if gait else flight > LEAST_FLIGHT
    has_cost = measures.get("cost of transport") is not None
    energy = accounting(scene, motion.muscle_names) if has_cost else ""
    rate = 1.0 / float(motion.time[1] - motion.time[0])
    return MeasuredWalk(name, float(motion.time[-1]), measures, running, energy, rate, curves)


def table(walks: Sequence[MeasuredWalk]) -> list[tuple[str, ...]]:
    """Rows of measures with people's, a column for each walk."""
    running = all(walk.running for walk in walks)
    head = ("", "unit", "runners" if running else "people", *(walk.name for walk in walks))
    return [head, *shown_rows([walk.measures for walk in walks], running)]


def energies(walks: Sequence[MeasuredWalk]) -> list[str]:
    """How the cost of transport is counted, a line for all walks that count alike."""
    names: dict[str, list[str]] = {}
    for walk in walks:
        names.setdefault(walk.energy, []).append(walk.name)
    alone = len(walks) == 1
    return [
        f"cost of transport{'' if alone else ' of ' + ', '.join(of)}: {words}" for words, of in names.items() if words
    ]


def coarse(walks: Sequence[MeasuredWalk]) -> list[str]:
    """What the frames of walks may miss, a line for each that has few of them."""
    return [
        f"{walk.name} has {walk.rate:.0f} frames/s: its greatest force may lie between them, and times of contact are "
        f"{500.0 / walk.rate:.0f} ms off; `warpmuscle judge` takes {FINE:.0f}"
        for walk in walks
        if walk.rate < 0.99 * FINE
    ]


def numbers(walks: Sequence[MeasuredWalk]) -> dict[str, Any]:
    """All numbers, with units and where those of people are from."""
    names = dict.fromkeys(name for walk in walks for name in walk.measures)
    people = {name: dict(zip(("value", "source"), human(name), strict=True)) for name in names if human(name)[0]}
    return {
        "versions": installed_versions(),
        "units": {name: unit_of(name) for name in names},
        "people": people,
        "walks": [
            {
                "name": walk.name,
                "duration": walk.duration,
                "frames_per_second": walk.rate,
                "measures": walk.measures,
                "energy": walk.energy,
                "curves": walk.curves,
            }
            for walk in walks
        ],
    }
