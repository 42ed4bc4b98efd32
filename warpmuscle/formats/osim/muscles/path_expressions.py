"""OpenSim's ExpressionBasedPathForce: a tension that is an expression of a path's stretch and speed, as a ligament."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.limits import GREATEST_NUMBER
from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.functions import Function, resampled
from warpmuscle.scene.expressions.parse import BadExpression, evaluate, parse

VARIABLES = ("s", "ldot")  # stretch beyond the length at rest, m, and speed of lengthening, m/s
LONGEST = 2.0  # m, the greatest stretch
SPEEDS = (-0.7, -0.1, 0.2, 1.3)  # m/s, at which it is looked at
STRETCHES = 101
SAME = 1.0e-6  # of the tension
SMALLEST = 1.0e-3  # m, the unit of length of a path that is at rest at 0


class PathTension(NamedTuple):
    """A tension as a ligament has it."""

    unit: float  # m
    function: Function  # N, of the length over that unit
    dissipation: float  # s/m
    lost: str  # what of it is not kept; empty if it is exact


def path_tension(element: Element, text: Element, rest: float, clamped: bool) -> PathTension:
    """The tension of a path that is at rest at a length, m.

    Args:
        text: the element of the expression. clamped: whether a path that is shorter is not stretched.

    Raises:
        SceneError: the text is no expression of these variables, or has no number at some stretch.
    """
    if rest < 0.0:
        element.fail(f"its resting_length must not be negative, is {rest:g}")
    try:
        program = parse("".join(text.text.split()), VARIABLES)
    except BadExpression as error:
        text.fail(str(error))

    def tension(stretch: Floats, speed: float) -> Floats:
        return np.asarray(evaluate(program, {"s": stretch, "ldot": np.float64(speed)}, {})) + np.zeros_like(stretch)

    stretches = np.linspace(0.0, LONGEST, STRETCHES)
    still = tension(stretches, 0.0)
    if not np.all(np.abs(still) <= GREATEST_NUMBER):
        text.fail(f"it has no number at some stretch from 0 to {LONGEST:g} m")
    dissipation, lost = _dissipation(still, np.stack([tension(stretches, speed) for speed in SPEEDS]))
    if np.any(still < 0.0):
        lost.append("pushes where it is negative, which a path here does not")
    shorter = np.zeros(1) if clamped else np.linspace(-rest, 0.0, STRETCHES)
    if rest > 0.0 and np.any(tension(shorter, 0.0) != 0.0):
        lost.append("pulls on paths that are shorter than at rest, too, which it does not here")
    unit = rest if rest > 0.0 else SMALLEST
    spline, _ = resampled(lambda s: np.maximum(tension(s, 0.0), 0.0), 0.0, LONGEST)
    x = (rest + np.array(spline.x)) / unit
    return PathTension(unit, replace(spline, x=tuple(map(float, x))), dissipation, " and ".join(lost))


def _dissipation(still: Floats, moving: Floats) -> tuple[float, list[str]]:
    """The share by which 1 m/s raises all tensions (n,), of those at `SPEEDS`, (speeds, n); and what else they do."""
    pulls = np.abs(still) > SAME * max(float(np.max(np.abs(still))), SAME)
    speeds = np.array(SPEEDS)[:, None]
    with np.errstate(all="ignore"):
        shares = (moving[:, pulls] - still[pulls]) / (still[pulls] * speeds)
    share = float(np.median(shares)) if shares.size else 0.0
    expected = still * (1.0 + share * speeds)
    near = np.abs(moving - expected) <= SAME * np.maximum(np.abs(expected), float(np.max(np.abs(still))))
    if share >= 0.0 and np.isfinite(share) and np.all(near):
        return (share if share > SAME else 0.0), []
    return 0.0, ["depends on speed otherwise than by a factor that rises with it, which is left out"]
