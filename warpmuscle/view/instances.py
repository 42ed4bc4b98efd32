"""Moments of bipeds as instances of unit primitives in the world; numbers only.

What a primitive measures is said in `parts.Part`; a cone has the radius 1 at its base and the length 1 along y.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import multiply, rotate
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


@dataclass(frozen=True)
class Moment:
    """T bipeds of the same doll, each at a moment of its own; places are m, world."""

    doll: Doll
    position: Floats  # (T, B, 3) of the bodies
    orientation: Floats  # (T, B, 4)
    slid: Floats  # (T, K, 3), see `Track.slid`
    desired: Floats | None  # (T, B, 4), see `Track.desired`
    root: Floats  # (T, 3)
    com: Floats  # (T, 3)
    point_weight: Floats  # (T, C)
    routed: Floats  # (T, R, 3), see `muscle_lines.Routes`
    activation: Floats  # (T, M)
    load: Floats  # (T, M)
    foot_force: Floats  # (T, 2, 3) N
    foot_center: Floats  # (T, 2, 3)


def moments_of(tracks: Sequence[Track], frames: Sequence[int], offsets: Floats) -> list[Moment]:
    """Tracks at a frame each, moved by offsets (n, 3), m: those of the same doll together, in their order."""
    groups: dict[tuple[int, bool], list[int]] = {}
    for number, track in enumerate(tracks):
        groups.setdefault((id(track.doll), track.desired is None), []).append(number)
    return [
        _moment([tracks[k] for k in group], [frames[k] for k in group], offsets[group]) for group in groups.values()
    ]


def _moment(tracks: Sequence[Track], frames: Sequence[int], offset: Floats) -> Moment:
    def stacked(array_of: Callable[[Track], Floats]) -> Floats:
        return np.stack([array_of(track)[frame] for track, frame in zip(tracks, frames, strict=True)])

    desired = None
    if all(track.desired is not None for track in tracks):
        desired = np.stack([t.desired[frame] for t, frame in zip(tracks, frames, strict=True) if t.desired is not None])
    return Moment(
        doll=tracks[0].doll,
        position=stacked(lambda track: track.recording.body_position) + offset[:, None],
        orientation=stacked(lambda track: track.recording.body_orientation),
        slid=stacked(lambda track: track.slid),
        desired=desired,
        root=stacked(lambda track: track.recording.root_position) + offset,
        com=stacked(lambda track: track.recording.com) + offset,
        point_weight=stacked(lambda track: track.point_weight),
        routed=np.stack([t.routes.at(frame) for t, frame in zip(tracks, frames, strict=True)]) + offset[:, None],
        activation=stacked(lambda track: track.recording.muscle_activation),
        load=stacked(lambda track: track.muscle_load),
        foot_force=stacked(lambda track: track.foot_force),
        foot_center=stacked(lambda track: track.foot_center) + offset[:, None],
    )


def solids(moment: Moment, kind: Kind, bones: bool) -> Instances:
    """Shapes of one kind, or the bones of that kind."""
    return _solids(moment.doll, kind, bones, moment.position, moment.orientation)


def _solids(doll: Doll, kind: Kind, bones: bool, position: Floats, orientation: Floats) -> Instances:
    """The same with bodies at (T, B, 3) and (T, B, 4)."""
    parts = [part for part in doll.parts if part.kind == kind and part.bone == bones]
    body = np.array([part.body for part in parts], dtype=np.int64)
    turned, count = orientation[:, body], len(position)
    place = position[:, body] + rotate(turned, _table(parts, "position", 3))
    color = np.array([BONE if bones else TINTS[part.side] for part in parts], dtype=np.uint8).reshape(-1, 3)
    return Instances(
        place.reshape(-1, 3),
        multiply(turned, _table(parts, "orientation", 4)).reshape(-1, 4),
        np.tile(_table(parts, "size", 3), (count, 1)),
        np.tile(color, (count, 1)),
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


def muscles(moment: Moment) -> Instances:
    """Cylinders along all muscles, coloured by activation and thick by force."""
    lines = moment.doll.muscles
    points = world_points(lines, moment.position, moment.orientation, moment.point_weight, moment.routed)
    owner = np.repeat(np.arange(len(lines.names)), np.diff(lines.start))
    inner = np.flatnonzero(owner[1:] == owner[:-1])  # segments, by their first point
    low, high = MUSCLE_RADIUS
    radius = (low + (high - low) * moment.load)[:, owner[inner]]
    color = of_activation(moment.activation)[:, owner[inner]]
    ends = (points[:, inner].reshape(-1, 3), points[:, inner + 1].reshape(-1, 3))
    return tubes(*ends, radius.ravel(), color.reshape(-1, 3))


def arrows(moment: Moment) -> tuple[Instances, Instances]:
    """Shafts and heads of the ground forces on both feet; a force too small to be seen has no size."""
    force = moment.foot_force.reshape(-1, 3).astype(np.float64)
    strength = np.linalg.norm(force, axis=-1) / moment.doll.weight
    seen = strength >= LEAST_FORCE
    length = np.where(seen, FORCE_LENGTH * strength, 0.0)[:, None]
    direction = np.where(seen[:, None], force, np.array([0.0, 1.0, 0.0]))
    direction = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    start = moment.foot_center.reshape(-1, 3)
    head = np.minimum(HEAD_LENGTH, length)
    neck = start + direction * (length - head)
    colors = np.tile(np.array(FORCES, dtype=np.uint8), (len(force) // 2, 1))
    shafts = tubes(start, neck, np.where(seen, SHAFT, 0.0), colors)
    width = np.where(seen, HEAD, 0.0)
    size = np.stack([width, head[:, 0], width], axis=-1)
    return shafts, Instances(neck + direction * head / 2.0, turn_from_y(direction), size, colors)


def mass_center(moment: Moment) -> Instances:
    """A sphere at the centre of mass of each."""
    count = len(moment.com)
    color = np.tile(np.array([COM], dtype=np.uint8), (count, 1))
    return Instances(moment.com, np.tile(UNTURNED, (count, 1)), np.full((count, 3), COM_RADIUS), color)


def desired(moment: Moment, kind: Kind) -> Instances:
    """Shapes and bones of one kind in the pose that is wanted; none where none is."""
    if moment.desired is None:
        nothing = np.zeros((0, 3))
        return Instances(nothing, np.zeros((0, 4)), nothing, np.zeros((0, 3), dtype=np.uint8))
    position = moment.doll.positions(moment.root, moment.desired, moment.slid)
    both = joined([_solids(moment.doll, kind, bones, position, moment.desired) for bones in (False, True)])
    return Instances(
        both.position, both.orientation, both.size, np.broadcast_to(np.array(DESIRED, np.uint8), both.color.shape)
    )
