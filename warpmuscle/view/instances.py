"""One moment of several bipeds as instances of unit primitives in the world; numbers only.

What a primitive measures is said in `parts.Part`; a cone has the radius 1 at its base and the length 1 along y.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpmuscle.pose import multiply, rotate
from warpmuscle.recording import Floats
from warpmuscle.view.colors import BONE, COM, DESIRED, FORCES, TINTS, Bytes, of_activation
from warpmuscle.view.muscle_lines import world_points
from warpmuscle.view.parts import Kind, Part, turn_from_y
from warpmuscle.view.track import Doll, Track

MUSCLE_RADIUS = (0.005, 0.015)  # m, without force and with the greatest
FORCE_LENGTH = 0.7  # m that a force of one body weight is drawn as
LEAST_FORCE = 0.02  # body weights, below which no arrow is drawn
SHAFT, HEAD, HEAD_LENGTH = 0.011, 0.03, 0.09  # m, of arrows
COM_RADIUS = 0.035  # m
UNTURNED = np.array([0.0, 0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Instances:
    """n instances of one primitive."""

    position: Floats  # (n, 3) m
    orientation: Floats  # (n, 4)
    size: Floats  # (n, 3) m
    color: Bytes  # (n, 3)

    def __len__(self) -> int:
        """Number of instances."""
        return len(self.position)


def joined(parts: Sequence[Instances]) -> Instances:
    """Instances one behind the other; at least one part."""
    fields = ("position", "orientation", "size", "color")
    return Instances(*(np.concatenate([getattr(part, name) for part in parts]) for name in fields))


def solids(doll: Doll, kind: Kind, bones: bool, position: Floats, orientation: Floats) -> Instances:
    """Shapes of one kind, or the bones of that kind, with bodies at (B, 3) and (B, 4)."""
    parts = [part for part in doll.parts if part.kind == kind and part.bone == bones]
    body = np.array([part.body for part in parts], dtype=np.int64)
    turned = orientation[body].reshape(-1, 4)
    return Instances(
        position[body].reshape(-1, 3) + rotate(turned, _table(parts, "position", 3)),
        multiply(turned, _table(parts, "orientation", 4)),
        _table(parts, "size", 3),
        np.array([BONE if bones else TINTS[part.side] for part in parts], dtype=np.uint8).reshape(-1, 3),
    )


def _table(parts: Sequence[Part], field: str, width: int) -> Floats:
    return np.array([getattr(part, field) for part in parts], dtype=np.float64).reshape(-1, width)


def tubes(start: Floats, end: Floats, radius: Floats, color: Bytes) -> Instances:
    """Cylinders from points (n, 3) to points (n, 3), with radii (n,), m."""
    along = end - start
    length = np.linalg.norm(along, axis=-1)
    direction = np.where(length[:, None] > 1e-9, along, np.array([0.0, 1.0, 0.0]))
    size = np.stack([radius, length, radius], axis=-1)
    return Instances((start + end) / 2.0, turn_from_y(direction), size, color)


def muscles(track: Track, frame: int, offset: Floats) -> Instances:
    """Cylinders along all muscles, coloured by activation and thick by force."""
    lines, r, one = track.doll.muscles, track.recording, slice(frame, frame + 1)
    points = world_points(lines, r.body_position[one], r.body_orientation[one], track.point_weight[one])[0] + offset
    owner = np.repeat(np.arange(len(lines.names)), np.diff(lines.start))
    inner = np.flatnonzero(owner[1:] == owner[:-1])  # segments, by their first point
    low, high = MUSCLE_RADIUS
    radius = (low + (high - low) * track.muscle_load[frame])[owner[inner]]
    color = of_activation(r.muscle_activation[frame])[owner[inner]]
    return tubes(points[inner], points[inner + 1], radius, color)


def arrows(track: Track, frame: int, offset: Floats) -> tuple[Instances, Instances]:
    """Shafts and heads of the ground forces on both feet; a force too small to be seen has no size."""
    force = np.asarray(track.foot_force[frame], dtype=np.float64)
    strength = np.linalg.norm(force, axis=-1) / track.doll.weight
    seen = strength >= LEAST_FORCE
    length = np.where(seen, FORCE_LENGTH * strength, 0.0)[:, None]
    direction = np.where(seen[:, None], force, np.array([0.0, 1.0, 0.0]))
    direction = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    start = track.foot_center[frame] + offset
    head = np.minimum(HEAD_LENGTH, length)
    neck = start + direction * (length - head)
    colors = np.array(FORCES, dtype=np.uint8)
    shafts = tubes(start, neck, np.where(seen, SHAFT, 0.0), colors)
    width = np.where(seen, HEAD, 0.0)
    size = np.stack([width, head[:, 0], width], axis=-1)
    return shafts, Instances(neck + direction * head / 2.0, turn_from_y(direction), size, colors)


def mass_center(track: Track, frame: int, offset: Floats) -> Instances:
    """A sphere at the centre of mass."""
    position = np.asarray(track.recording.com[frame : frame + 1] + offset)
    return Instances(position, UNTURNED[None], np.full((1, 3), COM_RADIUS), np.array([COM], dtype=np.uint8))


def desired(track: Track, frame: int, kind: Kind, offset: Floats) -> Instances:
    """Shapes and bones of one kind in the pose that the controller wants; none without a controller."""
    if track.desired is None:
        nothing = np.zeros((0, 3))
        return Instances(nothing, np.zeros((0, 4)), nothing, np.zeros((0, 3), dtype=np.uint8))
    orientation = track.desired[frame : frame + 1]
    position = track.doll.positions(track.recording.root_position[frame : frame + 1], orientation)[0] + offset
    both = joined([solids(track.doll, kind, bones, position, orientation[0]) for bones in (False, True)])
    return Instances(
        both.position, both.orientation, both.size, np.broadcast_to(np.array(DESIRED, np.uint8), both.color.shape)
    )
