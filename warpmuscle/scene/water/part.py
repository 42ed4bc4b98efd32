"""What a scene says of water."""

from __future__ import annotations

from typing import Annotated, Literal

from warpmuscle.scene.number import Number
from warpmuscle.scene.part import ABOVE_0, FROM_0, Part


class Water(Part):
    """Water up to a level: it carries, brakes, and has to be moved along.

    Each body is a capsule in it. By `mass`, one about its centre of mass along its axis of least inertia, as large as
    its mass at the density of bodies, and as long as its inertia says. By `shapes`, those of its shapes: boxes are the
    capsules inside them.
    """

    level: Annotated[Number, "m"] = 0.0  # y of the surface
    density: Annotated[Number, "kg/m^3", ABOVE_0] = 1000.0
    body_density: Annotated[Number, "kg/m^3", ABOVE_0] = 1000.0  # by which masses have volumes
    volume: Literal["mass", "shapes"] = "mass"  # what says how large bodies are
    drag: Annotated[Number, "1", FROM_0] = 1.0  # coefficient of bodies that move across their length, and of balls
    axial_drag: Annotated[Number, "1", FROM_0] = 0.3  # along their length, by their cross-section
    added_mass: Annotated[Number, "1", FROM_0] = 1.0  # times that of spheroids
    current: Annotated[Number, "m/s"] = 0.0  # of the water, forwards
