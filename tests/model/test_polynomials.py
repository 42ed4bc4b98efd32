"""Terms of polynomial paths, their derivatives, and monomials each made of one of lower degree."""

import numpy as np

from warpmuscle.model import polynomials as model
from warpmuscle.scene.muscles import PolynomialPath

PATH = PolynomialPath(
    ["hip", "knee", "hip"],
    exponents=[[0, 0, 0], [1, 0, 0], [2, 1, 0], [0, 3, 1], [1, 0, 2]],
    coefficients=[0.3, -0.05, 0.02, 0.011, -0.007],
    axes=[0, 0, 1],
)
COORDINATES = [("hip", 0), ("knee", 0), ("hip", 1)]


def value(terms: list, q: dict) -> float:
    """Of a sum of terms."""
    return sum(c * np.prod([q[coordinate] ** n for coordinate, n in monomial]) for monomial, c in terms)


def test_terms_are_those_of_the_path_and_derivatives_their_slopes():
    terms = model._terms(PATH)
    q = dict(zip(COORDINATES, (0.4, -0.7, 0.9), strict=True))
    powers = np.prod(np.array(list(q.values())) ** np.array(PATH.exponents), axis=1)
    assert np.isclose(value(terms, q), powers @ PATH.coefficients, rtol=1e-12)
    for coordinate in COORDINATES:
        ahead, behind = (value(terms, q | {coordinate: q[coordinate] + d}) for d in (1e-5, -1e-5))
        slope = value(model._derivative(terms, coordinate), q)
        np.testing.assert_allclose(slope, (ahead - behind) / 2e-5, rtol=1e-7, atol=1e-10)


def test_a_coordinate_named_twice_counts_with_the_sum_of_its_exponents():
    twice = PolynomialPath(["knee", "knee"], exponents=[[1, 2]], coefficients=[0.5])
    assert model._terms(twice) == [(((("knee", 0), 3),), 0.5)]


def test_monomials_are_numbered_by_degree_and_made_of_earlier_ones():
    numbered = model._numbered([PATH])
    assert list(numbered.values()) == list(range(len(numbered)))
    degrees = [sum(n for _, n in monomial) for monomial in numbered]
    assert degrees == sorted(degrees)
    assert degrees[0] == 0
    assert max(degrees) == 4
    for monomial, number in list(numbered.items())[1:]:
        before = model._over(monomial, monomial[-1][0])
        assert numbered[before] < number
        assert sum(n for _, n in before) == sum(n for _, n in monomial) - 1
    for terms in (model._terms(PATH), *(model._derivative(model._terms(PATH), one) for one in COORDINATES)):
        assert {monomial for monomial, _ in terms} <= set(numbered)
