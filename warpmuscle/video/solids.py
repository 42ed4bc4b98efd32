"""A character as capsules and boxes, and outlines of these in a picture; numbers only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import rotate
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import sides_of, solids
from warpmuscle.scene.drawing.devices import device_rods

_ARC = 12  # points on each round end of an outline
_FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))  # of corners in x, y, z


@dataclass(frozen=True)
class Capsules:
    """C capsules fixed to bodies; spheres are those without length."""

    body: NDArray[np.int64]  # (C,)
    ends: Floats  # (C, 2, 3) m, in the body's frame
    radius: Floats  # (C,) m
    side: tuple[str, ...]  # a `Side`, or "object"
    bone: NDArray[np.bool_]  # (C,) a line between joints rather than a shape of the scene
    device: NDArray[np.bool_]  # (C,) a part of a device


@dataclass(frozen=True)
class Boxes:
    """B boxes fixed to bodies."""

    body: NDArray[np.int64]  # (B,)
    corners: Floats  # (B, 8, 3) m, in the body's frame
    side: tuple[str, ...]


def capsules_and_boxes(scene: Scene, body_names: Sequence[str]) -> tuple[Capsules, Boxes]:
    """Shapes, bones and devices of a numeric scene."""
    every, rods, sides = solids(scene.character), device_rods(scene), sides_of(scene.character)
    round_ones = [(solid, solid.radius) for solid in every if solid.radius is not None]
    boxes = [solid for solid in every if solid.radius is None]
    corners = [np.stack(np.meshgrid(*box.ends.T, indexing="ij"), axis=-1) for box in boxes]
    return (
        Capsules(
            np.array(
                [body_names.index(name) for name in [*(s.body for s, _ in round_ones), *(r.body for r in rods)]],
                dtype=int,
            ),
            np.reshape([*(solid.ends for solid, _ in round_ones), *((rod.start, rod.end) for rod in rods)], (-1, 2, 3)),
            np.array([*(radius for _, radius in round_ones), *(rod.radius for rod in rods)]),
            (*(solid.side for solid, _ in round_ones), *(sides[rod.body] for rod in rods)),
            np.array([*(solid.bone for solid, _ in round_ones), *(False for _ in rods)], dtype=bool),
            np.array([*(False for _ in round_ones), *(True for _ in rods)], dtype=bool),
        ),
        Boxes(
            np.array([body_names.index(box.body) for box in boxes], dtype=int),
            np.reshape(corners, (-1, 8, 3)),
            tuple(box.side for box in boxes),
        ),
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
