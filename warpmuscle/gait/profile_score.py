"""Gait Profile Score: how far the angles of a gait are from people's, in degrees, as clinics report it.

The score of a variable is the root mean square of its difference from people's mean over the cycle, that of several
variables the root of the mean of their squares (Baker et al. 2009, Gait & Posture 30:265). Clinics take nine variables.
Five of them have a norm here: hip, knee and ankle in the sagittal plane (Fukuchi 2018), obliquity and rotation of the
pelvis (Pinzone 2014). The tilt of the pelvis is a matter of where markers are; of the hip in the other planes, and of
how the foot points, nothing is known here. So scores compare gaits with each other rather than with clinics'.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.gait.curves import Curves, mean_of
from warpmuscle.gait.cycles import PERCENT
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.scene.people.fukuchi import WALK
from warpmuscle.scene.people.pinzone import PELVIS

LEAST_DIFFERENCE, DEVIATION = 1.6, 1.4  # deg: that matters in clinics; SD of healthy children (Baker 2012, 35:612)
OF_PELVIS = ("Pelvis obliquity", "Pelvis rotation")
Scores = dict[str, dict[str, float]]  # deg, by variable and side


def people() -> dict[str, Floats]:
    """Means (101,) of people, deg, by variable."""
    norms = {**WALK, **{name: PELVIS[name] for name in OF_PELVIS}}
    return {name: norm.mean(PERCENT) for name, norm in norms.items()}


def variable_scores(curves: Mapping[str, Curves]) -> Scores:
    """Scores of the variables that a body has, of the mean curve of each side, of `gait.curves.gait_curves`."""
    return {
        name: {side: variable_score(mean_of(curves[name].sides[side]), norm) for side in SIDES}
        for name, norm in people().items()
        if name in curves
    }


def variable_score(curve: Floats, norm: Floats) -> float:
    """Root mean square of the difference of a curve (101,) from a norm (101,) over the cycle."""
    return float(np.sqrt(np.mean(np.square(curve - norm)[:-1])))


def profile_scores(scores: Scores) -> dict[str, float]:
    """Score of each side, and of "both", in which the pelvis counts once, by the left foot's cycles; none of none."""
    if not scores:
        return {}
    found = {side: _root_mean_square([of_sides[side] for of_sides in scores.values()]) for side in SIDES}
    right = [of_sides["right"] for name, of_sides in scores.items() if name not in OF_PELVIS]
    return found | {"both": _root_mean_square([of_sides["left"] for of_sides in scores.values()] + right)}


def _root_mean_square(scores: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(scores))))
