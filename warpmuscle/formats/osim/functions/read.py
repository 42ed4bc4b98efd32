"""Functions as OpenSim's files have them."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.limits import GREATEST_NUMBER
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.expressions import of_one
from warpmuscle.formats.osim.functions.composed import KNOTS, resampled
from warpmuscle.formats.osim.functions.function import Function
from warpmuscle.scene.expressions.parse import BadExpression

MOST_HALF_ORDER = 4  # of splines, whose degree is twice that less 1
FAR = 1.0e3  # rad or m, of knots at which a function that holds its ends still has them
TURNS, PER_TURN = 25, 32  # of a sine on each side of 0, and the knots of each, at least
NEAR_TURN, NEAR_KNOTS = 128, 3200  # the knots of a turn within the least reach, if they are no more than so many in all
LEAST_REACH, WAVE_REACH = 10.0, 100.0  # rad or s on each side
STEP_KNOTS, LEVEL = 257, 4  # of a step, and beside it
STEEP = 1.0e-4  # part of the way between two knots in which a function that is level between them gets to the next
FARTHEST_OFF = 0.21  # of the way between two knots, where the slope of a cubic is
DOUBLED, SLOPE_OFF = 2, 1e-7  # how often they are doubled for one of another degree, until its slope is so close


def read_function(element: Element) -> Function:
    """The function that an element is.

    Raises:
        SceneError: it is of a class that is not known here, or has no knots or numbers.
    """
    element.used = True
    kind = element.tag.lower()
    if kind == "constant":
        value = element.child("value")
        return Function((value.number() if value is not None else 0.0,))
    if kind == "linearfunction":
        slope, offset = (1.0, 0.0) if element.child("coefficients") is None else _coefficients(element, 2)
        return Function((offset, slope))
    if kind == "polynomialfunction":
        return Function(tuple(reversed(_coefficients(element))))
    if kind == "multivariatepolynomialfunction":
        return _of_one(element)
    if kind in ("simmspline", "natcubicspline", "naturalcubicspline"):
        return _knots(element, "simm")
    if kind == "piecewiselinearfunction":
        return _knots(element, "linear")
    if kind == "gcvspline":
        return _gcv(element)
    if kind == "multiplierfunction":
        inner, scale = element.child("function"), element.child("scale")
        if inner is None or not inner.children:
            element.fail("multiplies no function")
        return read_function(inner.children[0]).scaled(scale.number() if scale is not None else 1.0)
    if kind == "sine":
        return _sine(element)
    if kind == "stepfunction":
        return _step(element)
    if kind == "piecewiseconstantfunction":
        return _stairs(_knots(element, "linear"))
    if kind == "expressionbasedfunction":
        return _expression(element)
    message = "lines, polynomials, sines, steps, expressions and splines through knots are"
    element.fail(f"functions of this class are not known; {message}")


def _expression(element: Element) -> Function:
    """An expression of one variable: the polynomial that it is, or a spline through knots about 0."""
    text, names = element.child("expression"), element.child("variables")
    variables = [] if names is None else names.text.split()
    if text is None or not text.text.strip():
        element.fail("has no expression")
    if len(variables) != 1:
        element.fail(f"is of {number_of(len(variables), 'variable')}, where one is known")
    try:
        found = of_one(text.text.strip(), variables[0])
    except BadExpression as error:
        text.fail(str(error))
    if isinstance(found, list):
        return Function(tuple(found))
    with np.errstate(all="ignore"):
        reach = np.linspace(-LEAST_REACH, LEAST_REACH, 2 * KNOTS)
        if wrong := [float(q) for q in reach[~(np.abs(found(reach)) <= GREATEST_NUMBER)]]:
            nearest = min(wrong, key=abs)
            text.fail(f"it has no number at {nearest:.3g}, and must have from {-LEAST_REACH:g} to {LEAST_REACH:g}")
        return replace(resampled(found, -LEAST_REACH, LEAST_REACH)[0], sampled=True)


def _of_one(element: Element) -> Function:
    """A polynomial of a class for several coordinates, which has its constant first."""
    dimension, order = _number(element, "dimension", 0.0), _number(element, "order", -1.0)
    if dimension != 1.0:
        element.fail(f"is of {dimension:g} coordinates, where one is known")
    if order != int(order) or not order >= 0.0:
        element.fail(f"its order is a whole number from 0 on, not {order:g}")
    return Function(tuple(_coefficients(element, int(order) + 1)))


def _number(element: Element, tag: str, usual: float) -> float:
    found = element.child(tag)
    return found.number() if found is not None and found.words() else usual


def _sine(element: Element) -> Function:
    """A sine, as a spline through knots about 0: as many turns as fit."""
    size, speed = _number(element, "amplitude", 1.0), _number(element, "omega", 1.0)
    phase, offset = _number(element, "phase", 0.0), _number(element, "offset", 0.0)
    if size == 0.0 or speed == 0.0:
        return Function((offset + size * math.sin(phase),))
    reach = min(WAVE_REACH, TURNS * 2.0 * math.pi / abs(speed))
    if reach < LEAST_REACH:
        element.fail(f"an omega of {speed:g} is too quick: {TURNS} turns are within {LEAST_REACH:g} rad or s at most")
    near = LEAST_REACH * abs(speed) / math.pi  # turns
    inner = max(math.ceil(min(near * NEAR_TURN, max(near * PER_TURN, NEAR_KNOTS))), KNOTS)
    beyond = (reach - LEAST_REACH) * abs(speed) / (2.0 * math.pi)
    out = LEAST_REACH + (reach - LEAST_REACH) * np.linspace(0.0, 1.0, 2 + math.ceil(beyond * PER_TURN))
    sides = out[1:] if reach > LEAST_REACH else out[:0]
    x = np.concatenate([-sides[::-1], np.linspace(-LEAST_REACH, LEAST_REACH, inner), sides])
    y = offset + size * np.sin(speed * x + phase)
    return Function(x=tuple(map(float, x)), y=tuple(map(float, y)), sampled=True)


def _step(element: Element) -> Function:
    """From one value to another as s^3 (10 - 15 s + 6 s^2), level before and behind."""
    start, end = _number(element, "transition_start_time", 0.99), _number(element, "transition_end_time", 1.01)
    first, last = _number(element, "start_value", 0.0), _number(element, "end_value", 1.0)
    if not start < end:
        element.fail(f"its transition must end after {start:g}, not at {end:g}")
    s = np.linspace(0.0, 1.0, STEP_KNOTS)
    level = np.arange(1, LEVEL + 1) / STEP_KNOTS
    x = start + (end - start) * np.concatenate([-level[::-1], s, 1.0 + level])
    rise = np.concatenate([np.zeros(LEVEL), s**3 * (10.0 - 15.0 * s + 6.0 * s * s), np.ones(LEVEL)])
    y = first + (last - first) * rise
    return Function(x=(x[0] - FAR, *map(float, x), x[-1] + FAR), y=(first, *map(float, y), last), ends="linear")


def _stairs(knots: Function) -> Function:
    """The value of the last knot, from there on: steep between two."""
    if not knots.x:
        return knots
    x, y = [knots.x[0] - FAR], [knots.y[0]]
    for before, after, at, last in zip(knots.y, knots.y[1:], knots.x[1:], knots.x, strict=False):
        x += [at - STEEP * (at - last), at]
        y += [before, after]
    return Function(x=(*x, knots.x[-1] + FAR), y=(*y, knots.y[-1]), ends="linear")


def owned_function(element: Element, *others: str) -> Function | None:
    """The function of an element that holds one, itself or within `function`; `others` are its other children."""
    wrapper = element.child("function")
    if wrapper is not None and wrapper.children:
        return read_function(wrapper.children[0])
    found = [child for child in element.children if child.tag not in (*others, "function")]
    return read_function(found[-1]) if found else None


def _coefficients(element: Element, count: int | None = None) -> list[float]:
    found = element.child("coefficients")
    if found is None:
        element.fail("has no coefficients")
    numbers = found.numbers(count)
    if not numbers:
        found.fail("is empty")
    return numbers


def _knots(element: Element, ends: Literal["simm", "natural", "linear"]) -> Function:
    """A function through knots, of which there must be two."""
    xs, ys = element.child("x"), element.child("y")
    if xs is None or ys is None:
        element.fail("has no knots; give `x` and `y`")
    x, y = xs.numbers(), ys.numbers()
    if len(x) != len(y):
        element.fail(f"has {len(x)} x and {len(y)} y")
    if not x:
        element.fail("has no knots")
    if len(x) == 1:
        return Function((y[0],))
    for before, after in itertools.pairwise(x):
        if not before < after:
            element.fail(f"x must increase, but {after:g} follows {before:g}")
    return Function(x=tuple(x), y=tuple(y), ends=ends)


def _gcv(element: Element) -> Function:
    """A generalised cross-validatory spline, which goes through its knots: natural, of third or of fifth degree."""
    half, element_variance = element.child("half_order"), element.child("error_variance")
    if element_variance is not None and element_variance.number() > 0.0:
        element_variance.fail("smooths, so that the spline misses its knots; only an error variance of 0 is known")
    knots = _knots(element, "natural")
    order = 3 if half is None else int(half.number())
    if half is not None and not 1 <= order <= MOST_HALF_ORDER:
        half.fail(f"must be from 1 to {MOST_HALF_ORDER}, is {order}")
    if order == 1 and len(knots.x) > 1:  # which holds its ends, as knots far away do
        y = (knots.y[0], *knots.y, knots.y[-1])
        return Function(x=(knots.x[0] - FAR, *knots.x, knots.x[-1] + FAR), y=y, ends="linear")
    if order == 2 or len(knots.x) < 2 * order:
        return knots
    from scipy.interpolate import make_interp_spline  # for which no model without such functions has to wait

    low, high = knots.x[0], knots.x[-1]
    natural = [(order + k, 0.0) for k in range(order - 1)]
    spline = make_interp_spline(knots.x, knots.y, k=2 * order - 1, bc_type=(natural, natural))
    sides = (high - low) * np.linspace(0.25, 1.0, 4)  # a parabola or cubic there, which few knots give
    for doubling in range(DOUBLED + 1):
        inner = np.linspace(low, high, (KNOTS - 1) * 2**doubling + 1)
        x = np.concatenate([low - sides[::-1], inner, high + sides])
        values = _beyond(spline, x, low, high, order)
        found = Function(x=tuple(map(float, x)), y=tuple(map(float, values)), ends="simm", sampled=True)
        between = inner[:-1] + FARTHEST_OFF * np.diff(inner)
        slope = spline(between, 1)
        if np.max(np.abs(found.slopes(between) - slope)) <= SLOPE_OFF * np.max(np.abs(slope)):
            break
    return found


def _beyond(spline: Any, x: Floats, low: float, high: float, order: int) -> Floats:
    """A natural spline's values, beyond its knots on its polynomial of a degree below its half order."""
    y = np.asarray(spline(np.clip(x, low, high)))
    for end, out in ((low, x < low), (high, x > high)):
        step = x[out] - end
        y[out] = sum(float(spline(end, k)) * step**k / math.factorial(k) for k in range(order))
    return y
