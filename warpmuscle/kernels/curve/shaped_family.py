"""A family of curves with numbers of each muscle's own, and shapes that several families have."""

from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.curve.millard import hermite
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import CurveRow


@wp.struct
class ShapedCurves:
    """The curves of one muscle."""

    row: CurveRow
    table: wp.array[wp.vec2]  # see `curve_tables`


class ShapedFamily(NamedTuple):
    """The curves of a family, Warp functions; each takes the `ShapedCurves` of a muscle first."""

    active: Any  # (curves, length) -> force
    passive: Any  # (curves, length) -> force
    velocity: Any  # (curves, speed, activation) -> multiplier and slope
    tendon: Any  # (curves, strain over that at f_max) -> force and slope
    shortest: float | None = None  # l_opt, of a fibre; None: its row has a bound


@func
def looked_up(curves: ShapedCurves, x: float, place: wp.vec3i) -> wp.vec2:
    """Value and slope at x of a curve in the muscle's table, straight beyond its ends.

    Args:
        place: of the curve, see `curve_tables.places_of`.
    """
    head = curves.row.table + place[0]
    ends = curves.table[head]
    scale = float(place[2]) / (ends[1] - ends[0])
    inside = wp.clamp(x, ends[0], ends[1])
    position = (inside - ends[0]) * scale
    i = wp.min(int(position), place[2] - 1)
    s = position - float(i)
    first = curves.row.table + place[1] + i
    a = curves.table[first]
    b = curves.table[first + 1]
    return hermite(a, b, s, scale, x - inside)


@func
def exponential(curves: ShapedCurves, length: float) -> float:
    """Passive force of Thelen and of De Groote, (exp(k (l - 1)/strain) - floor) scale."""
    rise = wp.exp(curves.row.passive_rate * (length - 1.0)) - curves.row.passive_floor
    return wp.max(rise, 0.0) * curves.row.passive_scale
