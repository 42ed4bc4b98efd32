"""How far the angles of a gait are from those of people who do the same, at the same speed.

Published means differ from each other, so that no single one is a judge: what counts is the distance from the span of
them all, in the mean of their standard deviations, 0 inside the span.

A norm is of one speed. Those of walking are moved to the speed of the gait by the trend of the extremes over five
classes of dimensionless speed v / sqrt(g L) (Schwartz, Rozumalski, Trost 2008, J. Biomech. 41:1639), as differences
from the class of free speed: they are of children, but no other trend of all three angles is at hand. Between classes
the trend is linear, beyond the slowest and the fastest nothing moves any more. Between the extremes it follows smooth
steps; where no trend is known, at the smallest angles of the knee and at the ankle's landing and swing, nothing moves.
The norm of running, of 2.5 m/s, moves as the same runners' angles do up to 3.5 m/s.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number, first_row
from warpmuscle.gait.cycles import PERCENT
from warpmuscle.gait.measures import feet_of
from warpmuscle.scene import Character, Scene
from warpmuscle.scene.anatomy import joint_place, leg_joints
from warpmuscle.scene.geometry import contact_points
from warpmuscle.scene.norms import RUNNING, WALKING, Band, GaitNorm, Norm

GRAVITY = 9.81  # m/s^2, of the people measured
# Dimensionless speed in the middle of each class. They are 0.136 wide; the outer ones, which are open, count as such.
CLASSES = (0.159, 0.295, 0.432, 0.568, 0.704)
FREE = 2  # the class of comfortable walking
# Extremes by class: percent of the cycle, and the angle, deg, of the classes. None where it stays the same.
TRENDS: dict[str, tuple[tuple[float, tuple[float, ...] | None], ...]] = {
    "Hip flexion": ((52.0, (1.5, -2.4, -5.8, -8.0, -7.3)), (90.0, (32.0, 34.3, 36.7, 39.9, 45.0))),
    "Knee flexion": (
        (12.0, (7.9, 12.7, 19.3, 23.7, 22.7)), (39.0, None), (72.0, (44.7, 55.2, 59.1, 61.0, 61.9)), (97.0, None),
    ),
    "Ankle dorsiflexion": (
        (5.0, None), (46.0, (13.1, 13.8, 11.8, 8.9, 7.9)), (64.0, (-5.7, -13.6, -19.8, -22.0, -21.9)), (85.0, None),
    ),
}  # fmt: skip


def dimensionless_speed(speed: float, leg_length: float) -> float:
    """Speed over that of a pendulum's bob, v / sqrt(g L), of a speed in m/s and a leg's length in m."""
    return abs(speed) / math.sqrt(GRAVITY * max(leg_length, 1e-6))


def leg_length(scene: Scene) -> float:
    """Length of a numeric scene's left leg, m: from the hip over knee and ankle down to the sole of the foot.

    Raises:
        Error: no legs.
    """
    character, foot = scene.character, feet_of(scene)[0]
    joints = [character.joints[name] for name in leg_joints(scene, 0)]
    length = sum(math.dist(first_row(above.position_in_child), joint_place(below)) for above, below in pairwise(joints))
    return length + _height_over_sole(character, foot, first_number(joints[-1].position_in_child[1]))


def _height_over_sole(character: Character, foot: str, ankle: float) -> float:
    """Height of the ankle, at this y of the foot, over the lowest point of the foot, m."""
    points = [point for shape in character.bodies[foot].shapes for point in contact_points(shape)]
    return max((ankle - (float(place[1]) - float(radius)) for place, radius in points), default=0.0)


def trend(name: str, speed: float) -> Floats:
    """What an angle of the legs gains over the cycle (101,), deg, from free walking to a dimensionless speed."""
    points = []
    for percent, values in TRENDS[name]:
        gained = 0.0 if values is None else float(np.interp(speed, CLASSES, values)) - values[FREE]
        points.append((percent, gained))
    return Norm(tuple(points), 1.0, "deg").mean(PERCENT)


def norms_of(running: bool) -> tuple[GaitNorm, ...]:
    """The published norms that judge a run, or a walk."""
    return RUNNING if running else WALKING


def means_at(bands: Sequence[Band], shift: Floats | float = 0.0) -> tuple[Floats, Floats]:
    """Means (N, 101) and standard deviations (N, 101) of an angle in N norms over the cycle, moved by a trend."""
    means = np.array([band.mean(PERCENT) + shift for band in bands])
    return means, np.array([band.sd(PERCENT) for band in bands])


def outside_span(curve: Floats, means: Floats, sds: Floats) -> float:
    """Mean distance of a curve (101,) over the cycle from the span of means (N, 101), in the mean of the SDs there."""
    below, above = means.min(axis=0) - curve, curve - means.max(axis=0)
    distance = np.maximum(np.maximum(below, above), 0.0) / sds.mean(axis=0)
    return float(np.mean(distance[:-1]))


def from_norm(curve: Floats, mean: Floats, sd: Floats) -> float:
    """Mean distance of a curve (101,) over the cycle from the mean of one norm, in its standard deviation there."""
    return float(np.mean((np.abs(curve - mean) / sd)[:-1]))
