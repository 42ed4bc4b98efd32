"""Functions of OpenSim as expressions of a scene."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from warpmuscle.core.array_types import Floats
from warpmuscle.core.limits import LIMITS
from warpmuscle.formats.osim.functions import Function
from warpmuscle.scene.expressions.part import ExpressionCurve

SMALLEST = 1e-15  # factors below which rounding put them there
BEFORE = 12  # knots before the time 0 that a spline from then on still feels, each next a quarter as much


def function_text(function: Function, variable: str, name: str, curves: dict[str, ExpressionCurve]) -> str:
    """A function of a variable: a call of a curve of this name, which is put among the curves, or a polynomial."""
    if function.constant:
        return repr(function.at(0.0)) if not function.x else repr(float(function.y[0]))
    if function.x:
        first = max(sum(x < 0.0 for x in function.x) - BEFORE, 0) if variable == "t" else 0
        later = replace(function, x=function.x[first:], y=function.y[first:]).sparse(LIMITS["knots"].most)
        curves[name] = ExpressionCurve([*later.x], [*later.y], later.ends)
        return f"{name}({variable})"
    terms = [
        repr(float(c)) if power == 0 else f"{float(c)!r}*{variable}" + (f"^{power}" if power > 1 else "")
        for power, c in enumerate(function.coefficients)
        if c != 0.0
    ]
    return " + ".join(terms).replace("+ -", "- ")


def turned_texts(matrix: Floats, texts: Iterable[str], shift: Iterable[float] = (0.0, 0.0, 0.0)) -> tuple[str, ...]:
    """Three expressions multiplied by a matrix (3, 3), and shifted."""
    given = list(texts)
    found = []
    for row, offset in zip(matrix, shift, strict=True):
        terms = [repr(float(offset))] if abs(offset) > SMALLEST else []
        for factor, text in zip(row, given, strict=True):
            if abs(factor) > SMALLEST and text != "0.0":
                terms.append(f"({text})" if factor == 1.0 else f"{float(factor)!r}*({text})")
        found.append(" + ".join(terms).replace("+ -", "- ") or "0")
    return tuple(found)
