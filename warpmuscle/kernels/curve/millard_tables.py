"""Tables of Millard's curves with other numbers than the defaults, as `shaped_curves` reads them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpmuscle.kernels.curve.curve_tables import places_of, put_curve
from warpmuscle.kernels.curve.millard import Knots, sampled

INTERVALS = {"active": 256, "passive": 64, "shortening": 64, "lengthening": 64, "tendon": 64}
PLACES, SIZE = places_of(INTERVALS)


class Numbers(NamedTuple):
    """What a table is made of, see `scene.MillardCurves`; slopes and strains are those in use."""

    active_from: float
    active_bend: float
    active_until: float
    active_slope: float
    active_least: float
    shortening_end_slope: float
    shortening_slope: float
    isometric_slope: float
    lengthening_slope: float
    lengthening_end_slope: float
    lengthening_force: float
    shortening_curviness: float
    lengthening_curviness: float
    passive_slack: float
    passive_strain: float
    passive_low_slope: float
    passive_slope: float
    passive_curviness: float
    tendon_slope: float  # per strain over that at f_max
    tendon_toe_force: float
    tendon_curviness: float


def active_knots(n: Numbers) -> Knots:
    """Active force over fibre length, from `active_from` over a bend and a plateau of 0.1 to `active_until`."""
    low, bend, high, plateau = n.active_from, n.active_bend, n.active_until, 0.05
    shoulder = 1.0 - n.active_slope * (1.0 - plateau - bend)
    steep = ((low + bend) / 2, shoulder / 2, 1.25 * shoulder / (bend - low))
    shallow = ((bend + 1.0 - plateau) / 2, (1.0 + shoulder) / 2, n.active_slope)
    falling = ((1.0 + plateau + high) / 2, 0.5, -1.0 / (high - 1.0 - 2 * plateau))
    return [(low, n.active_least, 0.0), steep, shallow, (1.0, 1.0, 0.0), falling, (high, n.active_least, 0.0)]


def passive_knots(n: Numbers) -> Knots:
    """Passive force over fibre length, 1 at `passive_strain`."""
    zero, one = 1.0 + n.passive_slack, 1.0 + n.passive_strain
    toe = min(0.1 / n.passive_slope, 0.1 * (one - zero))
    return [
        (zero, 0.0, 0.0),
        (zero + toe, n.passive_low_slope * toe / 2, n.passive_low_slope),
        (one, 1.0, n.passive_slope),
    ]


def tendon_knots(n: Numbers) -> Knots:
    """Tendon force over its strain, which is 1 at f_max: straight from `tendon_toe_force`."""
    end = 1.0 + (n.tendon_toe_force - 1.0) / n.tendon_slope
    middle = 1.0 + (n.tendon_toe_force / 2 - 1.0) / n.tendon_slope
    foot = end / 10
    rise = n.tendon_toe_force / 2 / (middle - foot)
    return [
        (0.0, 0.0, 0.0),
        ((foot + middle) / 2, rise * (middle - foot) / 2, rise),
        (end, n.tendon_toe_force, n.tendon_slope),
    ]


def velocity_knots(n: Numbers) -> tuple[Knots, Knots]:
    """Force over speed, of shortening and of lengthening."""
    low = 0.05 * (n.shortening_slope + n.shortening_end_slope)
    high = n.lengthening_force - 0.05 * (n.lengthening_slope + n.lengthening_end_slope)
    middle = (0.0, 1.0, n.isometric_slope)
    shortening = [(-1.0, 0.0, n.shortening_end_slope), (-0.9, low, n.shortening_slope), middle]
    lengthening = [
        middle, (0.9, high, n.lengthening_slope), (1.0, n.lengthening_force, n.lengthening_end_slope)
    ]  # fmt: skip
    return shortening, lengthening


def table_of(n: Numbers) -> np.ndarray:
    """Ends of all curves, then their values and slopes times knot distance, (SIZE, 2); see `PLACES`."""
    shortening, lengthening = velocity_knots(n)
    curves = {
        "active": (active_knots(n), 1.0),
        "passive": (passive_knots(n), n.passive_curviness),
        "shortening": (shortening, n.shortening_curviness),
        "lengthening": (lengthening, n.lengthening_curviness),
        "tendon": (tendon_knots(n), n.tendon_curviness),
    }
    table = np.zeros((SIZE, 2))
    for name, (knots, curviness) in curves.items():
        x = np.linspace(knots[0][0], knots[-1][0], INTERVALS[name] + 1)
        put_curve(table, PLACES[name], x, *sampled(knots, [curviness] * (len(knots) - 1), x))
    return table
