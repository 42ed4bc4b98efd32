"""Where OpenSim's bodies, frames and axes are in ours.

OpenSim's x is forward, y up and z to the right; ours is x to the left, y up and z forward. In our reference pose all
bodies have identity orientation, and a body's origin is its centre of mass. So a body has a rotation that takes its
axes in OpenSim to its axes here, and its centre of mass in the former.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.formats.osim.frames import GROUND, on_body
from warpmuscle.formats.osim.records import Model, Vec3

WORLD = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])  # from OpenSim's axes to ours


def world_axes(gravity: Vec3) -> Floats:
    """The axes of a model's ground as columns (3, 3) in those of the world, in which gravity points down.

    Where it does not point along -y in the model, the ground is turned by the smallest angle that makes it, and about x
    if that is half a turn.
    """
    x, y, z = gravity
    if x == 0.0 and z == 0.0 and y <= 0.0:
        return WORLD
    up = -np.array(gravity) / np.linalg.norm(gravity)
    axis = np.cross(up, [0.0, 1.0, 0.0])
    if not np.any(axis):
        return np.asarray(WORLD @ np.diag([1.0, -1.0, -1.0]))
    a, b, c = axis
    cross = np.array([[0.0, -c, b], [c, 0.0, -a], [-b, a, 0.0]])
    return np.asarray(WORLD @ (np.eye(3) + cross + cross @ cross / (1.0 + up[1])))


@dataclass(frozen=True)
class Placed:
    """A body of ours and how its frame lies in that of OpenSim."""

    name: str
    axes: Floats  # (3, 3) from OpenSim's axes of it to ours
    center: Floats  # (3,) m, its centre of mass in OpenSim's axes

    def point(self, place: Floats) -> Floats:
        """A point of OpenSim's body in our body's frame."""
        return np.asarray(self.axes @ (place - self.center))


class Placement:
    """Bodies of a model that have a place among ours, by their paths."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self.world = world_axes(model.gravity)
        self.bodies: dict[str, Placed] = {GROUND: Placed("ground", self.world, np.zeros(3))}

    def body(self, frame: str) -> Placed:
        """The body that a frame is fixed to."""
        return self.bodies[on_body(self._model, frame)[0]]

    def point(self, frame: str, location: Vec3 | Floats) -> tuple[str, Vec3]:
        """Body and place, m, of a point that is given in a frame."""
        path, rotation, origin = on_body(self._model, frame)
        body = self.bodies[path]
        return body.name, vector(body.point(origin + rotation @ np.asarray(location)))

    def axes(self, frame: str) -> Floats:
        """The axes of a frame, as columns (3, 3) in those of our body."""
        path, rotation, _ = on_body(self._model, frame)
        return np.asarray(self.bodies[path].axes @ rotation)


def vector(numbers: Floats) -> Vec3:
    """Three plain numbers, with rounding about 0 left out."""
    x, y, z = (0.0 if abs(value) < 1e-16 else float(value) for value in numbers)
    return x, y, z


def direction(numbers: Floats) -> Vec3:
    """A unit vector, of which what rounding leaves beside an axis is left out."""
    unit = np.asarray(numbers) / np.linalg.norm(numbers)
    return vector(np.where(np.abs(unit) < 1e-12, 0.0, np.where(np.abs(unit) > 1.0 - 1e-15, np.sign(unit), unit)))


def quaternion(matrix: Floats) -> tuple[float, float, float, float]:
    """The rotation (x, y, z, w) of a matrix (3, 3)."""
    m = matrix
    squares = [
        1.0 + m[0, 0] - m[1, 1] - m[2, 2], 1.0 - m[0, 0] + m[1, 1] - m[2, 2], 1.0 - m[0, 0] - m[1, 1] + m[2, 2],
        1.0 + np.trace(m),
    ]  # fmt: skip
    largest = int(np.argmax(squares))
    rows = [
        [squares[0], m[1, 0] + m[0, 1], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]],
        [m[1, 0] + m[0, 1], squares[1], m[2, 1] + m[1, 2], m[0, 2] - m[2, 0]],
        [m[0, 2] + m[2, 0], m[2, 1] + m[1, 2], squares[2], m[1, 0] - m[0, 1]],
        [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], squares[3]],
    ]
    q = np.array(rows[largest]) / np.linalg.norm(rows[largest])
    x, y, z, w = (float(value) for value in np.where(np.abs(q) < 1e-15, 0.0, q))
    return x, y, z, w


def rotation_vector(matrix: Floats) -> Vec3:
    """The rotation of a matrix (3, 3) as a vector along its axis, as long as its angle, rad."""
    x, y, z, w = quaternion(matrix)
    axis = np.array([x, y, z]) * (1.0 if w >= 0.0 else -1.0)
    length = float(np.linalg.norm(axis))
    return vector(axis / length * 2.0 * np.arctan2(length, abs(w))) if length > 0.0 else (0.0, 0.0, 0.0)
