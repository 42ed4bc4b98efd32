"""Normalised curves of Hill-type muscles: active and passive force-length, force-velocity, tendon force-strain.

Forces are over f_max, fibre lengths over l_opt, speeds over v_max and positive when lengthening, tendon strains
l_tendon/l_slack - 1. `model` is the number of one of `curve_sets.CURVES`, whose functions are in a file of its name,
`lee_curves.py` for lee; a number of no set has curves that are not numbers.
"""

from functools import cache, partial
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import warp as wp

from warpmuscle.kernels.curve.curve_functions import CurveFunctions, checked
from warpmuscle.kernels.curve.curve_functions import gaussian_active as gaussian_active
from warpmuscle.kernels.curve.curve_functions import hyperbolic_velocity as hyperbolic_velocity
from warpmuscle.kernels.curve.curve_sets import CURVES
from warpmuscle.kernels.curve.curve_sets import DE_GROOTE as DE_GROOTE
from warpmuscle.kernels.curve.curve_sets import LEE as LEE
from warpmuscle.kernels.curve.curve_sets import MILLARD as MILLARD
from warpmuscle.kernels.curve.curve_sets import SARSHARI as SARSHARI
from warpmuscle.kernels.curve.curve_sets import THELEN as THELEN
from warpmuscle.kernels.curve.curve_sets import THELEN_EXPLICIT as THELEN_EXPLICIT
from warpmuscle.kernels.functions import func

NO_SETS = ("custom", "shaped")  # files of curves whose numbers, or functions, scenes give


def module_of(name: str) -> ModuleType:
    """The file of a curve set; raises TypeError if there is none."""
    file = f"{__package__}.{name}_curves"
    try:
        return import_module(file)
    except ModuleNotFoundError as error:
        if error.name != file:
            raise
        raise TypeError(f"curve set {name!r} has no file {name}_curves.py with its CURVES") from None


def check_names(folder: Path) -> None:
    """TypeError if a file of curves has no name, by which alone a scene could choose them."""
    for file in sorted(folder.glob("*_curves.py")):
        name = file.stem.removesuffix("_curves")
        if name not in CURVES and name not in NO_SETS:
            raise TypeError(f"curve set {name!r} in {file.name} has no name: add it to `CurveSet` in curve_sets.py")


check_names(Path(__file__).parent)
MODULES = {name: module_of(name) for name in CURVES}
SETS: dict[int, CurveFunctions] = {
    CURVES[name]: checked(name, getattr(module, "CURVES", None)) for name, module in MODULES.items()
}


def _force(number: int, one: Any, others: Any, result: Any = float) -> Any:
    """The Warp function (model, x) of a force: that of one, or of the others for other numbers.

    Args:
        result: float, or wp.vec2 for a force with its slope.
    """

    @func
    def force(model: int, x: float) -> result:
        if model == number:
            return one(x)
        return others(model, x)

    return force


def _multiplier(number: int, one: Any, others: Any) -> Any:
    """The same of the force-velocity multiplier."""

    @func
    def multiplier(model: int, speed: float, activation: float) -> wp.vec2:
        if model == number:
            return one(speed, activation)
        return others(model, speed, activation)

    return multiplier


@func
def no_force(model: int, x: float) -> float:
    return wp.static(float("nan"))


@func
def no_sloped_force(model: int, x: float) -> wp.vec2:
    return wp.vec2(wp.static(float("nan")))


@func
def no_multiplier(model: int, speed: float, activation: float) -> wp.vec2:
    return wp.vec2(wp.static(float("nan")))


def _choice(field: str, either: Any, none: Any) -> Any:
    """The Warp function of a curve of any set."""
    chosen = none
    for number, functions in reversed(SETS.items()):
        chosen = either(number, getattr(functions, field), chosen)
    return chosen


any_active, any_passive = _choice("active", _force, no_force), _choice("passive", _force, no_force)
any_velocity = _choice("velocity", _multiplier, no_multiplier)
any_tendon = _choice("tendon", partial(_force, result=wp.vec2), no_sloped_force)


@func
def active_force_length(model: int, length: float) -> float:
    """Active isometric force at full activation."""
    return any_active(model, length)


@func
def passive_force_length(model: int, length: float) -> float:
    """Force of the passive fibre; unbounded."""
    return any_passive(model, length)


@func
def force_velocity_slope(model: int, speed: float, activation: float) -> wp.vec2:
    """Force-velocity multiplier and its derivative by speed.

    Args:
        activation: used by THELEN only, where a fibre shortens at most at 0.25 + 0.75 a. There and with LEE,
            THELEN_EXPLICIT and DE_GROOTE the multiplier is negative for faster shortening, with MILLARD it stays zero,
            and with SARSHARI it is positive at any speed.
    """
    return any_velocity(model, speed, activation)


@func
def force_velocity(model: int, speed: float, activation: float) -> float:
    """Force-velocity multiplier, see `force_velocity_slope`."""
    return force_velocity_slope(model, speed, activation)[0]


@func
def tendon_force_slope(model: int, strain: float) -> wp.vec2:
    """Force of the tendon and its derivative by strain; zero when slack."""
    return any_tendon(model, strain)


@func
def tendon_force_strain(model: int, strain: float) -> float:
    """Force of the tendon at a strain."""
    return tendon_force_slope(model, strain)[0]


@cache
def functions_of(number: int) -> dict[str, Any]:
    """Functions of one set in the place of those of this file, by name: they take any number, and do not look at it."""
    active, passive, velocity, tendon = SETS[number]

    @wp.func
    def set_active(model: int, length: float) -> float:
        return active(length)

    @wp.func
    def set_passive(model: int, length: float) -> float:
        return passive(length)

    @wp.func
    def set_velocity(model: int, speed: float, activation: float) -> wp.vec2:
        return velocity(speed, activation)

    @wp.func
    def set_multiplier(model: int, speed: float, activation: float) -> float:
        return velocity(speed, activation)[0]

    @wp.func
    def set_tendon(model: int, strain: float) -> wp.vec2:
        return tendon(strain)

    @wp.func
    def set_tendon_force(model: int, strain: float) -> float:
        return tendon(strain)[0]

    return {
        "active_force_length": set_active,
        "passive_force_length": set_passive,
        "force_velocity_slope": set_velocity,
        "force_velocity": set_multiplier,
        "tendon_force_slope": set_tendon,
        "tendon_force_strain": set_tendon_force,
    }
