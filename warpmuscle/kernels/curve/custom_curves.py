"""Other curves in the place of a muscle model's: functions of muscles made anew with them.

Functions find each other by the names in their module. One that is made anew has the same source and sees other
functions under these names, and so do those that it calls; so what is compiled differs in the curves alone.
"""

from __future__ import annotations

from functools import cache
from types import FunctionType
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.curve.curves import functions_of
from warpmuscle.kernels.curve.shaped_curves import Shaped, ShapedCurves, shaped_functions
from warpmuscle.kernels.functions import gradient_of, known_gradient

SLOPE_STEP = 1.0e-3  # of v_max, to either side


class CustomCurves(NamedTuple):
    """Warp functions in the place of curves; None where those of the model stay."""

    active: Any = None  # (length over l_opt) -> force over f_max
    passive: Any = None  # the same
    velocity: Any = None  # (speed over v_max, positive when lengthening) -> multiplier, or wp.vec2 with its slope
    sloped: bool = False  # the latter


@cache
def replacements(own: CustomCurves | Shaped | None, curves: int | None = None) -> dict[str, Any]:
    """The functions and constants that other curves stand in for, by name; see `with_curves`."""
    if isinstance(own, Shaped):
        return shaped_functions(own)
    found = {} if curves is None else dict(functions_of(curves))
    return found if own is None else found | custom_functions(own)


@cache
def custom_functions(own: CustomCurves) -> dict[str, Any]:
    """Functions in the place of those of `curves.py`, by name, of the curves that are given."""
    active, passive, velocity = own.active, own.passive, own.velocity
    found: dict[str, Any] = {}

    @wp.func
    def custom_active(model: int, length: float) -> float:
        return active(length)

    @wp.func
    def custom_passive(model: int, length: float) -> float:
        return passive(length)

    @wp.func
    def custom_velocity(model: int, speed: float, activation: float) -> wp.vec2:
        if wp.static(own.sloped):
            return velocity(speed)
        else:
            rise = velocity(speed + SLOPE_STEP) - velocity(speed - SLOPE_STEP)
            return wp.vec2(velocity(speed), rise / wp.static(2.0 * SLOPE_STEP))

    @wp.func
    def custom_multiplier(model: int, speed: float, activation: float) -> float:
        return custom_velocity(model, speed, activation)[0]

    if active is not None:
        found["active_force_length"] = custom_active
    if passive is not None:
        found["passive_force_length"] = custom_passive
    if velocity is not None:
        found |= {"force_velocity_slope": custom_velocity, "force_velocity": custom_multiplier}
    return found


@cache
def with_curves(function: Any, own: CustomCurves | Shaped | None, curves: int | None = None) -> Any:
    """The Warp function with others' curves in the place of the model's; itself if it uses none of them.

    What it takes as the number of a model is the curves of a muscle instead, if these have a shape of their own.

    Args:
        curves: number of the only curve set that it is then compiled with, but for curves of one's own; None for all.
    """
    others = replacements(own, curves)
    if not others:
        return function
    changed = _changed(function.func, own, curves, function)
    gradient = known_gradient(function)
    if gradient is not None:
        changed |= _changed(gradient, own, curves, function)
    if not changed:
        return function
    made = wp.func(_made_anew(function.func, changed, own))
    if gradient is not None:
        gradient_of(made)(_made_anew(gradient, changed | {function.func.__name__: made}, own))
    return made


def _changed(plain: Any, own: CustomCurves | Shaped | None, curves: int | None, but: Any) -> dict[str, Any]:
    """What a function's names stand for with other curves, where that differs; `but` is not looked at."""
    others = replacements(own, curves)
    changed: dict[str, Any] = {}
    for name in plain.__code__.co_names:
        known = plain.__globals__.get(name)
        if name in others:
            changed[name] = others[name]
        elif isinstance(known, wp.Function) and known.func is not None and known is not but:
            made = with_curves(known, own, curves)
            if made is not known:
                changed[name] = made
    return changed


def _made_anew(plain: Any, changed: dict[str, Any], own: CustomCurves | Shaped | None) -> Any:
    """The same Python function, some of whose names stand for something else."""
    again = FunctionType(plain.__code__, plain.__globals__ | changed, plain.__name__, plain.__defaults__)
    again.__annotations__, again.__doc__ = dict(plain.__annotations__), plain.__doc__
    if isinstance(own, Shaped) and plain.__annotations__.get("model") is int:
        again.__annotations__["model"] = ShapedCurves
    again.__module__, again.__qualname__ = plain.__module__, f"with_curves.<locals>.{plain.__name__}"
    return again
