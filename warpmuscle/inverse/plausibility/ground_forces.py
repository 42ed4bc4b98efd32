"""Forces on bodies that cannot well be: too weak to carry the body, the wrong way round, far from where they act."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats

GRAVITY = 9.81  # m/s^2
CARRIED = (0.7, 1.4)  # parts of the weight, on the mean
TOUCHING = 20.0  # N, from which on a force counts
FAR = 0.3  # m, from a body's centre of mass: more than a foot is long
NEARER = 0.6  # of the distance from its own body, from which on another one is the nearer
SWINGS = 0.8, 1.0  # m/s, by which a foot is faster than another one, and at least, while it swings
SWINGING = 3  # frames, of which as many are looked at
EMPTY = 0.05  # parts of the weight, more than which no foot carries in the middle of its swing
TWISTED = 0.5  # m, the arm of a force that turns as its moment does; feet are 0.3 m long
AGAINST = -0.3  # correlation of an impulse with the speed of the root, below which their signs differ
PUSHING = 0.02  # parts of the weight, by which a horizontal force has to change to be looked at
WAYS = {"x": "sideways", "z": "forwards"}  # world axes


class Applied(NamedTuple):
    """A force on a body in n frames, and where that and others are, world axes."""

    name: str
    body: str
    force: Floats  # (n, 3) N
    point: Floats  # (n, 3) m
    moment: Floats  # (n, 3) N m, about that point
    places: dict[str, Floats]  # (n, 3) m, centres of mass of all bodies that forces act on
    speeds: dict[str, Floats]  # (n,) m/s, of these


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
        else:
            arm = float(np.abs(one.moment[on]).sum() / np.abs(one.force[on]).sum())
            if arm > TWISTED:
                notes.append(
                    f"the moment of {one.name!r} about its point is as that of its force at an arm of {arm:.3g} m, "
                    "more than a foot is long: moments are wrong by it; is it in N mm, or about another point?"
                )
    return notes


def swing_notes(forces: Sequence[Applied], mass: float) -> list[str]:
    """Forces on feet that swing, while another one stands, of a body of so much mass, kg."""
    notes = []
    for one in forces:
        own, others = one.speeds[one.body], [speed for body, speed in one.speeds.items() if body != one.body]
        if not others:
            continue
        swings = (own - np.min(others, axis=0) > SWINGS[0]) & (own > SWINGS[1])
        if np.count_nonzero(swings) < SWINGING:
            continue
        carried = float(np.median(np.linalg.norm(one.force[swings], axis=1)))
        if carried > EMPTY * mass * GRAVITY:
            notes.append(
                f"the force {one.name!r} is {carried:.0f} N while {one.body!r} swings and another foot stands: moments "
                "are wrong by it; are forces of two plates swapped, has one an offset, or is its time another?"
            )
    return notes


def push_notes(times: Floats, force: Floats, speeds: dict[str, Floats], mass: float) -> list[str]:
    """Horizontal parts of all forces (n, 3) together that slow down a body of so much mass, kg, as it goes faster.

    Args:
        times: (n,) s. speeds: of its root, (n,) m/s, by the world axes along which it moves; what is even over the
            trial does not count.
    """
    notes = []
    for axis, way in WAYS.items():
        own = force[:, "xyz".index(axis)]
        if axis not in speeds or len(times) < 4 or own.std() < PUSHING * mass * GRAVITY:
            continue
        impulse = np.concatenate([[0.0], np.cumsum(0.5 * (own[1:] + own[:-1]) * np.diff(times))])
        given, came = (_without_trend(times, one) for one in (impulse, speeds[axis]))
        if given @ came < AGAINST * np.sqrt((given @ given) * (came @ came)):
            notes.append(
                f"the loads push {way} when the body is slowed down, and the other way round: residuals and moments "
                "are wrong by it; is a sign or an axis another?"
            )
    return notes


def _without_trend(times: Floats, values: Floats) -> Floats:
    """Values (n,) less the line through them that fits best."""
    along, own = times - times.mean(), values - values.mean()
    return np.asarray(own - along * ((along @ own) / (along @ along)))
