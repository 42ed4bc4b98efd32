"""Functions of one coordinate: lines, polynomials and splines, read, evaluated and put into each other."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.limits import GREATEST_NUMBER
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.expressions import of_one
from warpmuscle.scene import Displacement
from warpmuscle.scene.expressions.parse import BadExpression
from warpmuscle.scene.joints.displacement import rates

MOST_HALF_ORDER = 4  # of splines, whose degree is twice that less 1
FAR = 1.0e3  # rad or m, of knots at which a function that holds its ends still has them
ROUNDED, SEARCHED = 1.0e-9, 301  # rad or m; places on each side, at which a range may be left
ENDLESS = 1.0e6  # rad or m, for a range that has no end
TURNS, PER_TURN = 25, 32  # of a sine on each side of 0, and the knots of each, at least
NEAR_TURN, NEAR_KNOTS = 128, 3200  # the knots of a turn within the least reach, if they are no more than so many in all
LEAST_REACH, WAVE_REACH = 10.0, 100.0  # rad or s on each side
STEP_KNOTS, LEVEL = 257, 4  # of a step, and beside it
STEEP = 1.0e-4  # part of the way between two knots in which a function that is level between them gets to the next
KNOTS = 401  # of a spline that stands for a function of a function, or for one of another degree, at least
MIDWAY_OFF, CLOSER = 1.0e-10, 8  # of its values and of 1 rad or m, by which it may be off between; doublings at most
MOST_KNOTS = 1000  # then: as many as a ligament's function may have
FARTHEST_OFF = 0.21  # of the way between two knots, where the slope of a cubic is
DOUBLED, SLOPE_OFF = 2, 1e-7  # how often they are doubled for one of another degree, until its slope is so close
BEYOND = 0.5  # of a range, as far as such a spline reaches on each side of it


@dataclass(frozen=True, slots=True)
class Function:
    """A polynomial, its constant first, or a spline through knots."""

    coefficients: tuple[float, ...] = ()
    x: tuple[float, ...] = ()
    y: tuple[float, ...] = ()
    ends: Literal["simm", "natural", "linear"] = "simm"
    sampled: bool = False  # its knots were chosen here, of a function that is no such spline

    @property
    def constant(self) -> bool:
        """Whether it is the same everywhere."""
        return not any(self.coefficients[1:]) if not self.x else len(set(self.y)) == 1

    @property
    def line(self) -> tuple[float, float] | None:
        """Value at 0 and slope of a straight line; None if it is none."""
        if self.x:
            return (self.y[0], 0.0) if self.constant else None
        a = (*self.coefficients, 0.0, 0.0)
        return None if any(self.coefficients[2:]) else (a[0], a[1])

    def at(self, q: float) -> float:
        """Its value."""
        return float(self.values(np.array([q]))[0])

    def values(self, q: Floats) -> Floats:
        """Its values at coordinates (n,)."""
        if not self.x:
            return np.asarray(np.polynomial.polynomial.polyval(q, self.coefficients or (0.0,)))
        if self.ends == "linear":
            return _broken_line(self, q)
        spline = Displacement((1.0, 0.0, 0.0), x=list(self.x), y=list(self.y), ends=self.ends)
        return rates(spline, q)[0]

    def slopes(self, q: Floats) -> Floats:
        """The slopes of a smooth spline at coordinates (n,)."""
        return rates(Displacement((1.0, 0.0, 0.0), x=list(self.x), y=list(self.y), ends=self.ends), q)[1]

    def sparse(self, most: int) -> Function:
        """It with no more knots than so many, if they were chosen here: with every second one, or fewer."""
        if not self.sampled or len(self.x) <= most:
            return self
        last = len(self.x) - 1
        kept = [*range(0, last, math.ceil(last / (most - 1))), last]
        return replace(self, x=tuple(self.x[k] for k in kept), y=tuple(self.y[k] for k in kept))

    def scaled(self, factor: float) -> Function:
        """It times a factor."""
        return replace(
            self, coefficients=tuple(factor * c for c in self.coefficients), y=tuple(factor * y for y in self.y)
        )


ZERO = Function((0.0,))
IDENTITY = Function((0.0, 1.0))


def composed(outer: Function, inner: Function, low: float, high: float) -> tuple[Function, float]:
    """The function q -> outer(inner(q)), and how far it is off between low and high: 0 if one of them is a line."""
    straight = inner.line
    if outer.line is not None:
        offset, slope = outer.line
        moved = inner.scaled(slope)
        if moved.x:
            return replace(moved, y=tuple(y + offset for y in moved.y)), 0.0
        first, *rest = moved.coefficients or (0.0,)
        return Function((first + offset, *rest)), 0.0
    if straight is not None:
        offset, slope = straight
        if slope == 0.0:
            return Function((outer.at(offset),)), 0.0
        if outer.x:
            step = 1 if slope > 0.0 else -1
            return replace(outer, x=tuple((x - offset) / slope for x in outer.x[::step]), y=outer.y[::step]), 0.0
        polynomial = np.polynomial.Polynomial(outer.coefficients)(np.polynomial.Polynomial([offset, slope]))
        return Function(tuple(map(float, polynomial.coef))), 0.0
    return resampled(lambda q: outer.values(inner.values(q)), low, high, BEYOND)


def resampled(
    function: Callable[[Floats], Floats], low: float, high: float, beyond: float = 0.0
) -> tuple[Function, float]:
    """A spline through many values of a function, and how far it is off between its knots from low to high.

    Knots are twice as close wherever it is off by more than `MIDWAY_OFF`, as often as `CLOSER`, so that its second
    derivative, which accelerations need, is close, too.

    Args:
        beyond: part of the way from low to high, by which knots reach beyond both, since a free run leaves ranges.
    """
    inner = np.linspace(low, high, KNOTS)
    out = (inner[1] - inner[0]) * np.arange(1, 1 + round(beyond * (KNOTS - 1)))
    x = np.concatenate([low - out[::-1], inner, high + out])
    for closer in range(CLOSER + 1):
        spline = Function(x=tuple(map(float, x)), y=tuple(map(float, function(x))), ends="simm")
        between = 0.5 * (x[1:] + x[:-1])
        off = np.abs(spline.values(between) - function(between))
        off_for = off / np.maximum(1.0, np.abs(function(between)))
        far = off_for > MIDWAY_OFF
        if closer == CLOSER or not np.any(far) or len(x) >= MOST_KNOTS:
            break
        worst = np.argsort(-off_for)[: min(MOST_KNOTS - len(x), int(np.count_nonzero(far)))]
        x = np.sort(np.concatenate([x, between[worst]]))
    return spline, float(np.max(off[(between > low) & (between < high)]))


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


def _broken_line(function: Function, q: Floats) -> Floats:
    """Straight between knots, and on beyond them."""
    x, y = np.array(function.x), np.array(function.y)
    piece = np.clip(np.searchsorted(x, q) - 1, 0, len(x) - 2)
    slope = np.diff(y) / np.diff(x)
    return np.asarray(y[piece] + slope[piece] * (q - x[piece]))


# Where they are within a range.


def span_within(
    function: Function, span: tuple[float, float], domain: tuple[float, float] = (-math.pi, math.pi)
) -> list[float]:
    """The span of its argument in which a function is within a range, as OpenSim clamps what moves a point to it.

    None where the range has no ends. Of a function that is no line, it is the one about the middle of its argument's
    range, looked for as far beyond that as it is wide; an end that the function does not reach there is far away.
    """
    if function.constant or not any(map(math.isfinite, span)):
        return []
    if function.line is None:
        return _around_middle(function, span, domain)
    offset, slope = function.line
    low, high = sorted((max(min(end, ENDLESS), -ENDLESS) - offset) / slope for end in span)
    return [low, high] if low < high else []


def spans_within(
    function: Function, span: tuple[float, float], domain: tuple[float, float]
) -> list[tuple[float, float]]:  # fmt: skip
    """The spans of its argument in which a function is within a range, over its domain and half as far beyond."""
    width = 0.5 * (domain[1] - domain[0])
    places = np.linspace(domain[0] - width, domain[1] + width, 10 * SEARCHED)
    inside = [bool(one) for one in (span[0] <= function.values(places)) & (function.values(places) <= span[1])]
    ends = [
        _crossing(function, span, float(places[k]), float(places[k + 1]))
        for k in range(len(inside) - 1)
        if inside[k] != inside[k + 1]
    ]
    if inside[0]:
        ends = [-ENDLESS, *ends]
    if inside[-1]:
        ends = [*ends, ENDLESS]
    return list(zip(ends[::2], ends[1::2], strict=True))


def _crossing(function: Function, span: tuple[float, float], low: float, high: float) -> float:
    """Where a function enters a range, or leaves it, between two places."""
    first = span[0] <= function.at(low) <= span[1]
    while high - low > 1e-12 * (1.0 + abs(low)):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        inside = span[0] <= function.at(middle) <= span[1]
        low, high = (middle, high) if inside == first else (low, middle)
    return 0.5 * (low + high)


def _around_middle(function: Function, span: tuple[float, float], domain: tuple[float, float]) -> list[float]:
    """What `span_within` says of a function that is no line."""

    def inside(q: float) -> bool:
        return bool(span[0] - ROUNDED <= function.at(q) <= span[1] + ROUNDED)

    middle, width = 0.5 * (domain[0] + domain[1]), domain[1] - domain[0]
    if not inside(middle):
        return []
    ends = []
    for way, far in ((-1.5 * width, -ENDLESS), (1.5 * width, ENDLESS)):
        places = middle + way * np.linspace(0.0, 1.0, SEARCHED)
        out = next((k for k, q in enumerate(places) if not inside(float(q))), 0)
        if not out:
            ends.append(far)
            continue
        kept, left = float(places[out - 1]), float(places[out])
        for _ in range(50):
            half = 0.5 * (kept + left)
            kept, left = (half, left) if inside(half) else (kept, half)
        ends.append(kept)
    return ends if ends != [-ENDLESS, ENDLESS] else []
