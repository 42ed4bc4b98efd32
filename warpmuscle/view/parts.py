"""A character as unit spheres, cylinders and boxes that move with its bodies; numbers only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import about, normalized
from warpmuscle.scene import Box, Capsule, Character, Shape
from warpmuscle.scene.anatomy import Side, bones, sides_of

Kind = Literal["sphere", "cylinder", "box"]
BONE_RADIUS = 0.016  # m
SHORTEST = 1e-9  # m, of what has a direction
Y = np.array([0.0, 1.0, 0.0])


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
    """The shapes of a character without free parameters, and bones between its joints where shapes leave gaps."""
    sides = sides_of(character)
    parts: list[Part] = []
    for number, name in enumerate(body_names):
        side = sides[name]
        for shape in character.bodies[name].shapes:
            parts += _shape_parts(shape, number, side)
        starts = [_vector(joint.position_in_child) for joint in character.joints.values() if joint.child == name]
        ends = [_vector(joint.position_in_parent) for joint in character.joints.values() if joint.parent == name]
        if not starts and len(ends) == 1:
            starts = [np.zeros(3)]
        for line in bones(starts[0] if starts else np.mean(ends or [np.zeros(3)], axis=0), ends):
            parts += _bone(line[0], line[1], number, side)
    return parts


def _shape_parts(shape: Shape, body: int, side: Side) -> list[Part]:
    unturned = np.array([0.0, 0.0, 0.0, 1.0])
    if isinstance(shape, Box):
        low, high = _vector(shape.low), _vector(shape.high)
        return [Part("box", body, side, False, (low + high) / 2.0, unturned, high - low)]
    radius = float(_vector([shape.radius])[0])
    if isinstance(shape, Capsule):
        return _capsule(_vector(shape.start), _vector(shape.end), radius, body, side)
    return [Part("sphere", body, side, False, _vector(shape.center), unturned, np.full(3, radius))]


def _capsule(start: Floats, end: Floats, radius: float, body: int, side: Side) -> list[Part]:
    """A cylinder between two spheres; one sphere if it has no length."""
    unturned, ball = np.array([0.0, 0.0, 0.0, 1.0]), np.full(3, radius)
    caps = [Part("sphere", body, side, False, point, unturned, ball) for point in (start, end)]
    length = float(np.linalg.norm(end - start))
    if length < SHORTEST:
        return caps[:1]
    size = np.array([radius, length, radius])
    return [Part("cylinder", body, side, False, (start + end) / 2.0, turn_from_y(end - start), size), *caps]


def _bone(start: Floats, end: Floats, body: int, side: Side) -> list[Part]:
    """A thin cylinder; nothing if it has no length."""
    length = float(np.linalg.norm(end - start))
    if length < SHORTEST:
        return []
    size = np.array([BONE_RADIUS, length, BONE_RADIUS])
    return [Part("cylinder", body, side, True, (start + end) / 2.0, turn_from_y(end - start), size)]


def turn_from_y(direction: Floats) -> Floats:
    """Quaternions (..., 4) of the shortest turns from the y axis to directions (..., 3) of any length but 0."""
    d = normalized(direction)
    q = np.stack([d[..., 2], np.zeros_like(d[..., 0]), -d[..., 0], 1.0 + d[..., 1]], axis=-1)
    opposite = q[..., 3] < 1e-9  # straight down, where the axis does not matter
    q[opposite] = about(np.array([1.0, 0.0, 0.0]), np.pi)
    return normalized(q)


def _vector(numbers: Sequence[object]) -> Floats:
    return np.array(numbers, dtype=np.float64)
