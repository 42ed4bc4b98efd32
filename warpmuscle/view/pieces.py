"""What a figure is made of: limbs, ellipsoids and hulls fixed to bodies; numbers only."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.pose import from_rotation_vector, rotate
from warpmuscle.scene import Box, Character, CylinderSurface, Scene, Shape, Sphere, SphereSurface, TorusSurface
from warpmuscle.scene.anatomy import Side, sides_of
from warpmuscle.scene.drawing.devices import device_rods
from warpmuscle.scene.initial_pose import plain_number, plain_vector

Layer = Literal["flesh", "bone", "hollow", "tendon", "surface", "shape", "object", "device"]
RING = 24  # pieces of a ring


class Limb(NamedTuple):
    """Two spheres and all between them, one sphere where start and end are the same; or a bar whose ends are flat."""

    body: int
    side: Side
    layer: Layer
    start: Floats  # (3,) m, in the body's frame
    end: Floats  # (3,) m
    radii: tuple[float, float]  # m, at start and end
    flat: bool = False  # ends, as of a cylinder to wrap around


class Ellipsoid(NamedTuple):
    """An ellipsoid about a point."""

    body: int
    side: Side
    layer: Layer
    position: Floats  # (3,) m, in the body's frame
    orientation: Floats  # (4,) to the body's frame
    radii: Floats  # (3,) m


class Hull(NamedTuple):
    """A body of triangles; its layer "hollow" is a dark bone."""

    body: int
    side: Side
    layer: Layer
    corners: Floats  # (V, 3) m, in the body's frame
    normals: Floats  # (V, 3)
    faces: Integers  # (F, 3), counter-clockwise from outside


class Block(NamedTuple):
    """A box along the axes of its body."""

    body: int
    side: Side
    layer: Layer
    position: Floats  # (3,) m, in the body's frame, of its middle
    radii: Floats  # (3,) m, half its edges


Piece = Limb | Ellipsoid | Block | Hull


def exact_shape(shape: Shape, body: int, side: Side) -> Piece:
    """A shape as the simulation knows it."""
    if isinstance(shape, Box):
        low, high = plain_vector(shape.low), plain_vector(shape.high)
        return Block(body, side, "shape", 0.5 * (low + high), 0.5 * (high - low))
    ends = (shape.center, shape.center) if isinstance(shape, Sphere) else (shape.start, shape.end)
    start, end = (plain_vector(each) for each in ends)
    return Limb(body, side, "shape", start, end, (plain_number(shape.radius),) * 2)


def surface_pieces(character: Character, muscles: Sequence[str], body_names: Sequence[str]) -> list[Piece]:
    """The surfaces that these muscles wrap around, of a character without free parameters."""
    used = {wrap.surface: None for name in muscles for wrap in character.muscles[name].wraps}
    sides = sides_of(character)
    found: list[Piece] = []
    for name in used:
        surface = character.surfaces[name]
        body, side = body_names.index(surface.body), sides[surface.body]
        place, turn = plain_vector(surface.position), from_rotation_vector(plain_vector(surface.orientation))
        if isinstance(surface, CylinderSurface):
            along = 0.5 * plain_number(surface.length) * rotate(turn, np.array([0.0, 0.0, 1.0]))
            radius = plain_number(surface.radius)
            found.append(Limb(body, side, "surface", place - along, place + along, (radius, radius), flat=True))
        elif isinstance(surface, TorusSurface):
            inner, outer = plain_number(surface.inner_radius), plain_number(surface.outer_radius)
            angle = np.linspace(0.0, 2.0 * np.pi, RING + 1)
            ring = 0.5 * (inner + outer) * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
            thick = 0.5 * (outer - inner)
            for start, end in itertools.pairwise(place + rotate(turn, ring)):
                found.append(Limb(body, side, "surface", start, end, (thick, thick)))
        else:
            radii = [surface.radius] * 3 if isinstance(surface, SphereSurface) else surface.radii
            size = np.array([plain_number(radius) for radius in radii])
            found.append(Ellipsoid(body, side, "surface", place, turn, size))
    return found


def device_pieces(scene: Scene, body_names: Sequence[str]) -> list[Piece]:
    """The devices that a scene without free parameters puts on its character."""
    sides = sides_of(scene.character)
    return [
        Limb(body_names.index(rod.body), sides[rod.body], "device", rod.start, rod.end, (rod.radius,) * 2, rod.flat)
        for rod in device_rods(scene)
    ]
