"""Paths that are polynomials as a kernel wants them: all products of powers that they need, and sums of these."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from warpmuscle.core.arrays import records_to_device, rows, starts, structs_to_device, to_device
from warpmuscle.kernels import structs
from warpmuscle.scene import Muscle, PolynomialPath
from warpmuscle.scene.topology import Topology

ROUND = 16  # monomials, up to which their number is rounded, so that models of nearly as many share a kernel

Coordinate = tuple[str, int]  # joint and axis
Monomial = tuple[tuple[Coordinate, int], ...]  # coordinates in order, with their exponents; 1 is empty


def monomial_room(muscles: Iterable[Any]) -> int:
    """Monomials that there is to be room for, 0 if no path is a polynomial."""
    polynomials = _polynomials(muscles)
    return -(-len(_numbered(polynomials)) // ROUND) * ROUND if polynomials else 0


def put_polynomials(
    r: structs.Routes, muscles: Sequence[Any], crossing: Mapping[tuple[int, int], int], names: Topology, device: Any
) -> None:
    """Put in the polynomials of all muscles; `crossing` is the number of that of a muscle and a joint."""
    number = _numbered(_polynomials(muscles))
    spans: dict[str, list[int]] = {name: [] for name in structs.PolynomialSpan.vars}
    variables: dict[str, list[int]] = {name: [] for name in structs.Variable.vars}
    monomials: list[int] = []
    coefficients: list[Any] = []

    def put(table: dict[str, list[int]], terms: Iterable[tuple[Monomial, Any]]) -> None:
        table["first_term"].append(len(monomials))
        for monomial, coefficient in terms:
            monomials.append(number[monomial])
            coefficients.append(coefficient)
        table["end_term"].append(len(monomials))

    for k, muscle in enumerate(muscles):
        given = muscle.polynomial if isinstance(muscle, Muscle) else None
        terms = [] if given is None else _terms(given)
        put(spans, terms)
        spans["first_variable"].append(len(variables["joint"]))
        seen: set[int] = set()
        for coordinate in dict.fromkeys([] if given is None else _coordinates(given)):
            joint = names.driver[names.body_of_joint(coordinate[0])]
            variables["joint"].append(joint)
            variables["axis"].append(coordinate[1])
            variables["crossing"].append(crossing[k, joint])
            variables["first"].append(int(joint not in seen))
            seen.add(joint)
            put(variables, _derivative(terms, coordinate))
        spans["end_variable"].append(len(variables["joint"]))
    r.polynomial = records_to_device(structs.PolynomialSpan, device, **spans)
    r.variable = records_to_device(structs.Variable, device, **variables)
    columns = {"monomial": [monomials or [0]], "coefficient": rows(coefficients or [0.0])}
    r.term = structs_to_device(structs.PolynomialTerm, columns, device)
    _put_monomials(r, number, names, device)


def _put_monomials(r: structs.Routes, number: Mapping[Monomial, int], names: Topology, device: Any) -> None:
    """The monomials, each as one of lower degree times a coordinate."""
    before, joints, axes = [0], [0], [0]
    for monomial in list(number)[1:]:
        (joint, axis), _ = monomial[-1]
        before.append(number[_over(monomial, monomial[-1][0])])
        joints.append(names.driver[names.body_of_joint(joint)])
        axes.append(axis)
    r.monomial = records_to_device(structs.Monomial, device, before=before, joint=joints, axis=axes)
    degrees = [_degree(monomial) for monomial in number]
    r.degree_start = to_device(starts(degrees.count(n) for n in range(max(degrees) + 1)), int, device)


def _polynomials(muscles: Iterable[Any]) -> list[PolynomialPath]:
    return [m.polynomial for m in muscles if isinstance(m, Muscle) and m.polynomial is not None]


def _numbered(polynomials: Iterable[PolynomialPath]) -> dict[Monomial, int]:
    """All monomials of some polynomials and of their derivatives, and what these are made of, by degree."""
    found: dict[Monomial, None] = {(): None}

    def add(monomial: Monomial) -> None:
        while monomial not in found:
            found[monomial] = None
            monomial = _over(monomial, monomial[-1][0])

    for polynomial in polynomials:
        for monomial, _ in _terms(polynomial):
            add(monomial)
            for coordinate, _ in monomial:
                add(_over(monomial, coordinate))
    return {monomial: k for k, monomial in enumerate(sorted(found, key=lambda m: (_degree(m), m)))}


def _coordinates(polynomial: PolynomialPath) -> list[Coordinate]:
    return list(zip(polynomial.joints, polynomial.axes or [0] * len(polynomial.joints), strict=True))


def _terms(polynomial: PolynomialPath) -> list[tuple[Monomial, Any]]:
    """Monomials of a polynomial and their coefficients, m."""
    coordinates = _coordinates(polynomial)
    every = []
    for exponents, coefficient in zip(polynomial.exponents, polynomial.coefficients, strict=True):
        powers: dict[Coordinate, int] = {}
        for coordinate, n in zip(coordinates, exponents, strict=True):
            powers[coordinate] = powers.get(coordinate, 0) + n
        every.append((tuple(sorted((c, n) for c, n in powers.items() if n > 0)), coefficient))
    return every


def _derivative(terms: Iterable[tuple[Monomial, Any]], coordinate: Coordinate) -> list[tuple[Monomial, Any]]:
    """The derivative of a sum of terms by a coordinate."""
    return [(_over(m, coordinate), c * dict(m)[coordinate]) for m, c in terms if coordinate in dict(m)]


def _over(monomial: Monomial, coordinate: Coordinate) -> Monomial:
    """A monomial, divided by a coordinate in it."""
    return tuple((c, n - (c == coordinate)) for c, n in monomial if c != coordinate or n > 1)


def _degree(monomial: Monomial) -> int:
    return sum(n for _, n in monomial)
