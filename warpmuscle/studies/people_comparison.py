"""Which rows of a judgement stand beside people at the same speed, which beside others, and which by a trend."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from warpmuscle.core.plain_text import rounded
from warpmuscle.gait.quality import TIMING, Measures
from warpmuscle.scene.norms import FORCE, NORMS
from warpmuscle.studies.verdicts import COMFORTABLE, HUMPS, Finding

MEASURED_SPEED, NEAR = 1.26, 0.15  # m/s, of the people whose angles are norms, and how far from it they stay so
IN_PLACE = 0.05  # m/s; who is slower goes nowhere


def of_norms(measures: Measures) -> dict[str, Finding]:
    """Rows that are measured against people at another speed, or by a trend, and what muscles' timing is made of."""
    found: dict[str, Finding] = {}
    speed = measures.get("speed")
    timings = {name: value for name, value in measures.items() if name.startswith("timing of ") and value is not None}
    if (timing := measures.get(TIMING)) is not None:
        each = sorted((name for name in timings if name != TIMING), key=lambda name: timings[name])
        least = [f"{name.removeprefix('timing of ')} {timings[name]:.0f}" for name in each]
        found[TIMING] = Finding(timing, "least: " + ", ".join(least[:3]))
    if (sway := measures.get("sway from people")) is not None:
        found["sway from people"] = Finding(sway, "people's spread not checked at its source")
    if speed is None or abs(speed - MEASURED_SPEED) <= NEAR:
        return found
    walks = f"not at {rounded(speed, 2)} m/s"
    if abs(speed) < IN_PLACE:
        walks = "and this body stays in its place, as on a treadmill"
    for name in COMFORTABLE:
        if (value := measures.get(name)) is not None:
            found[name] = Finding(value, f"of people at their own speed, {walks}", judges=False)
    if (angles := measures.get("angles outside the norms")) is not None:
        note = f"norms of {MEASURED_SPEED:g} m/s, moved to {rounded(speed, 2)} m/s by the trend that searches know"
        found["angles outside the norms"] = Finding(angles, note, judges=False)
    return found


def of_force(measures: Mapping[str, float | None]) -> dict[str, float | None]:
    """How far both peaks and the valley of the vertical force are from people's, in half-widths."""
    norm = NORMS[FORCE]
    found: dict[str, float | None] = {}
    names = ("first hump of the force", "valley of the force", "second hump of the force")
    off = [
        abs(value - norm.points[index][1]) / norm.half_width
        for index, name in enumerate(names, 1)
        if (value := measures.get(name)) is not None
    ]
    found[HUMPS] = float(np.mean(off)) if len(off) == len(names) else None
    return found
