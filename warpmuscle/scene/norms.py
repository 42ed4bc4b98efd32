"""Norms of human gait to see a simulated one beside: key points of walking at a comfortable speed, and measured angles.

Between key points, the extremes of a norm's mean curve, a band follows smooth steps; it is as exact as they are. Which
norms judge a gait, and how they move with its speed, is in `likeness.py`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import leg_joints
from warpmuscle.scene.people.fukuchi import RUN, WALK
from warpmuscle.scene.people.pinzone_two import SEARCHED_ANGLES, SEARCHED_MOMENTS
from warpmuscle.scene.topology import Topology

SOURCE = "norm curves in SCONE Studio"
FORCE = "Vertical ground force"
NORM_TERMS = frozenset({"norms", "norm_force", "norm_moments"})  # of the objective, that compare with people
LEG_MOMENTS = ("Hip moment", "Knee moment", "Ankle moment")
LEG_ANGLES = ("Hip flexion", "Knee flexion", "Ankle dorsiflexion")
FLEXION = (-1.0, 1.0, -1.0)  # sign of a turn about x, which points to the left, that is flexion of hip, knee and ankle
BINS = 100  # of the gait cycle, in tables for kernels
PERCENT_OF_BIN = 100.0 * (np.arange(BINS) + 0.5) / BINS


@dataclass(frozen=True)
class Norm:
    """Mean and half-width of a quantity over the gait cycle, from the touch-down of a foot to its next."""

    points: tuple[tuple[float, float], ...]  # percent of the cycle and mean, in order
    half_width: float
    unit: str
    periodic: bool = True  # the last point leads on to the first; else the mean is 0 before and after

    def mean(self, percent: Floats) -> Floats:
        """Mean at these percents, of the same shape."""
        at, value = np.array(self.points).T
        if self.periodic:
            at = np.concatenate([[at[-1] - 100.0], at, [at[0] + 100.0]])
            value = np.concatenate([value[-1:], value, value[:1]])
        after = np.clip(np.searchsorted(at, percent), 1, len(at) - 1)
        part = np.clip((percent - at[after - 1]) / (at[after] - at[after - 1]), 0.0, 1.0)
        smooth = part * part * (3.0 - 2.0 * part)  # level at both ends, as at an extreme
        return np.asarray((1.0 - smooth) * value[after - 1] + smooth * value[after])

    def sd(self, percent: Floats) -> Floats:
        """The half-width of the band, which counts as a standard deviation, at these percents, of the same shape."""
        return np.full(np.shape(percent), self.half_width)


NORMS = {
    "Hip flexion": Norm(((1.0, 33.0), (52.0, -8.3), (87.0, 33.7)), 8.4, "deg"),
    "Knee flexion": Norm(((12.0, 19.4), (39.0, 7.2), (72.0, 63.4), (97.0, 3.8)), 5.3, "deg"),
    "Ankle dorsiflexion": Norm(((5.0, -6.5), (43.0, 12.5), (64.0, -19.9), (85.0, 2.7)), 3.9, "deg"),
    FORCE: Norm(
        ((0.0, 0.0), (15.0, 1.05), (31.0, 0.80), (49.0, 1.14), (64.0, 0.0)), 0.06, "body weights", periodic=False
    ),
}


class Band(Protocol):
    """Mean and standard deviation of a quantity over the gait cycle."""

    def mean(self, percent: Floats) -> Floats:
        """Mean at these percents, of the same shape."""
        ...

    def sd(self, percent: Floats) -> Floats:
        """Standard deviation at these percents, of the same shape."""
        ...


@dataclass(frozen=True)
class GaitNorm:
    """Angles of the legs of a group of people, by the names of `LEG_ANGLES`."""

    source: str
    what: str  # they did, and how fast
    angles: Mapping[str, Band]


@dataclass(frozen=True)
class MeanBand:
    """The mean of several bands."""

    bands: tuple[Band, ...]

    def mean(self, percent: Floats) -> Floats:
        """Mean of the means at these percents, of the same shape."""
        return np.asarray(np.mean([band.mean(percent) for band in self.bands], axis=0))

    def sd(self, percent: Floats) -> Floats:
        """Mean of the standard deviations at these percents, of the same shape."""
        return np.asarray(np.mean([band.sd(percent) for band in self.bands], axis=0))


KEY_POINTS = "key points"
WALKING = (
    GaitNorm(KEY_POINTS, "walking at a comfortable speed", {name: NORMS[name] for name in LEG_ANGLES}),
    GaitNorm("Fukuchi 2018", "walking at 1.26 m/s", WALK),
)
RUNNING = (GaitNorm("Fukuchi 2017", "running at 2.5 m/s", RUN),)
_PINZONE = GaitNorm("Pinzone 2014", "walking at their own speed, centre two", SEARCHED_ANGLES)
_BETWEEN = GaitNorm(
    "key points and Pinzone 2014",
    "walking at a comfortable speed, the mean of both",
    {name: MeanBand((NORMS[name], SEARCHED_ANGLES[name])) for name in LEG_ANGLES},
)
IMITATED = (*WALKING, _PINZONE, _BETWEEN, *RUNNING)


RUNNING_STANCE = 40.0  # % of the cycle, of people at 2.5 m/s
STANCE_FORCE, STANCE_FORCE_SLOPE = 1.4, 0.15  # mean while a runner's foot carries at 3 m/s, weights; s/m more
RUNNING_FORCE_BAND = 0.2  # body weights; its waves of impact are of this size


def is_run(source: str) -> bool:
    """Whether a norm of this name is of running."""
    return any(norm.source == source for norm in RUNNING)


def running_stance(speed: float) -> float:
    """Percent of the cycle in which a runner's foot carries, at a speed, m/s.

    The mean force of a stance grows from 1.4 weights at 3 m/s to 1.7 at 5 m/s (Munro et al. 1987, J. Biomech. 20:147),
    and two stances carry the weight of a cycle.
    """
    return 50.0 / (STANCE_FORCE + STANCE_FORCE_SLOPE * (speed - 3.0))


def running_force(percent: Floats, stance: float = RUNNING_STANCE) -> Floats:
    """Vertical force on a foot of a runner at percents of the cycle, body weights: half a sine over the stance, %.

    Its maximum carries the body over the whole cycle (Morin et al. 2005, J. Appl. Biomech. 21:167).
    """
    part = percent / stance
    return np.asarray(np.where(part < 1.0, np.pi / (4.0 * 0.01 * stance) * np.sin(np.pi * part), 0.0))


COMFORTABLE = 1.25  # m/s, of the key points of walking
GREATEST_SWING = 2.2  # of the force about the weight, at high speeds
STANCE = 62.0  # % of the cycle, of people who walk (Perry, Burnfield 2010)
STEEPNESS = 0.58  # of rise and fall: 0 are smooth steps, 1 quarters of a sine; so that two feet carry the body's weight


def walking_force(percent: Floats, speed: float) -> Floats:
    """Vertical force on a foot of a walker at percents of the cycle, body weights: key points, moved with the speed.

    Peaks and valley are as far from the body's weight as the speed squared says, as is the force that leads a body on
    an arc about the foot that carries it. Measured forces grow about so (Nilsson, Thorstensson 1989, Acta Physiol.
    Scand. 136:217). Before the first peak and after the second the force is steep where the foot touches, as measured
    forces are.
    """
    norm = NORMS[FORCE]
    swing = min((speed / COMFORTABLE) ** 2, GREATEST_SWING)
    (first, rise), valley, (last, fall) = ((at, 1.0 + swing * (value - 1.0)) for at, value in norm.points[1:-1])
    between = Norm(((first, rise), valley, (last, fall)), norm.half_width, norm.unit, periodic=False).mean(percent)
    loading, unloading = percent / first, (STANCE - percent) / (STANCE - last)
    return np.where(percent < first, rise * _edge(loading), np.where(percent > last, fall * _edge(unloading), between))


def _edge(part: Floats) -> Floats:
    """From 0 at 0 to 1, level, at 1; 0 before."""
    x = np.clip(part, 0.0, 1.0)
    return np.asarray(STEEPNESS * np.sin(0.5 * np.pi * x) + (1.0 - STEEPNESS) * x * x * (3.0 - 2.0 * x))


@dataclass(frozen=True)
class Reference:
    """Means of a measure of human walking, from the lowest to the highest of the groups measured."""

    low: float
    high: float
    source: str


_MURRAY = "Murray et al. 1964, 1970"
_CHUNG = "Chung 2010, 20 adults"  # J. NeuroEng. Rehabil. 7:9; SD 1.8, 1.4 and 2.9 degrees, at 1.2 m/s
REFERENCES = {
    "speed": Reference(1.27, 1.46, "Bohannon 1997"),
    "step length": Reference(0.66, 0.79, _MURRAY),
    "step width": Reference(0.071, 0.081, _MURRAY),
    "cadence": Reference(117.0, 117.0, _MURRAY),
    "flight": Reference(0.0, 0.0, "Perry, Burnfield 2010"),
    "double support": Reference(20.0, 24.0, "Perry, Burnfield 2010"),
    "sway of the centre of mass": Reference(3.9, 7.0, "Orendurff 2004, 1.6 and 0.7 m/s"),
    "bobbing of the centre of mass": Reference(2.7, 4.8, "Orendurff 2004, 0.7 and 1.6 m/s"),
    "maximum braking force": Reference(0.15, 0.18, "OpenSim's subject 01, two walks"),
    "maximum driving force": Reference(0.19, 0.20, "OpenSim's subject 01, two walks"),
    "travel of the centre of pressure": Reference(83.0, 83.0, "Lugade, Kaufman 2014"),
    "pelvis tilt, range": Reference(1.8, 2.1, "Pinzone 2014, two centres"),
    "pelvis obliquity, range": Reference(8.6, 10.3, "Pinzone 2014, two centres"),
    "pelvis rotation, range": Reference(9.7, 13.1, "Pinzone 2014, two centres"),
    "clearance in mid-swing": Reference(1.3, 1.3, "Winter 1992, Physical Therapy 72:45"),
    "arm swing, range": Reference(32.0, 32.0, "Murray 1967, Physical Therapy 47:272"),
    "trunk tilt, range": Reference(4.0, 4.0, _CHUNG),
    "trunk obliquity, range": Reference(3.3, 3.3, _CHUNG),
    "trunk rotation, range": Reference(6.9, 6.9, _CHUNG),
    "cost of transport": Reference(3.05, 3.51, "PLOS ONE 0168070, 0138154"),
}


def norm_table(scene: Scene, names: Topology, own: Floats | None = None) -> tuple[Floats, Floats, Integers]:
    """Sagittal angles of human legs over the gait cycle of each leg, for `kernels.objective.term_functions.norms`.

    They are the key points of walking, or, where the scene means a run, the measured angles of running, in their mean
    standard deviation over the cycle.

    Args:
        scene: with feet that have a hip, a knee and an ankle above them.
        own: (2, 3, BINS) degrees, of both legs' hips, knees and ankles, in place of people's means.

    Returns:
        Mean angles (BINS, bodies) of each body's joint in half-widths; (bodies,) half-widths per rad of a turn about x,
        0 for joints without a norm; and (bodies,) the leg that the body's joint belongs to, 0 left, 1 right.
    """
    bands = (RUNNING if scene.objective.gait == "run" else WALKING)[0].angles
    table, scale, sides = _table_of_legs(
        scene, names, {title: bands[title] for title in LEG_ANGLES}, own, float(np.degrees(1.0))
    )
    return table, scale, sides


def moment_table(scene: Scene, names: Topology, own: Floats | None = None) -> tuple[Floats, Floats]:
    """Sagittal moments of human legs per mass of the body, for `kernels.objective.term_functions.norm_moments`.

    They are those of one clinical centre; another one's judge gaits, see `gait.joint_moments`.

    Args:
        scene: with feet that have a hip, a knee and an ankle above them.
        own: (2, 3, BINS) N m/kg, of both legs' hips, knees and ankles, in place of people's means.

    Returns:
        Mean moments (BINS, bodies) about each body's joint in the mean standard deviation over the cycle; and (bodies,)
        standard deviations per N m/kg about the parent's x axis on the child, 0 for joints without a norm.
    """
    table, scale, _ = _table_of_legs(scene, names, {title: SEARCHED_MOMENTS[title] for title in LEG_MOMENTS}, own)
    return table, scale


def _table_of_legs(
    scene: Scene, names: Topology, norms: Mapping[str, Band], own: Floats | None, unit: float = 1.0
) -> tuple[Floats, Floats, Integers]:
    """Means (BINS, bodies) of both legs over their norms' mean spread, 1/spread with its sign, and legs (bodies,).

    Args:
        norms: of hip, knee and ankle. own: (2, 3, BINS), in place of the norms' means.
        unit: of the norms in one of what is compared with them.
    """
    assert scene.feet is not None
    bodies = len(names.bodies)
    table, scale, sides = np.zeros((BINS, bodies)), np.zeros(bodies), np.zeros(bodies, dtype=np.int32)
    for side in range(len(scene.feet)):
        for k, (norm, sign, joint) in enumerate(zip(norms.values(), FLEXION, leg_joints(scene, side), strict=True)):
            body, spread = names.body_of_joint(joint), float(norm.sd(PERCENT_OF_BIN).mean())
            table[:, body] = (norm.mean(PERCENT_OF_BIN) if own is None else own[side, k]) / spread
            scale[body] = unit * sign / spread
            sides[body] = side
    return table, scale, sides
