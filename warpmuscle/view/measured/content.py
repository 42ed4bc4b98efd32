"""What the page is sent about markers and forces on bodies that were measured; numbers only."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.sequences import nearest_rows
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import sides_of

if TYPE_CHECKING:
    from warpmuscle.inverse.recordings.measured import Measured

NEAR = 1e-3  # s, between a frame of a motion and the same of what was measured


def at_times(measured: Measured | None, times: Floats) -> Measured | None:
    """What was measured in the frames of a motion; None where some of these are of other times."""
    if measured is None or not len(measured.times):
        return None
    nearest = nearest_rows(measured.times, times)
    if np.abs(measured.times[nearest] - times).max() > NEAR:
        return None
    vectors = ("position", "modelled", "force", "point")
    return replace(measured, times=times, **{name: getattr(measured, name)[nearest] for name in vectors})


def moved_back(measured: Measured, shift: Floats) -> Measured:
    """What was measured, its places less those (F, 3), m, that belts have moved to."""
    places = ("position", "modelled", "point")
    return replace(measured, **{name: getattr(measured, name) - shift[:, None] for name in places})


def measured_arrays(measured: Measured | None) -> dict[str, tuple[Floats, float]]:
    """Arrays (F, ...), and how finely to store them: markers, whether they were seen, and forces."""
    if measured is None:
        return {}
    arrays: dict[str, tuple[Floats, float]] = {}
    seen = np.isfinite(measured.position).all(axis=2)
    if measured.markers:
        arrays["marker"] = (filled(measured.position), 16)
        arrays["modelled"] = (filled(measured.modelled), 16)
    if not seen.all():
        arrays["seen"] = (np.asarray(seen, dtype=np.float64), 8)
    if measured.bodies:
        arrays["plate"] = (measured.force, 16)
        arrays["plate_point"] = (measured.point, 16)
    return arrays


def filled(positions: Floats) -> Floats:
    """Positions (F, K, 3) without gaps: where one is missing it is as it was last, or will be first."""
    found = positions.copy()
    for marker in range(positions.shape[1]):
        known = np.flatnonzero(np.isfinite(positions[:, marker]).all(axis=1))
        if not len(known):
            found[:, marker] = 0.0
            continue
        last = np.searchsorted(known, np.arange(len(positions)), side="right") - 1
        found[:, marker] = positions[known[np.maximum(last, 0)], marker]
    return found


def measured_content(measured: Measured | None, scene: Scene) -> dict[str, Any]:
    """Names of markers, and on which side forces act."""
    if measured is None:
        return {}
    sides = sides_of(scene.character)
    return {"markers": list(measured.markers), "plates": [sides.get(body, "middle") for body in measured.bodies]}
