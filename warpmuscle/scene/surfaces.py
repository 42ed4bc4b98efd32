"""Surfaces that muscles wrap around, fixed to bodies.

A surface has axes of its own: `position` is its centre, from the body's centre of mass, m, and `orientation` the
rotation vector, rad, that turns the body's axes to its own. `side` is the half of it that a path must stay on, such as
"+x" for that with x > 0 in its own axes (OpenSim's quadrant); if empty, a path goes round whichever side is shorter.
All numbers may be free parameters.
"""

from __future__ import annotations

from typing import Annotated, Literal

from warpmuscle.scene.number import Number, Vector
from warpmuscle.scene.part import ABOVE_0, FROM_0, Part

HalfSpace = Literal["", "+x", "-x", "+y", "-y", "+z", "-z"]


class CylinderSurface(Part, tag_field="type", tag="cylinder"):
    """A cylinder about its z axis; `length` is where a path that crosses its axis touches it, beyond it has no end."""

    body: str
    position: Annotated[Vector, "m"]
    radius: Annotated[Number, "m", ABOVE_0]
    length: Annotated[Number, "m", FROM_0]
    orientation: Annotated[Vector, "rad"] = (0.0, 0.0, 0.0)
    side: HalfSpace = ""
    side_point: Annotated[Vector | None, "m"] = None  # of MuJoCo's wrapping, from the centre, in the surface's axes


class SphereSurface(Part, tag_field="type", tag="sphere"):
    """A sphere."""

    body: str
    position: Annotated[Vector, "m"]
    radius: Annotated[Number, "m", ABOVE_0]
    orientation: Annotated[Vector, "rad"] = (0.0, 0.0, 0.0)
    side: HalfSpace = ""
    side_point: Annotated[Vector | None, "m"] = None  # of MuJoCo's wrapping, from the centre, in the surface's axes


class EllipsoidSurface(Part, tag_field="type", tag="ellipsoid"):
    """An ellipsoid along its axes."""

    body: str
    position: Annotated[Vector, "m"]
    radii: Annotated[Vector, "m", ABOVE_0]
    orientation: Annotated[Vector, "rad"] = (0.0, 0.0, 0.0)
    side: HalfSpace = ""


class TorusSurface(Part, tag_field="type", tag="torus"):
    """A ring about its z axis, through whose hole a path runs.

    As OpenSim's wrapping takes them, the outer radius is that of the circle in the ring's middle, and the inner one
    that of its round section.
    """

    body: str
    position: Annotated[Vector, "m"]
    inner_radius: Annotated[Number, "m", ABOVE_0]
    outer_radius: Annotated[Number, "m", ABOVE_0]
    orientation: Annotated[Vector, "rad"] = (0.0, 0.0, 0.0)
    side: HalfSpace = ""


Surface = CylinderSurface | SphereSurface | EllipsoidSurface | TorusSurface
