"""What a set of curves of muscles is made of, and shapes that several sets have."""

from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.functions import func

PASSIVE_STRAIN = 0.6  # at f_max: lee, thelen and de_groote

SIGNATURES: dict[str, tuple[str, int, Any]] = {  # of the functions: as one writes it, numbers taken, result
    "active": ("(length) -> float", 1, float),
    "passive": ("(length) -> float", 1, float),
    "velocity": ("(speed, activation) -> wp.vec2", 2, wp.vec2),
    "tendon": ("(strain) -> wp.vec2", 1, wp.vec2),
}


class CurveFunctions(NamedTuple):
    """The normalised curves of a set, Warp functions; see `curves.py` for units.

    A set is one file, such as `lee_curves.py`, whose `CURVES` this is, and one name in `curve_sets.CurveSet`.
    """

    active: Any = None  # (length) -> active isometric force at full activation
    passive: Any = None  # (length) -> force of the passive fibre, unbounded
    velocity: Any = None  # (speed, activation) -> force-velocity multiplier, and its slope by speed
    tendon: Any = None  # (strain) -> force of the tendon, and its slope by strain; zero when slack


def checked(name: str, curves: Any) -> CurveFunctions:
    """The curves of a set.

    Raises:
        TypeError: one of them is missing, or is no such function; it names the set and the curve.
    """
    file = f"{name}_curves.py"
    if not isinstance(curves, CurveFunctions):
        raise TypeError(f"curve set {name!r}: {file} has no CURVES, a `curve_functions.CurveFunctions`")
    for field, (signature, count, result) in SIGNATURES.items():
        function = getattr(curves, field)
        if function is None:
            raise TypeError(f"curve set {name!r} has no {field!r}: CURVES in {file} needs a Warp function {signature}")
        types = list(function.func.__annotations__.values()) if isinstance(function, wp.Function) else []
        if [float if kind is wp.float32 else kind for kind in types] != [float] * count + [result]:
            raise TypeError(f"curve set {name!r}: {field!r} in {file} must be a Warp function {signature}")
    return curves


@func
def gaussian_active(length: float, shape: float) -> float:
    """exp(-(l - 1)^2/shape) (Bergmann 2017, eq. 4, shape 0.5; Thelen 2003, eq. 4, shape 0.45)."""
    return wp.exp((length - 1.0) * (length - 1.0) * (-1.0 / shape))


@func
def exponential_passive(length: float, rate: float, scale: float) -> float:
    """(exp(k (l - 1)/0.6) - 1)/(exp k - 1) beyond l = 1 (Bergmann 2017, eq. 6, k = 4; Thelen 2003, eq. 3, k = 5).

    Args:
        rate: k/0.6. scale: 1/(exp k - 1).
    """
    if length <= 1.0:
        return 0.0
    return (wp.exp(rate * (length - 1.0)) - 1.0) * scale


@func
def hyperbolic_velocity(speed: float, shape: float, longest: float) -> wp.vec2:
    """Force-velocity multiplier of two hyperbolas, and its slope (Bergmann 2017, eq. 5; Thelen 2003, eq. 6 and 7).

    Args:
        shape: A_f of the sources. longest: multiplier at infinite lengthening speed.
    """
    if speed <= 0.0:
        part = 1.0 / (1.0 - speed * (1.0 / shape))
        return wp.vec2((speed + 1.0) * part, (1.0 + 1.0 / shape) * part * part)
    scale = (2.0 + 2.0 / shape) / (longest - 1.0)
    part = 1.0 / (1.0 + scale * speed)
    return wp.vec2((1.0 + longest * scale * speed) * part, scale * (longest - 1.0) * part * part)
