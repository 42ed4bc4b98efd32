"""Curves that expressions of a scene may call."""

from __future__ import annotations

from typing import Annotated, Literal

from warpmuscle.scene.part import Part


class ExpressionCurve(Part):
    """A function of one number through knots (x, y), which goes on straight beyond them, as that of a `Displacement`.

    `ends`: `linear` joins the knots by straight lines, `natural` is a spline without curvature at its ends, `simm`
    OpenSim's SimmSpline.
    """

    x: Annotated[list[float], "1"]  # in the units of what the expression gives it
    y: Annotated[list[float], "1"]
    ends: Literal["simm", "natural", "linear"] = "simm"
