"""Muscles as polylines with a constant number of points; numbers only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import conjugate, normalized, rotate
from warpmuscle.results.joint_poses import joint_angles
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Character, Condition, ViaPoint
from warpmuscle.scene.validation.paths import is_route
from warpmuscle.scene.wrapping.polylines import drawn_count, drawn_route


@dataclass(frozen=True)
class MuscleLines:
    """Points of M muscles, P in all, one muscle behind the other: via points, or those of a route that is drawn."""

    names: tuple[str, ...]
    start: NDArray[np.int64]  # (M + 1,) points of muscle m are start[m]..start[m + 1] - 1
    body: NDArray[np.int64]  # (P,) number of the body that a point is fixed to
    place: Floats  # (P, 3) m, in the body's frame
    conditional: NDArray[np.int64]  # (C,) numbers of the points that count only at some joint angles
    conditions: tuple[Condition, ...]  # C of them
    routes: tuple[str, ...]  # muscles that wrap, or whose points move or come in at once
    routed: NDArray[np.int64]  # (R,) numbers of their points


def muscle_lines(character: Character, muscles: Sequence[str], body_names: Sequence[str]) -> MuscleLines:
    """Paths of muscles of a character without free parameters."""
    routes = [name for name in muscles if is_route(character.muscles[name])]
    nowhere = ViaPoint(character.root, (0.0, 0.0, 0.0))
    paths = [
        [nowhere] * drawn_count(character.muscles[name]) if name in routes else character.muscles[name].path
        for name in muscles
    ]
    points = [point for path in paths for point in path]
    conditional = [number for number, point in enumerate(points) if point.condition is not None]
    return MuscleLines(
        names=tuple(muscles),
        start=np.cumsum([0, *(len(path) for path in paths)]),
        body=np.array([body_names.index(point.body) for point in points], dtype=np.int64),
        place=np.array([point.place() for point in points], dtype=np.float64).reshape(-1, 3),
        conditional=np.array(conditional, dtype=np.int64),
        conditions=tuple(point.condition for point in points if point.condition is not None),
        routes=tuple(routes),
        routed=np.array([number for number, point in enumerate(points) if point is nowhere], dtype=np.int64),
    )


def point_weights(lines: MuscleLines, recording: Recording, character: Character) -> Floats:
    """How much each conditional point counts over time, (F, C), 0..1, as `conditions.condition_weight` has it."""
    weights = np.ones((recording.frames, len(lines.conditions)))
    for number, condition in enumerate(lines.conditions):
        angle = _angle(recording, character, condition)
        low, high, blend = (float(np.asarray(x)) for x in (condition.low, condition.high, condition.blend))
        weights[:, number] = _smooth_step((angle - low) / blend + 0.5) * _smooth_step((high - angle) / blend + 0.5)
    return weights


def _angle(recording: Recording, character: Character, condition: Condition) -> Floats:
    """The joint angle (F,), rad, that a condition is about."""
    return joint_angles(recording, character, condition.joint)[:, condition.axis]


def _smooth_step(x: Floats) -> Floats:
    t = np.clip(x, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))


class Routes:
    """Where the routes among muscles run in the frames of a recording, each computed when it is asked for."""

    def __init__(self, lines: MuscleLines, recording: Recording, character: Character) -> None:
        """Take over a recording of a character without free parameters."""
        self._lines, self._recording, self._character = lines, recording, character
        muscles = [character.muscles[name] for name in lines.routes]
        needed = {point.condition.joint for m in muscles for point in m.path if point.condition is not None}
        needed |= {motion.joint for m in muscles for point in m.path for motion in point.motion}
        self._angles = {name: joint_angles(recording, character, name) for name in needed}
        self._known: dict[int, Floats] = {}

    def at(self, frame: int) -> Floats:
        """Points (R, 3) in a frame, m, world."""
        if frame not in self._known:
            r = self._recording
            places = zip(r.body_position[frame].astype(float), normalized(r.body_orientation[frame]), strict=True)
            poses = dict(zip(r.body_names, places, strict=True))
            angles = {name: values[frame] for name, values in self._angles.items()}
            muscles = (self._character.muscles[name] for name in self._lines.routes)
            drawn = [drawn_route(self._character, muscle, poses, angles) for muscle in muscles]
            self._known[frame] = np.concatenate([np.zeros((0, 3)), *drawn])
        return self._known[frame]

    def all(self) -> Floats:
        """Points (F, R, 3) in all frames."""
        every = [self.at(frame) for frame in range(self._recording.frames)]
        return np.array(every).reshape(len(every), -1, 3)


def in_bodies(points: Floats, position: Floats, orientation: Floats) -> tuple[NDArray[np.int64], Floats]:
    """Points (F, R, 3), m, world, of routes in the frames of those bodies in which each of them moves least.

    That a point is carried by a body need not be stored then, but only that it slides over it.

    Args:
        position: (F, B, 3) of the bodies, m. orientation: (F, B, 4), of unit length.

    Returns:
        Numbers of the bodies (R,), and points (F, R, 3), m.
    """
    count = points.shape[1]
    bodies, least, places = np.zeros(count, dtype=np.int64), np.full(count, np.inf), np.zeros_like(points)
    for body in range(position.shape[1]):
        own = rotate(conjugate(orientation[:, body, None]), points - position[:, body, None])
        moved = np.abs(np.diff(own, axis=0)).sum(axis=(0, 2))
        better = moved < least
        bodies[better], least[better] = body, moved[better]
        places[:, better] = own[:, better]
    return bodies, places


def world_points(lines: MuscleLines, position: Floats, orientation: Floats, weights: Floats, routed: Floats) -> Floats:
    """Points (F, P, 3), m, world.

    A conditional point slides onto the straight line between its neighbours as its weight goes to 0, so that the
    polyline is as long as the muscle's path wherever weights are 0 or 1.

    Args:
        position: (F, B, 3) of the bodies. orientation: (F, B, 4). weights: (F, C), see `point_weights`.
        routed: (F, R, 3), see `Routes`.
    """
    points = np.asarray(position[:, lines.body] + rotate(orientation[:, lines.body], lines.place))
    points[:, lines.routed] = routed
    if not len(lines.conditional):
        return points
    weight = np.ones(points.shape[:2])
    weight[:, lines.conditional] = weights
    before, behind = points.copy(), points.copy()  # the nearest points that count, this one included
    for k in lines.conditional:
        before[:, k] = np.where(weight[:, k, None] >= 0.5, points[:, k], before[:, k - 1])
    for k in lines.conditional[::-1]:
        behind[:, k] = np.where(weight[:, k, None] >= 0.5, points[:, k], behind[:, k + 1])
    drawn = points.copy()
    for k in lines.conditional:
        line = _nearest_on_line(points[:, k], before[:, k - 1], behind[:, k + 1])
        drawn[:, k] = line + weight[:, k, None] * (points[:, k] - line)
    return drawn


def _nearest_on_line(point: Floats, start: Floats, end: Floats) -> Floats:
    """The nearest points (F, 3) between starts and ends."""
    along = end - start
    square = np.maximum(np.sum(along * along, axis=-1, keepdims=True), 1e-12)
    part = np.clip(np.sum((point - start) * along, axis=-1, keepdims=True) / square, 0.0, 1.0)
    return np.asarray(start + along * part)
