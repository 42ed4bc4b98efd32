"""Tables of curves that go through knots of a muscle's own, as `kernels.curve.splines` reads them."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.kernels.curve.splines import INTERVALS, table_of
from warpmuscle.scene import Spline, SplineCurves
from warpmuscle.scene.joints.displacement import rates

REACH = {"active": (0.0, 2.5), "passive": (0.0, 2.5), "tendon": (0.0, 1.0), "velocity": (-1.5, 1.5)}
STRONGEST = 5.0  # of f_max: a tendon, up to which its curve is tabulated; it goes on straight
SEARCHED = 4001  # strains, among which that is looked for


def spline_table(shape: SplineCurves) -> Floats:
    """The table of a shape, (SIZE, 2)."""
    given = {name: curve for name in INTERVALS if (curve := getattr(shape, name)) is not None}
    columns = {name: sampled(curve, *span(name, curve), INTERVALS[name]) for name, curve in given.items()}
    return np.asarray(table_of(columns))


def sampled(curve: Spline, low: float, high: float, intervals: int) -> tuple[Floats, Floats, Floats]:
    """Places at equal distances between low and high, and a curve's values and slopes there."""
    x = np.linspace(low, high, intervals + 1)
    value, slope = rates(curve.displacement, x)[:2]
    return x, value, slope


def span(name: str, curve: Spline) -> tuple[float, float]:
    """Between which places a curve is tabulated: within reach of a fibre, and of a tendon up to a force."""
    low, high = REACH[name]
    if name != "tendon":
        return low, high
    x, value, _ = sampled(curve, low, high, SEARCHED - 1)
    beyond = np.flatnonzero(value >= STRONGEST)
    return low, float(x[beyond[0]]) if len(beyond) else high
