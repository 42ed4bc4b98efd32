"""Default curves of Millard 2013 as cubic Hermite tables, made from their published parameters when imported.

The source joins quintic Bezier sections with the shape of an elbow ("corners"). Solving these for their parameter in
every evaluation is slow, so values and slopes are tabulated in float64 at equal distances; between them the table is
within 2e-4 of the curve, in units of the largest isometric force.
"""

from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import warp as wp

from warpmuscle.kernels.functions import func

Knot = tuple[float, float, float]  # x, y, dy/dx at the joint of two sections
Knots = list[Knot]


class Quintic(NamedTuple):
    """What control points of a quintic Bezier curve, and their differences, are weighed with at its parameters."""

    values: np.ndarray  # (parameters, 6)
    rates: np.ndarray  # (parameters, 5)


def quintic(u: np.ndarray) -> Quintic:
    """Bernstein's polynomials at parameters u, 0 to 1."""
    w = 1.0 - u
    values = np.stack([w**5, 5 * u * w**4, 10 * u**2 * w**3, 10 * u**3 * w**2, 5 * u**4 * w, u**5], 1)
    return Quintic(values, np.stack([w**4, 4 * u * w**3, 6 * u**2 * w**2, 4 * u**3 * w, u**4], 1))


@cache
def fine_quintic() -> Quintic:
    """The same at those that tables are interpolated between, which all corners share."""
    return quintic(np.linspace(0.0, 1.0, 20001))


def corner(start: Knot, end: Knot, curviness: float, at: Quintic) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, y and dy/dx of a quintic Bezier corner between two knots (Millard 2013, appendix).

    Its inner control points lie twice each on the way to the intersection of the end tangents.
    """
    (x0, y0, slope0), (x1, y1, slope1) = start, end
    x = (y1 - y0 - x1 * slope1 + x0 * slope0) / (slope0 - slope1)
    crossing = np.array([x, y1 + (x - x1) * slope1])
    first, last = np.array([x0, y0]), np.array([x1, y1])
    part = 0.1 + 0.8 * curviness
    low, high = first + part * (crossing - first), last + part * (crossing - last)
    points = np.stack([first, low, low, high, high, last])
    value = at.values @ points
    rate = 5 * at.rates @ np.diff(points, axis=0)
    return value[:, 0], value[:, 1], rate[:, 1] / rate[:, 0]


def sampled(knots: Knots, curviness: list[float], x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values and slopes at x, between the first and last knot, of corners with a curviness each."""
    pieces = [corner(a, b, c, fine_quintic()) for (a, b), c in zip(pairwise(knots), curviness, strict=True)]
    along, value, slope = (np.concatenate(part) for part in zip(*pieces, strict=True))
    return np.interp(x, along, value), np.interp(x, along, slope)


def active_knots() -> Knots:
    """Active force over fibre length: zero at 0.4441 and 1.8123, shallow slope 0.8616 from 0.73 to the plateau."""
    low, transition, high, slope, plateau = 0.4441, 0.73, 1.8123, 0.8616, 0.05
    shoulder = 1.0 - slope * (1.0 - plateau - transition)
    steep = ((low + transition) / 2, shoulder / 2, 1.25 * shoulder / (transition - low))
    shallow = ((transition + 1.0 - plateau) / 2, (1.0 + shoulder) / 2, slope)
    falling = ((1.0 + plateau + high) / 2, 0.5, -1.0 / (high - 1.0 - 2 * plateau))
    return [(low, 0.0, 0.0), steep, shallow, (1.0, 1.0, 0.0), falling, (high, 0.0, 0.0)]


def passive_knots() -> Knots:
    """Passive force over fibre length: 1 at strain 0.7 with slope 2/0.7, slope 0.2 at low force."""
    strain, low_slope = 0.7, 0.2
    toe = 0.1 * min(strain / 2, strain)
    return [(1.0, 0.0, 0.0), (1.0 + toe, low_slope * toe / 2, low_slope), (1.0 + strain, 1.0, 2.0 / strain)]


def tendon_knots() -> Knots:
    """Tendon force over its strain: linear from 2/3 with slope 1.375/0.049, reaching 1 at strain 0.049."""
    strain, toe = 0.049, 2.0 / 3.0
    slope = 1.375 / strain
    end, middle = strain + (toe - 1.0) / slope, strain + (toe / 2 - 1.0) / slope
    foot = end / 10
    rise = toe / 2 / (middle - foot)
    return [(0.0, 0.0, 0.0), ((foot + middle) / 2, rise * (middle - foot) / 2, rise), (end, toe, slope)]


SHORTENING: Knots = [(-1.0, 0.0, 0.0), (-0.9, 0.0125, 0.25), (0.0, 1.0, 5.0)]
LENGTHENING: Knots = [(0.0, 1.0, 5.0), (0.9, 1.3925, 0.15), (1.0, 1.4, 0.0)]
CURVES = {  # knots, curviness of the sections, intervals of the table
    "active": (active_knots(), [1.0] * 5, 128),
    "passive": (passive_knots(), [0.75] * 2, 24),
    "shortening": (SHORTENING, [0.6] * 2, 32),
    "lengthening": (LENGTHENING, [0.9] * 2, 64),
    "tendon": (tendon_knots(), [0.5] * 2, 32),
}


def table() -> tuple[np.ndarray, dict[str, wp.vec4]]:
    """Values and slopes times knot distance (knots, 2) of all curves, and the place of each, see `tabulated`."""
    rows: list[np.ndarray] = []
    places: dict[str, wp.vec4] = {}
    for name, (knots, curviness, intervals) in CURVES.items():
        x = np.linspace(knots[0][0], knots[-1][0], intervals + 1)
        value, slope = sampled(knots, curviness, x)
        places[name] = wp.vec4(sum(map(len, rows)), intervals, x[0], x[-1])
        rows.append(np.stack([value, slope * (x[1] - x[0])], axis=1))
    return np.concatenate(rows), places


TABLE, PLACES = table()
NUMBERS = ", ".join(f"{number:.8e}f" for number in TABLE.ravel())


@wp.func_native(
    snippet=f"""
static const float table[] = {{{NUMBERS}}};
return wp::vec_t<2, wp::float32>(table[2 * i], table[2 * i + 1]);
"""
)
def knot(i: int) -> wp.vec2: ...


@func
def hermite(a: wp.vec2, b: wp.vec2, s: float, scale: float, beyond: float) -> wp.vec2:
    """Value and slope of the cubic between two knots, straight beyond an end of the curve.

    Args:
        a, b: values at the knots, and slopes times their distance. s: part of the way from a to b.
        scale: 1 over the distance. beyond: how far behind the end, 0 within the curve.
    """
    rise = b[0] - a[0]
    square = a[1] * -2.0 - b[1] + 3.0 * rise
    cube = a[1] + b[1] - 2.0 * rise
    value = a[0] + s * (a[1] + s * (square + s * cube))
    slope = (a[1] + s * (2.0 * square + s * 3.0 * cube)) * scale
    return wp.vec2(value + slope * beyond, slope)


@func
def tabulated(x: float, place: wp.vec4) -> wp.vec2:
    """Value and slope at x of a curve in the table, straight beyond its ends.

    Args:
        place: first knot of the curve, intervals between its knots, x of the first and of the last knot.
    """
    first = int(place[0])
    scale = place[1] / (place[3] - place[2])
    inside = wp.clamp(x, place[2], place[3])
    position = (inside - place[2]) * scale
    i = wp.min(int(position), int(place[1]) - 1)
    s = position - float(i)
    a = knot(first + i)
    b = knot(first + i + 1)
    return hermite(a, b, s, scale, x - inside)
