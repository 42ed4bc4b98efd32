"""A character as unit spheres, cylinders and boxes that move with its bodies; numbers only."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import about, from_rotation_vector, normalized, rotate
from warpmuscle.scene import Character, CylinderSurface, SphereSurface, TorusSurface
from warpmuscle.scene.anatomy import Side, sides_of, solids
from warpmuscle.scene.initial_pose import plain_number, plain_vector

Kind = Literal["sphere", "cylinder", "box"]
RING = 24  # pieces of a ring
SHORTEST = 1e-9  # m, of what has a direction
UNTURNED = np.array([0.0, 0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Part:
    """A unit primitive fixed to a body.

    A sphere has the radius 1, a cylinder the radius 1 and the length 1 along y, a box edges of 1; all about their
    middle.
    """

    kind: Kind
    body: int
    side: Side
    bone: bool  # a line between joints rather than a shape of the scene
    position: Floats  # (3,) m, in the body's frame
    orientation: Floats  # (4,) to the body's frame
    size: Floats  # (3,) m, factors along the primitive's own axes


def parts_of(character: Character, body_names: Sequence[str]) -> list[Part]:
    """The shapes of a character without free parameters, and its bones."""
    parts: list[Part] = []
    for solid in solids(character):
        body = body_names.index(solid.body)
        start, end = solid.ends
        if solid.radius is None:
            parts.append(Part("box", body, solid.side, False, (start + end) / 2.0, UNTURNED, end - start))
        elif solid.bone:
            parts += _cylinder(start, end, solid.radius, body, solid.side, bone=True)
        else:
            caps = [Part("sphere", body, solid.side, False, point, UNTURNED, np.full(3, solid.radius))
                    for point in solid.ends]  # fmt: skip
            cylinder = _cylinder(start, end, solid.radius, body, solid.side, bone=False)
            parts += [*cylinder, *caps] if cylinder else caps[:1]
    return parts


def surface_parts(character: Character, muscles: Sequence[str], body_names: Sequence[str]) -> list[Part]:
    """The surfaces that these muscles wrap around, of a character without free parameters."""
    used = {wrap.surface: None for name in muscles for wrap in character.muscles[name].wraps}
    sides = sides_of(character)
    found: list[Part] = []
    for name in used:
        surface = character.surfaces[name]
        body, side = body_names.index(surface.body), sides[surface.body]
        place, turn = plain_vector(surface.position), from_rotation_vector(plain_vector(surface.orientation))
        if isinstance(surface, CylinderSurface):
            along = 0.5 * plain_number(surface.length) * rotate(turn, np.array([0.0, 0.0, 1.0]))
            radius = plain_number(surface.radius)
            found += _cylinder(place - along, place + along, radius, body, side, bone=False)
        elif isinstance(surface, TorusSurface):
            inner, outer = plain_number(surface.inner_radius), plain_number(surface.outer_radius)
            angle = np.linspace(0.0, 2.0 * np.pi, RING + 1)
            ring = 0.5 * (inner + outer) * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
            corners = place + rotate(turn, ring)
            for start, end in itertools.pairwise(corners):
                found += _cylinder(start, end, 0.5 * (outer - inner), body, side, bone=False)
        else:
            radii = [surface.radius] * 3 if isinstance(surface, SphereSurface) else surface.radii
            size = np.array([plain_number(radius) for radius in radii])
            found.append(Part("sphere", body, side, False, place, turn, size))
    return found


def _cylinder(start: Floats, end: Floats, radius: float, body: int, side: Side, bone: bool) -> list[Part]:
    """A cylinder; nothing if it has no length."""
    length = float(np.linalg.norm(end - start))
    if length < SHORTEST:
        return []
    size = np.array([radius, length, radius])
    return [Part("cylinder", body, side, bone, (start + end) / 2.0, turn_from_y(end - start), size)]


def turn_from_y(direction: Floats) -> Floats:
    """Quaternions (..., 4) of the shortest turns from the y axis to directions (..., 3) of any length but 0."""
    d = normalized(direction)
    q = np.stack([d[..., 2], np.zeros_like(d[..., 0]), -d[..., 0], 1.0 + d[..., 1]], axis=-1)
    opposite = q[..., 3] < 1e-9  # straight down, where the axis does not matter
    q[opposite] = about(np.array([1.0, 0.0, 0.0]), np.pi)
    return normalized(q)
