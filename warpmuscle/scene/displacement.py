"""Functions of one coordinate, by which joints turn and move, and points of muscles' paths move.

What they are as cubic pieces is in `joints/displacement.py`.
"""

from __future__ import annotations

from typing import Annotated, Literal

from warpmuscle.scene.number import Number, Vector
from warpmuscle.scene.part import Part


class Displacement(Part):
    """How far a coupled joint turns about an axis or moves along it, as a function of its coordinate q.

    It is value + slope q; or the `polynomial` c0 + c1 q + c2 q^2 ...; or goes through knots (x, y), and straight on
    beyond them: as a cubic spline whose `ends` are `simm`, as SIMM and OpenSim's SimmSpline have it, or `natural`,
    without curvature, or `linear`, straight from knot to knot.
    Of a joint that depends on the coordinate p of another one besides, it is the sum of a q^m p^n over `terms`
    [a, m, n]; or how far the end of a rod is from its beginning, which bends along an arc: `rod` is [length, and the
    angles about x and z at q = p = 0].
    """

    axis: Annotated[Vector, "1"]
    value: Annotated[Number, "rad or m"] = 0.0
    slope: Annotated[Number, "per unit of q"] = 0.0
    x: Annotated[list[float], "rad or m"] = []
    y: Annotated[list[Number], "rad or m"] = []
    ends: Literal["simm", "natural", "linear"] = "simm"
    polynomial: Annotated[list[Number], "rad or m per power of q"] = []  # the constant first
    terms: Annotated[
        list[tuple[Number, int, int]], "rad or m per powers of q and p"
    ] = []  # coefficient, power of q, power of p
    rod: Annotated[
        list[Number], "m, rad, rad"
    ] = []  # the first of `translations` is along x, the second y, the third z


class Coupling(Displacement):
    """A coordinate of an OpenSim model as a function of the coordinate of a joint; the axis has no meaning."""

    axis: Annotated[Vector, "1"] = (1.0, 0.0, 0.0)
    joint: str = ""
