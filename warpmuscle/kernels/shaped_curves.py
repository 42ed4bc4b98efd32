"""Curves of OpenSim's muscles with numbers of each muscle's own, in the place of the curves of a whole scene.

Thelen's and De Groote's are closed forms of the numbers in a `CurveRow`. Millard's are tables, one for each set of
numbers that a scene has, as `millard_tables` makes them. Functions of `muscle.py` and of the terms are made anew with
these curves, see `custom_curves`: what they call `model` is then `ShapedCurves`, the curves of one muscle.
"""

import math
from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.curve_sets import DE_GROOTE, MILLARD, THELEN
from warpmuscle.kernels.curves import gaussian_active, groote_velocity, hyperbolic_velocity
from warpmuscle.kernels.millard import hermite
from warpmuscle.kernels.millard_tables import PLACES
from warpmuscle.kernels.structs import CurveRow, ModelRef, at

LARGEST_SPEED = 10.0  # of v_max, either way: OpenSim's fibres have no bound
LARGEST_PASSIVE = 1.0e3  # of f_max: nor have their passive forces
SHORTEST_THELEN = 1.0e-4  # of l_opt: OpenSim's Thelen fibres may shorten to nothing, but for their pennation
TOE = (
    0.99 * math.exp(3.0) / (1.66 * math.exp(3.0) - 0.67)
)  # strain where Thelen's tendon becomes straight, over that at f_max
FOOT = 0.33 / (math.exp(3.0) - 1.0)  # scale of Thelen's tendon below that


class Shaped(NamedTuple):
    """What is compiled into a step of muscles with curves of their own."""

    families: tuple[int, ...]  # MILLARD, THELEN, DE_GROOTE: those that the muscles of a scene have
    cables: bool = False  # whether some are actuators or ligaments, see `cables.py`


@wp.struct
class ShapedCurves:
    """The curves of one muscle."""

    row: CurveRow
    table: wp.array[wp.vec2]  # see `millard_tables.table_of`


@wp.func
def shaped_curves(instance: int, m: int, model: ModelRef) -> ShapedCurves:
    """The curves of a muscle."""
    curves = ShapedCurves()
    curves.row = at(model.muscles.shape, instance, m)
    curves.table = model.muscles.curve_table
    return curves


@wp.func
def looked_up(curves: ShapedCurves, x: float, place: wp.vec3i) -> wp.vec2:
    """Value and slope at x of a curve in the muscle's table, straight beyond its ends.

    Args:
        place: of the curve, see `millard_tables.PLACES`.
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


@wp.func
def fregly_active(length: float) -> float:
    """De Groote's active force with the constants of OpenSim 4.6, up to 5e-4 from those of `curves.groote_active`."""
    x = (length - 1.055033428970575) / (0.162384573599574 + 0.063303448465465 * length)
    y = (length - 0.716775413397760) / wp.max(-0.029947116970696 + 0.200356847296188 * length, 1.0e-3)
    z = (length - 1.0) / 0.353553390593274
    low = 0.433004984392647 * wp.exp(-0.5 * y * y) + 0.1 * wp.exp(-0.5 * z * z)
    return 0.8150671134243542 * wp.exp(-0.5 * x * x) + low


@wp.func
def exponential(curves: ShapedCurves, length: float) -> float:
    """Passive force of Thelen and of De Groote, (exp(k (l - 1)/strain) - floor) scale."""
    rise = wp.exp(curves.row.passive_rate * (length - 1.0)) - curves.row.passive_floor
    return wp.max(rise, 0.0) * curves.row.passive_scale


@wp.func
def thelen_velocity(curves: ShapedCurves, speed: float, activation: float) -> wp.vec2:
    """Thelen's hyperbolas, straight beyond multipliers 0 and straight_from lengthening_force; and the slope."""
    row = curves.row
    scale = 1.0 / (0.25 + 0.75 * activation)
    v = speed * scale
    inside = wp.clamp(v, -1.0, row.straight_speed)
    edge = hyperbolic_velocity(inside, row.velocity_shape, row.lengthening_force)
    return wp.vec2(edge[0] + edge[1] * (v - inside), edge[1] * scale)


@wp.func
def thelen_tendon(x: float) -> wp.vec2:
    """Thelen's tendon force and its slope, at a strain over that at f_max."""
    if x > TOE:
        slope = wp.static(0.67 / (1.0 - TOE))
        return wp.vec2(0.33 + slope * (x - TOE), slope)
    if x <= 0.0:
        return wp.vec2(0.0, 0.0)
    growth = wp.exp(x * wp.static(3.0 / TOE)) * FOOT
    return wp.vec2(growth - FOOT, growth * wp.static(3.0 / TOE))


@wp.func
def groote_tendon(x: float) -> wp.vec2:
    """De Groote's tendon force 0.2 (6^x - 1) and its slope, at a strain over that at f_max; none when slack."""
    if x <= 0.0:
        return wp.vec2(0.0, 0.0)
    rate = wp.static(math.log(6.0))
    growth = 0.2 * wp.exp(rate * wp.min(x, 4.0))
    return wp.vec2(growth - 0.2, rate * growth)


@cache
def shaped_functions(shaped: Shaped) -> dict[str, Any]:
    """What stands in for functions and constants of `curves.py` and `muscle.py`, by name."""
    only = shaped.families[0] if len(shaped.families) == 1 else -1
    millard, groote = MILLARD in shaped.families, DE_GROOTE in shaped.families

    @wp.func
    def active_force_length(model: ShapedCurves, length: float) -> float:
        if wp.static(millard) and (wp.static(only == MILLARD) or model.row.curves == MILLARD):
            return looked_up(model, length, wp.static(PLACES["active"]))[0]
        if wp.static(groote) and (wp.static(only == DE_GROOTE) or model.row.curves == DE_GROOTE):
            return fregly_active((length - 1.0) * model.row.active_width + 1.0)
        return gaussian_active(length, model.row.active_width)

    @wp.func
    def passive_force_length(model: ShapedCurves, length: float) -> float:
        if wp.static(millard) and (wp.static(only == MILLARD) or model.row.curves == MILLARD):
            return looked_up(model, length, wp.static(PLACES["passive"]))[0]
        return exponential(model, length)

    @wp.func
    def force_velocity_slope(model: ShapedCurves, speed: float, activation: float) -> wp.vec2:
        if wp.static(millard) and (wp.static(only == MILLARD) or model.row.curves == MILLARD):
            if speed < 0.0:
                return looked_up(model, speed, wp.static(PLACES["shortening"]))
            return looked_up(model, speed, wp.static(PLACES["lengthening"]))
        if wp.static(groote) and (wp.static(only == DE_GROOTE) or model.row.curves == DE_GROOTE):
            return groote_velocity(speed)
        return thelen_velocity(model, speed, activation)

    @wp.func
    def force_velocity(model: ShapedCurves, speed: float, activation: float) -> float:
        return force_velocity_slope(model, speed, activation)[0]

    @wp.func
    def tendon_force_slope(model: ShapedCurves, strain: float) -> wp.vec2:
        rate = model.row.tendon_rate
        x = strain * rate
        force = wp.vec2(0.0, 0.0)
        if wp.static(millard) and (wp.static(only == MILLARD) or model.row.curves == MILLARD):
            force = looked_up(model, x, wp.static(PLACES["tendon"]))
        elif wp.static(groote) and (wp.static(only == DE_GROOTE) or model.row.curves == DE_GROOTE):
            force = groote_tendon(x)
        else:
            force = thelen_tendon(x)
        return wp.vec2(force[0], force[1] * rate)

    @wp.func
    def tendon_force_strain(model: ShapedCurves, strain: float) -> float:
        return tendon_force_slope(model, strain)[0]

    found = {
        "active_force_length": active_force_length,
        "passive_force_length": passive_force_length,
        "force_velocity_slope": force_velocity_slope,
        "force_velocity": force_velocity,
        "tendon_force_slope": tendon_force_slope,
        "tendon_force_strain": tendon_force_strain,
        "curves_of": shaped_curves,
        "LARGEST_SPEED": LARGEST_SPEED,
        "LARGEST_PASSIVE": LARGEST_PASSIVE,
    }
    if THELEN in shaped.families:
        found["SHORTEST_FIBRE"] = SHORTEST_THELEN  # others have a bound of their own in their row
    return found
