"""Curves through knots of a muscle's own, and Schutte's force over speed: OpenSim's Schutte1993Muscle_Deprecated.

Schutte's muscle has a fibre with damping B, whose speed over one optimal length in its `time_scale` follows from the
force P = (tendon/cos(pennation) - passive) by a quadratic equation for each of shortening and lengthening. Solved for
P at an activation times active force A, they are P = A f(v) + B v with the hyperbolas below (Schutte 1993; OpenSim 4.6,
Schutte1993Muscle_Deprecated::calcFiberVelocity, with kv = 0.15, slope_k = 0.13 and fmax = 1.4).
"""

import numpy as np
import warp as wp

from warpmuscle.kernels.curve.curve_tables import places_of, put_curve
from warpmuscle.kernels.curve.shaped_family import ShapedCurves, ShapedFamily, looked_up
from warpmuscle.kernels.functions import func

SHORTEST = 1.0e-4  # of l_opt, as Thelen's
SHAPE, LONGEST = 0.15, 1.4  # kv and fmax
STEEP = 0.13 * SHAPE / (1.0 + SHAPE)  # s, a speed
INTERVALS = {"active": 1024, "passive": 1024, "tendon": 512, "velocity": 256}
PLACES, SIZE = places_of(INTERVALS)


def table_of(curves: dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]) -> np.ndarray:
    """Ends of the curves, then their values and slopes times knot distance, (SIZE, 2); see `PLACES`.

    Args:
        curves: x at equal distances, one more than `INTERVALS` says, with values and slopes there; some may be absent.
    """
    table = np.zeros((SIZE, 2))
    table[: len(INTERVALS), 1] = 1.0  # of those that are absent
    for name, (x, value, slope) in curves.items():
        put_curve(table, PLACES[name], x, value, slope)
    return table


@func
def spline_active(curves: ShapedCurves, length: float) -> float:
    """Active force in the muscle's table, not below 0."""
    return wp.max(looked_up(curves, length, wp.static(PLACES["active"]))[0], 0.0)


@func
def spline_passive(curves: ShapedCurves, length: float) -> float:
    """Passive force in the muscle's table."""
    return looked_up(curves, length, wp.static(PLACES["passive"]))[0]


@func
def schutte_velocity(speed: float) -> wp.vec2:
    """Schutte's multiplier and its slope."""
    if speed <= 0.0:
        part = 1.0 / (1.0 - speed * wp.static(1.0 / SHAPE))
        return wp.vec2((1.0 + speed) * part, wp.static(1.0 + 1.0 / SHAPE) * part * part)
    part = 1.0 / (speed + STEEP)
    return wp.vec2((LONGEST * speed + STEEP) * part, wp.static((LONGEST - 1.0) * STEEP) * part * part)


@func
def spline_velocity(curves: ShapedCurves, speed: float, activation: float) -> wp.vec2:
    """Schutte's multiplier, or that in the table of a muscle whose shape of hyperbolas is 0."""
    if curves.row.velocity_shape > 0.0:
        return schutte_velocity(speed)
    return looked_up(curves, speed, wp.static(PLACES["velocity"]))


@func
def spline_tendon(curves: ShapedCurves, x: float) -> wp.vec2:
    """Tendon force in the muscle's table, none of a slack one, and its slope."""
    if x < 0.0:
        return wp.vec2(0.0, 0.0)
    return looked_up(curves, x, wp.static(PLACES["tendon"]))


FAMILY = ShapedFamily(spline_active, spline_passive, spline_velocity, spline_tendon, SHORTEST)
