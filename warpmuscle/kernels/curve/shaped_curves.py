"""Curves of OpenSim's muscles with numbers of each muscle's own, in the place of the curves of a whole scene.

Thelen's and De Groote's are closed forms of the numbers in a `CurveRow`. Millard's, and those through knots, are
tables, one for each set of numbers that a scene has, as `millard_tables` and `splines` make them. Functions of
`muscle.py` and of the terms are made anew with these curves, see `custom_curves`: what they call `model` is then
`ShapedCurves`, the curves of one muscle.
"""

from functools import cache, partial
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.curve import splines
from warpmuscle.kernels.curve.curve_sets import CURVES, SPLINE
from warpmuscle.kernels.curve.curves import MODULES
from warpmuscle.kernels.curve.shaped_family import ShapedCurves as ShapedCurves
from warpmuscle.kernels.curve.shaped_family import ShapedFamily
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, at

LARGEST_SPEED = 1.0e3  # of v_max, either way: OpenSim's fibres have no bound, and give way so fast where a path jumps
LARGEST_PASSIVE = 1.0e3  # of f_max: nor have their passive forces
FAMILIES: dict[int, ShapedFamily] = {  # by the number of their set
    CURVES[name]: module.FAMILY for name, module in MODULES.items() if hasattr(module, "FAMILY")
}
FAMILIES[SPLINE] = splines.FAMILY


class Shaped(NamedTuple):
    """What is compiled into a step of muscles with curves of their own."""

    families: tuple[int, ...]  # MILLARD, THELEN, DE_GROOTE, SPLINE: those that the muscles of a scene have
    cables: bool = False  # whether some are actuators or ligaments, see `cables.py`


@func
def shaped_curves(instance: int, m: int, model: ModelRef) -> ShapedCurves:
    """The curves of a muscle."""
    curves = ShapedCurves()
    curves.row = at(model.muscles.shape, instance, m)
    curves.table = model.muscles.curve_table
    return curves


def _force(number: int, one: Any, others: Any, result: Any = float) -> Any:
    """The Warp function (curves, x) of a force: that of one, or of the others for other numbers.

    Args:
        result: float, or wp.vec2 for a force with its slope.
    """

    @wp.func
    def force(model: ShapedCurves, x: float) -> result:
        if model.row.curves == number:
            return one(model, x)
        return others(model, x)

    return force


def _multiplier(number: int, one: Any, others: Any) -> Any:
    """The same of the force-velocity multiplier."""

    @wp.func
    def multiplier(model: ShapedCurves, speed: float, activation: float) -> wp.vec2:
        if model.row.curves == number:
            return one(model, speed, activation)
        return others(model, speed, activation)

    return multiplier


def _choice(shaped: Shaped, field: str, either: Any) -> Any:
    """The Warp function of a curve of the families that are compiled in."""
    *first, last = shaped.families
    chosen = getattr(FAMILIES[last], field)
    for number in reversed(first):
        chosen = either(number, getattr(FAMILIES[number], field), chosen)
    return chosen


@cache
def shaped_functions(shaped: Shaped) -> dict[str, Any]:
    """What stands in for functions and constants of `curves.py` and `muscle.py`, by name."""
    active, passive = _choice(shaped, "active", _force), _choice(shaped, "passive", _force)
    velocity = _choice(shaped, "velocity", _multiplier)
    tendon = _choice(shaped, "tendon", partial(_force, result=wp.vec2))

    @wp.func
    def force_velocity(model: ShapedCurves, speed: float, activation: float) -> float:
        return velocity(model, speed, activation)[0]

    @wp.func
    def tendon_force_slope(model: ShapedCurves, strain: float) -> wp.vec2:
        rate = model.row.tendon_rate
        force = tendon(model, strain * rate)
        return wp.vec2(force[0], force[1] * rate)

    @wp.func
    def tendon_force_strain(model: ShapedCurves, strain: float) -> float:
        return tendon_force_slope(model, strain)[0]

    found = {
        "active_force_length": active,
        "passive_force_length": passive,
        "force_velocity_slope": velocity,
        "force_velocity": force_velocity,
        "tendon_force_slope": tendon_force_slope,
        "tendon_force_strain": tendon_force_strain,
        "curves_of": shaped_curves,
        "LARGEST_SPEED": LARGEST_SPEED,
        "FASTEST_STRETCH": LARGEST_SPEED,
        "LARGEST_PASSIVE": LARGEST_PASSIVE,
    }
    bounds = [bound for number in shaped.families if (bound := FAMILIES[number].shortest) is not None]
    if bounds:
        found["SHORTEST_FIBRE"] = min(bounds)  # other families have a bound of their own in their row
    return found
