"""Whether muscles are excited and active when people's are, by windows of electromyograms over the gait cycle."""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.gait.cycles import PERCENT, Strides, over_strides
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.results.recording import Recording
from warpmuscle.scene.people.emg import MUSCLES, WINDOWS

QUIET = 0.01  # change of the excitation over the cycle, below which a muscle does nothing
# Nine muscles that electromyograms are usually taken of; where a body has not the first, the next stands for it.
NINE = (
    ("gluteus maximus",), ("gluteus medius", "hip abductors"), ("iliopsoas", "iliacus", "hip flexors"),
    ("semimembranosus", "hamstrings"), ("rectus femoris",), ("vasti",), ("gastrocnemius",), ("soleus",),
    ("tibialis anterior",),
)  # fmt: skip


class ActiveWindow(NamedTuple):
    """A window in which people's muscle is active, % of the cycle, and how active the muscle is."""

    muscle: str
    begin: float
    end: float  # below `begin` where it goes on into the next cycle
    inside: float  # mean activation in the window
    mean: float  # over the cycle
    change: float  # from the least to the greatest one over the cycle

    @property
    def is_met(self) -> bool:
        """Whether the muscle does anything, and is more active in the window than in the mean of the cycle."""
        return self.change >= QUIET and self.inside > self.mean


def muscle_timing(recording: Recording, cycles: dict[str, Strides]) -> dict[str, float]:
    """How well the excitation of each muscle that has windows lies within them, %, by name of the muscle.

    It is the share of the mean excitation over the cycle, above its least value, that lies within the windows, beyond
    the share that an even one has there: 100 is all within, 0 no better than chance, less is against people. A muscle
    that does nothing has 0. Heads of one muscle count together, and so do both sides.
    """
    curves = muscle_curves(recording, recording.muscle_excitation, cycles)
    return {muscle: beyond_chance(muscle, np.mean(curves[muscle], axis=0)) for muscle in WINDOWS if muscle in curves}


def active_windows(recording: Recording, cycles: dict[str, Strides]) -> list[ActiveWindow]:
    """People's windows of the nine muscles that a body has, and how active its muscles are in them.

    Heads of one muscle count together, and so do both sides. A window that is cut by the contact of the foot is one.
    """
    curves = muscle_curves(recording, recording.muscle_activation, cycles)
    found = []
    for names in NINE:
        muscle = next((name for name in names if name in curves), None)
        if muscle is not None:
            curve = np.mean(curves[muscle], axis=0)[:-1]
            mean, change = float(curve.mean()), float(np.ptp(curve))
            found += [
                ActiveWindow(muscle, begin, end, float(curve[_within(begin, end)].mean()), mean, change)
                for begin, end in joined_windows(muscle)
            ]
    return found


def joined_windows(muscle: str) -> list[tuple[float, float]]:
    """Windows of a muscle in `WINDOWS`, of which one that ends with the cycle goes on in that which begins it."""
    windows = [(float(begin), float(end)) for begin, end in WINDOWS[muscle]]
    if len(windows) > 1 and windows[0][0] <= 0.0 and windows[-1][1] >= 100.0:
        return [*windows[1:-1], (windows[-1][0], windows[0][1])]
    return windows


def _within(begin: float, end: float) -> NDArray[np.bool_]:
    """Which percents of the cycle, without the last, lie in a window."""
    percent = PERCENT[:-1]
    if begin < end:
        return np.asarray((percent >= begin) & (percent < end))
    return np.asarray((percent >= begin) | (percent < end))


def muscle_curves(recording: Recording, values: Floats, cycles: dict[str, Strides]) -> dict[str, list[Floats]]:
    """Mean curves (101,) of values (F, muscles) over the cycle, of all heads on both sides, by name of the muscle."""
    curves: dict[str, list[Floats]] = {}
    for index, name in enumerate(recording.muscle_names):
        side, muscle = side_and_muscle(name)
        if muscle:
            of_muscle = over_strides(recording.time, values[:, index], cycles[side])
            curves.setdefault(muscle, []).append(of_muscle.mean(axis=0))
    return curves


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
