"""Whether muscles are excited when people's are, by windows of electromyograms over the gait cycle."""

from __future__ import annotations

from fnmatch import fnmatchcase

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.gait.cycles import PERCENT, Strides, over_strides
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.results.recording import Recording
from warpmuscle.scene.people.emg import MUSCLES, WINDOWS

QUIET = 0.01  # change of the excitation over the cycle, below which a muscle does nothing


def muscle_timing(recording: Recording, cycles: dict[str, Strides]) -> dict[str, float]:
    """How well the excitation of each muscle that has windows lies within them, %, by name of the muscle.

    It is the share of the mean excitation over the cycle, above its least value, that lies within the windows, beyond
    the share that an even one has there: 100 is all within, 0 no better than chance, less is against people. A muscle
    that does nothing has 0. Heads of one muscle count together, and so do both sides.
    """
    curves: dict[str, list[Floats]] = {}
    for index, name in enumerate(recording.muscle_names):
        side, muscle = side_and_muscle(name)
        if muscle:
            of_muscle = over_strides(recording.time, recording.muscle_excitation[:, index], cycles[side])
            curves.setdefault(muscle, []).append(of_muscle.mean(axis=0))
    return {muscle: beyond_chance(muscle, np.mean(curves[muscle], axis=0)) for muscle in WINDOWS if muscle in curves}


def beyond_chance(muscle: str, curve: Floats) -> float:
    """How well an excitation (101,) over the cycle lies within the windows of a muscle, %, see `muscle_timing`."""
    above = (curve - curve.min())[:-1]
    if above.max() < QUIET:
        return 0.0
    percent = PERCENT[:-1]
    inside = np.any([(percent >= begin) & (percent < end) for begin, end in WINDOWS[muscle]], axis=0)
    chance = float(inside.mean())
    return 100.0 * (float(above[inside].sum() / above.sum()) - chance) / (1.0 - chance)


def side_and_muscle(name: str) -> tuple[str, str]:
    """Side and name in `WINDOWS` of a muscle such as `lSOL` or `soleus_r`; empty ones for others."""
    for side in SIDES:
        letter = side[0]
        for stem, fits in ((name[1:], name[:1] == letter), (name[:-2], name.endswith(f"_{letter}"))):
            if fits and (muscle := _muscle(stem)):
                return side, muscle
    return "", ""


def _muscle(stem: str) -> str:
    found = (muscle for muscle, names in MUSCLES.items() if any(fnmatchcase(stem, name) for name in names))
    return next(found, "")
