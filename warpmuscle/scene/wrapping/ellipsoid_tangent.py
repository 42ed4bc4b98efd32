"""Where OpenSim 4.6 has a path touch an ellipsoid (WrapEllipsoid): a search that may end at the other tangent.

It looks for a place r and a number d with which four things are 0: how far r is from the plane of the path, by how
much it misses the ellipsoid, and how far r and the end of the segment are from the tangent plane with offset d. Steps
are damped least squares (Levenberg and Marquardt); of a step that helps, ever more is taken while that helps.
"""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats

FOUND = 1.0e-8  # sum of squares of what is to be 0
LOST = 0.1  # the same where the search has found nothing
ON_IT = 1.0e-4  # by which the squared distance of an end on the unit sphere may differ from 1
ENDLESS = 1.0e12  # of the same, from which it does not come back
STEPS, TRIES = 50, 1000
DAMPING = 0.01  # at first
PART = 1.0 / 16.0  # of a full step that is taken
STRAIGHT = 0.1  # cosine between the ways to the place and to the middle from which steps are shorter, ...
SHORTER = 100  # by 1 less this power of it


def tangent_of(end: Floats, start: Floats, radii: Floats, normal: Floats, through: Floats) -> Floats | None:
    """The place (3,) that the search finds for an end of a segment, from a place on the ellipsoid on; None: it is lost.

    Args:
        end, start: (3,) in the axes of the ellipsoid, in numbers with which its radii are 1 on average.
        normal, through: (3,) of the plane of the path, and a place in it.
    """
    square, level = radii**2, -float(normal @ through)
    if abs(float(np.sum(end**2 / square)) - 1.0) < ON_IT:
        return end

    def off(x: Floats) -> Floats:
        out = 2.0 * x[:3] / square
        on = float(np.sum(x[:3] ** 2 / square)) - 1.0
        return np.array([normal @ x[:3] + level, on, out @ x[:3] + x[3], out @ end + x[3]])

    x = np.append(start, -2.0 * float(np.sum(start**2 / square)))
    missed = off(x)
    now = before = float(missed @ missed)
    damping = DAMPING
    for _ in range(STEPS):
        if now <= FOUND or not now < ENDLESS:
            break
        slopes = np.zeros((4, 4))
        slopes[:3] = np.column_stack([normal, 2.0 * x[:3] / square, 4.0 * x[:3] / square, 2.0 * end / square])
        slopes[3, 2:] = 1.0
        share, downward, squares = _share(x[:3], end), -slopes @ missed, slopes @ slopes.T
        step = np.zeros(4)
        for _ in range(TRIES):
            if now < before:
                break
            if not (now < ENDLESS and damping < ENDLESS):
                return None
            damped = squares + np.diag(damping * np.diag(squares))
            step = share * PART * (np.linalg.pinv(damped) @ downward)
            x = x + step
            missed = off(x)
            before, now, damping = now, float(missed @ missed), 4.0 * damping
        damping, more = damping / 8.0, 0.5
        for _ in range(TRIES):
            if now > before or not now < ENDLESS:
                break
            more *= 2.0
            x = x + step * more
            missed = off(x)
            before, now = now, float(missed @ missed)
        x = x - step * more
        missed = off(x)
        now = before = float(missed @ missed)
    return x[:3] if now <= LOST else None


def _share(place: Floats, end: Floats) -> float:
    """How much of a step is taken: less, the more the place lies between the end and the middle."""
    way, inward = place - end, -end
    cosine = float(way @ inward) / max(float(np.linalg.norm(way) * np.linalg.norm(inward)), 1e-300)
    return 1.0 - cosine**SHORTER if cosine > STRAIGHT else 1.0
