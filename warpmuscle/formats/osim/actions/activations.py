"""The activation of an ActivationCoordinateActuator, which follows its control: tau a' = u - a, from a start."""

from __future__ import annotations

import itertools

import numpy as np

from warpmuscle.formats.osim.actions.texts import function_text
from warpmuscle.formats.osim.functions import Function
from warpmuscle.scene.expressions.part import ExpressionCurve

EVEN, FINE = 700, 16  # knots over the time of a control through knots, and steps between two of them
EARLY, LATE = 40, 10.0  # knots of the first and last time constants, and how many of these


def activation_text(
    control: Function, time_constant: float, start: float, name: str, curves: dict[str, ExpressionCurve]
) -> str:
    """An expression of the time t for the activation, exact where the control is one polynomial of time.

    Args:
        time_constant: tau, s. start: the activation at first.
    """
    if not time_constant > 0.0:
        return function_text(control, "t", name, curves)
    if control.x and not control.constant:
        return function_text(_followed(control, time_constant, start), "t", name, curves)
    u = np.polynomial.Polynomial(control.coefficients or (control.at(0.0),))
    settled, part = np.polynomial.Polynomial([0.0]), u
    for _ in range(u.degree() + 1):  # sum of (-tau)^k times the k-th derivative
        settled, part = settled + part, part.deriv() * -time_constant
    late = function_text(Function(tuple(map(float, settled.coef))), "t", name, curves)
    rest = start - float(settled(0.0))
    return f"{late} + {rest!r}*exp({-1.0 / time_constant!r}*t)".replace("+ -", "- ") if rest else late


def _followed(control: Function, time_constant: float, start: float) -> Function:
    """The activation as a broken line, until it has settled behind the last knot of the control."""
    own = [x for x in control.x if x > 0.0]
    end = (own[-1] if own else 0.0) + LATE * time_constant
    early = np.linspace(0.0, min(LATE * time_constant, end), EARLY)
    knots = np.unique([*np.linspace(0.0, end, EVEN), *early, *(own if len(own) <= EVEN // 3 else ())])
    found = [start]
    for low, high in itertools.pairwise(knots):
        times = np.linspace(low, high, FINE + 1)
        values, step = control.values(times), (high - low) / FINE
        rest = float(np.exp(-step / time_constant))
        a = found[-1]
        for first, last in itertools.pairwise(values):  # exact for a control that is straight between
            lag = (last - first) * time_constant / step
            a = last - lag + (a - first + lag) * rest
        found.append(float(a))
    return Function(x=tuple(map(float, knots)), y=tuple(found), ends="linear")
