"""Functions of several coordinates: polynomials, as sums of functions of one coordinate and of two.

A polynomial is a table of coefficients by monomials, each the sorted names of its coordinates with their powers.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.functions import read_function

Monomial = tuple[tuple[str, int], ...]
Polynomial = dict[Monomial, float]
Terms = tuple[tuple[float, tuple[int, ...]], ...]  # coefficient, and a power for each coordinate

MOST_TERMS = 10_000


def read_terms(element: Element, count: int) -> Terms:
    """The terms of a function of several coordinates: a line, a polynomial, or a multiple of one.

    Raises:
        SceneError: it is of another class, or has not as many numbers as it takes.
    """
    element.used = True
    kind = element.tag.lower()
    still = (0,) * count
    if kind == "constant":
        return ((read_function(element).at(0.0), still),)
    if kind == "multiplierfunction":
        inner, scale = element.child("function"), element.child("scale")
        if inner is None or not inner.children:
            element.fail("multiplies no function")
        factor = scale.number() if scale is not None else 1.0
        return tuple((factor * a, exponents) for a, exponents in read_terms(inner.children[0], count))
    if kind == "linearfunction":
        given = element.child("coefficients")
        if given is None:
            element.fail("has no coefficients")
        *slopes, offset = given.numbers(count + 1)
        lines = (tuple(int(k == one) for k in range(count)) for one in range(count))
        return ((offset, still), *zip(slopes, lines, strict=True))
    if kind == "multivariatepolynomialfunction":
        return _polynomial(element, count)
    element.fail("this class of function is of one coordinate; of several, lines and polynomials are known")


def _polynomial(element: Element, count: int) -> Terms:
    dimension, order, given = (element.child(tag) for tag in ("dimension", "order", "coefficients"))
    if dimension is None or order is None or given is None:
        element.fail("needs <dimension>, <order> and <coefficients>")
    size, greatest = dimension.number(), order.number()
    if size != count:
        dimension.fail(f"is {size:g} for {number_of(count, 'coordinate')}")
    if greatest != int(greatest) or not greatest >= 0 or math.comb(count + int(greatest), count) > MOST_TERMS:
        order.fail(f"is a whole number from 0 on, with no more than {MOST_TERMS} terms, not {greatest:g}")
    exponents = list(powers(count, int(greatest)))
    return tuple(zip(given.numbers(len(exponents)), exponents, strict=True))


def powers(dimension: int, order: int) -> Iterable[tuple[int, ...]]:
    """Exponents of the terms of OpenSim's MultivariatePolynomialFunction in the order of its coefficients."""
    if dimension == 0:
        yield ()
        return
    for first in range(order + 1):
        for rest in powers(dimension - 1, order - first):
            yield (first, *rest)


def product(one: Polynomial, other: Polynomial) -> Polynomial:
    """Two polynomials multiplied."""
    found: Polynomial = {}
    for first, a in one.items():
        for second, b in other.items():
            together = dict(first)
            for name, power in second:
                together[name] = together.get(name, 0) + power
            key = tuple(sorted(together.items()))
            found[key] = found.get(key, 0.0) + a * b
    return found


def put_in(terms: Terms, arguments: Sequence[Polynomial]) -> Polynomial:
    """A sum of terms of coordinates that are polynomials of others."""
    found: Polynomial = {}
    for a, exponents in terms:
        part: Polynomial = {(): a}
        for argument, power in zip(arguments, exponents, strict=True):
            for _ in range(power if part != {(): 0.0} else 0):
                part = product(part, argument)
        for key, value in part.items():
            found[key] = found.get(key, 0.0) + value
    return {key: value for key, value in found.items() if value != 0.0}


def value_at(polynomial: Polynomial, at: dict[str, float]) -> float:
    """A polynomial's value at values of its coordinates."""
    return sum(a * math.prod(at[name] ** power for name, power in monomial) for monomial, a in polynomial.items())
