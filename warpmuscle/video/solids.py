"""A character as capsules and boxes, and outlines of these in a picture; numbers only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import rotate
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Box, Capsule, Character
from warpmuscle.scene.anatomy import Side, bones, far_end, sides_of

BONE_RADIUS = 0.018  # m
_ARC = 12  # points on each round end of an outline
_FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))  # of corners in x, y, z


@dataclass(frozen=True)
class Capsules:
    """C capsules fixed to bodies; spheres are those without length."""

    body: NDArray[np.int64]  # (C,)
    ends: Floats  # (C, 2, 3) m, in the body's frame
    radius: Floats  # (C,) m
    side: tuple[Side, ...]
    bone: NDArray[np.bool_]  # (C,) a line between joints rather than a shape of the scene


@dataclass(frozen=True)
class Boxes:
    """B boxes fixed to bodies."""

    body: NDArray[np.int64]  # (B,)
    corners: Floats  # (B, 8, 3) m, in the body's frame
    side: tuple[Side, ...]


def solids(character: Character, body_names: tuple[str, ...]) -> tuple[Capsules, Boxes]:
    """Shapes of a numeric character, and bones between its joints."""
    sides = sides_of(character)
    capsules: list[tuple[int, Floats, float, Side, bool]] = []
    boxes: list[tuple[int, Floats, Side]] = []
    for number, name in enumerate(body_names):
        for shape in character.bodies[name].shapes:
            if isinstance(shape, Box):
                ends = np.array([shape.low, shape.high], dtype=float)
                corners = np.stack(np.meshgrid(*ends.T, indexing="ij"), axis=-1).reshape(8, 3)
                boxes.append((number, corners, sides[name]))
            else:
                span = (shape.start, shape.end) if isinstance(shape, Capsule) else (shape.center, shape.center)
                radius = float(np.asarray(shape.radius))
                capsules.append((number, np.array(span, dtype=float), radius, sides[name], False))
        for line in _lines(character, name):
            capsules.append((number, np.asarray(line, dtype=float), BONE_RADIUS, sides[name], True))
    bodies, places, radii, sides_, bone = zip(*capsules, strict=True) if capsules else ((), (), (), (), ())
    round_ones = (np.array(bodies, dtype=int), np.reshape(places, (-1, 2, 3)), np.array(radii), sides_)
    return (
        Capsules(*round_ones, np.array(bone, dtype=bool)),
        Boxes(np.array([b[0] for b in boxes], dtype=int), np.reshape([b[1] for b in boxes], (-1, 8, 3)),
              tuple(b[2] for b in boxes)),
    )  # fmt: skip


def _lines(character: Character, name: str) -> list[Floats]:
    """Bones of a body: from its joint to its children's, or into the shapes of a body that has none."""
    joints = character.joints.values()
    starts = [np.array(joint.position_in_child, dtype=float) for joint in joints if joint.child == name]
    ends = [np.array(joint.position_in_parent, dtype=float) for joint in joints if joint.parent == name]
    start = starts[0] if starts else np.zeros(3)
    return (
        bones(start, ends)
        if ends or not starts
        else [np.stack([start, far_end(shape, start)]) for shape in character.bodies[name].shapes]
    )


def in_world(recording: Recording, body: NDArray[np.int64], points: Floats) -> Floats:
    """Points (F, n, m, 3), m, world, of points (n, m, 3) in the frames of bodies (n,)."""
    turned = rotate(recording.body_orientation[:, body, None], points)
    return np.asarray(recording.body_position[:, body, None] + turned)


def outlines(ends: Floats, radius: Floats) -> Floats:
    """Outlines (n, 2 k, 2) of capsules in a picture, from circles about their ends (n, 2, 2) with radii (n, 2)."""
    along = ends[:, 1] - ends[:, 0]
    length = np.maximum(np.linalg.norm(along, axis=1), 1e-9)
    direction = np.arctan2(along[:, 1], along[:, 0])
    lean = np.arccos(np.clip((radius[:, 0] - radius[:, 1]) / length, -1.0, 1.0))  # from there to where the sides touch
    part = np.linspace(0.0, 1.0, _ARC)
    first = (direction + lean)[:, None] + part * (2.0 * np.pi - 2.0 * lean)[:, None]
    second = (direction - lean)[:, None] + part * (2.0 * lean)[:, None]
    arcs = [
        ends[:, k, None] + radius[:, k, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        for k, angle in enumerate((first, second))
    ]
    return np.concatenate(arcs, axis=1)


def faces(corners: Floats) -> Floats:
    """The six faces (6, 4, 3) of a box with these corners (8, 3), each counter-clockwise from outside."""
    return np.asarray(corners[np.array(_FACES)])
