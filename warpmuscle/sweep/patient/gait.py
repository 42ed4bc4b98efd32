"""A gait in curves and numbers, side by side: the patient's and a walk's alike."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.gait.curves import FORWARDS, gait_curves
from warpmuscle.gait.cycles import Strides
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.ground import LOADED
from warpmuscle.scene.norms import FORCE, LEG_ANGLES, LEG_MOMENTS

ANGLES, MOMENTS, FORCES = LEG_ANGLES, LEG_MOMENTS, (FORCE, FORWARDS)
POWERS = ("Hip power", "Knee power", "Ankle power")
UNITS = dict.fromkeys(ANGLES, "deg") | dict.fromkeys(MOMENTS, "N m/kg") | dict.fromkeys(POWERS, "W/kg")
UNITS |= dict.fromkeys(FORCES, "body weights")
TILT = "Pelvis tilt"
UNITS[TILT] = "deg"
MOST, LEAST = np.max, np.min
# Numbers of a side: the curve, which of its ends, and between which percents of the cycle.
POINTS: dict[str, tuple[str, Callable[..., float], int, int]] = {
    "hip, maximum": ("Hip flexion", MOST, 0, 100),
    "hip, minimum": ("Hip flexion", LEAST, 20, 80),
    "knee, maximum in stance": ("Knee flexion", MOST, 2, 40),
    "knee, minimum in stance": ("Knee flexion", LEAST, 20, 60),
    "knee, maximum in swing": ("Knee flexion", MOST, 45, 100),
    "ankle, maximum in stance": ("Ankle dorsiflexion", MOST, 8, 62),
    "ankle, minimum at push-off": ("Ankle dorsiflexion", LEAST, 45, 85),
    "hip moment, maximum": ("Hip moment", MOST, 0, 60),
    "hip moment, minimum": ("Hip moment", LEAST, 20, 80),
    "knee moment, maximum": ("Knee moment", MOST, 0, 60),
    "knee moment, minimum": ("Knee moment", LEAST, 0, 60),
    "ankle moment, maximum": ("Ankle moment", MOST, 0, 70),
    "ankle power, maximum": ("Ankle power", MOST, 0, 70),
    "vertical force, maximum": (FORCE, MOST, 0, 70),
}


@dataclass(frozen=True)
class Gait:
    """Strides of both sides."""

    curves: Mapping[str, Mapping[str, Floats]]  # (S, 101), by the names of `UNITS` and side
    stride_time: Mapping[str, Floats]  # (S,) s, by side
    speed: float  # m/s

    def mean(self, name: str, side: str) -> Floats:
        """The mean stride (101,) of a curve."""
        return np.asarray(self.curves[name][side].mean(axis=0))

    @property
    def tilt(self) -> float:
        """Mean tilt of the pelvis forwards, deg."""
        return float(np.mean([self.mean(TILT, side).mean() for side in SIDES]))

    @property
    def points(self) -> dict[str, Floats]:
        """Numbers of each stride (S,), by name with the side in front, and of the whole gait."""
        times = np.concatenate([self.stride_time[side] for side in SIDES])
        found = {"speed": np.array([self.speed]), "stride time": times, "stride length": self.speed * times}
        for side in SIDES:
            if FORCE in self.curves:
                found[f"{side} stance"] = 100.0 * (self.curves[FORCE][side] > LOADED).mean(axis=1)
            for name, (curve, end, first, last) in POINTS.items():
                if curve in self.curves:
                    found[f"{side} {name}"] = np.asarray(end(self.curves[curve][side][:, first : last + 1], axis=1))
        return found


def unit_of(point: str) -> str:
    """Unit of a number of `Gait.points`."""
    whole = {"speed": "m/s", "stride time": "s", "stride length": "m", "cost of transport": "J/(kg m)"}
    if point in whole:
        return whole[point]
    name = point.partition(" ")[2]
    return UNITS[POINTS[name][0]] if name in POINTS else "% of the cycle"


def gait_of(recording: Recording, scene: Scene, cycles: Mapping[str, Strides], speed: float) -> Gait:
    """The gait of a motion over its strides.

    Args:
        scene: without free parameters. cycles: of both sides. speed: over the ground, m/s.

    Raises:
        Error: no hip, knee and ankle.
    """
    found = gait_curves(recording, scene, dict(cycles))
    if ANGLES[0] not in found:
        raise Error(f"{scene.name} has no legs with hip, knee and ankle")
    wanted = {name: found[name].sides for name in UNITS if name in found and _known(found[name].sides)}
    times = {side: np.array([end - begin for begin, end in cycles[side]]) for side in SIDES}
    return Gait(wanted, times, speed)


def _known(sides: Mapping[str, Floats]) -> bool:
    """Whether a curve has values that are not all zero, as those of forces that nobody measured are."""
    return all(np.isfinite(rows).all() and np.any(rows != 0.0) for rows in sides.values())


def pooled(gaits: list[Gait]) -> Gait:
    """Strides of several motions of one person; curves that all of them have.

    The speed is the mean, each motion counting as it has strides.
    """
    names = [name for name in gaits[0].curves if all(name in one.curves for one in gaits)]
    curves = {
        name: {side: np.concatenate([one.curves[name][side] for one in gaits]) for side in SIDES} for name in names
    }
    times = {side: np.concatenate([one.stride_time[side] for one in gaits]) for side in SIDES}
    counts = [sum(len(one.stride_time[side]) for side in SIDES) for one in gaits]
    return Gait(curves, times, float(np.average([one.speed for one in gaits], weights=counts)))
