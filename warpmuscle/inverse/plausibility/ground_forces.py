"""Forces on bodies that cannot well be: too weak to carry the body, the wrong way round, far from where they act."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats

GRAVITY = 9.81  # m/s^2
CARRIED = (0.7, 1.4)  # parts of the weight, on the mean
TOUCHING = 20.0  # N, from which on a force counts
FAR = 0.45  # m, from a body's centre of mass: more than a foot is long
NEARER = 0.6  # of the distance from its own body, from which on another one is the nearer


class Applied(NamedTuple):
    """A force on a body in n frames, and where that and others are, world axes."""

    name: str
    body: str
    force: Floats  # (n, 3) N
    point: Floats  # (n, 3) m
    places: dict[str, Floats]  # (n, 3) m, centres of mass of all bodies that forces act on


def weight_notes(force: Floats, mass: float) -> list[str]:
    """What all forces (n, 3) together carry of a body of so much mass, kg, on the mean."""
    share = float(force[:, 1].mean()) / (mass * GRAVITY)
    if CARRIED[0] <= share <= CARRIED[1]:
        return []
    if share < 0.0:
        return [
            f"the loads pull the body down, on the mean by {-share:.1%} of its weight: the ground's force on a foot "
            "points up the y axis; signs or axes are others here"
        ]
    return [
        f"the loads carry {share:.3g} times the model's weight on the mean: the rest acts at the root, and moments of "
        "the legs are wrong by it; are units, axes and plates complete?"
    ]


def place_notes(forces: Sequence[Applied]) -> list[str]:
    """Forces that act far from their bodies, or nearer to the body of another force."""
    notes = []
    for one in forces:
        on = np.linalg.norm(one.force, axis=1) > TOUCHING
        if not on.any():
            continue
        away = {body: float(np.median(np.linalg.norm(place[on] - one.point[on], axis=1)))
                for body, place in one.places.items()}  # fmt: skip
        own, nearest = away[one.body], min(away, key=lambda body: away[body])
        if nearest != one.body and away[nearest] < NEARER * own:
            notes.append(
                f"the force {one.name!r} on {one.body!r} acts {own:.2g} m from it, nearer to {nearest!r}: are the "
                "bodies of two plates swapped?"
            )
        elif own > FAR:
            notes.append(
                f"the force {one.name!r} acts {own:.3g} m away, far from {one.body!r}: moments are wrong by that arm; "
                "are units, axes and the times of both files right?"
            )
    return notes
