"""Shapes that collide, and what they are made of."""

from __future__ import annotations

from typing import Annotated

from warpmuscle.scene.number import Number, Vector
from warpmuscle.scene.part import ABOVE_0, FROM_0, Part


class ContactMaterial(Part):
    """What a sphere and the ground are made of in Hunt-Crossley contact; the numbers are OpenSim's, see `Ground`.

    They count for both sides; of different ones, harmonic means stand for stiffness to the power 2/3 and frictions.
    """

    stiffness: Annotated[Number, "N/m^2", FROM_0] = 1.0e6  # of plane strain; 0: it does not touch the ground
    dissipation: Annotated[Number, "s/m", FROM_0] = 2.0
    static_friction: Annotated[Number, "1", FROM_0] = 0.8
    dynamic_friction: Annotated[Number, "1", FROM_0] = 0.8
    viscous_friction: Annotated[Number, "s/m", FROM_0] = 0.5
    transition_velocity: Annotated[Number, "m/s", ABOVE_0] = 0.2  # of slip, at which friction is greatest
    hertz_smoothing: Annotated[Number, "1/m", ABOVE_0] = 300.0  # this and the following of the smooth law only
    hunt_crossley_smoothing: Annotated[Number, "s/m", ABOVE_0] = 50.0
    constant_force: Annotated[Number, "1", ABOVE_0] = 1.0e-5  # added to squares of depth, m^2, and of slip, m^2/s^2


class Sphere(Part, tag_field="type", tag="sphere"):
    """Collision sphere in body coordinates, m."""

    center: Annotated[Vector, "m"]
    radius: Annotated[Number, "m", ABOVE_0]
    material: ContactMaterial | None = None  # in Hunt-Crossley contact, in place of the ground's


class Capsule(Part, tag_field="type", tag="capsule"):
    """Collision capsule: a segment from `start` to `end` (centres of its caps) swept by a sphere, m."""

    start: Annotated[Vector, "m"]
    end: Annotated[Vector, "m"]
    radius: Annotated[Number, "m", FROM_0]
    material: ContactMaterial | None = None


class Box(Part, tag_field="type", tag="box"):
    """Collision box, aligned with the body axes, between two opposite corners, m."""

    low: Annotated[Vector, "m"]
    high: Annotated[Vector, "m"]


Shape = Sphere | Capsule | Box
