"""A camera that looks at a point of the world in perspective; numbers only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats

UP = np.array([0.0, 1.0, 0.0])
VIEW = np.radians(24.0)  # angle of view over the picture's height
_ROOM = 1.06  # the picture is so many times as large as what it has to hold
_NEAR = 0.05  # m, nearer than this nothing is drawn right


@dataclass(frozen=True)
class Camera:
    """Where a camera stands, relative to what it follows, and how large its picture is.

    Pictures have x to the right and y upwards, both in parts of half the picture's height, from its middle.
    """

    right: Floats  # (3,) unit vectors of the picture in the world
    up: Floats
    forward: Floats
    distance: float  # m, from the eye to the point looked at
    offset: Floats  # (3,) m, from what is followed to that point

    def project(self, points: Floats, followed: Floats) -> tuple[Floats, Floats]:
        """Places (n, 2) in the picture, and depths (n,), m, of points (n, 3), m, while `followed` (3,) is followed."""
        relative = np.asarray(points, dtype=float) - self.eye(followed)
        depth = np.maximum(relative @ self.forward, _NEAR)
        flat = np.stack([relative @ self.right, relative @ self.up], axis=-1)
        return flat * (self.scale(depth))[..., None], depth

    def eye(self, followed: Floats) -> Floats:
        """Where the camera stands (3,), m, while `followed` (3,) is followed."""
        return np.asarray(followed + self.offset - self.distance * self.forward)

    def scale(self, depth: Floats) -> Floats:
        """Length in the picture of 1 m at a depth, m."""
        return np.asarray(1.0 / (np.tan(VIEW / 2.0) * depth))


def camera_on(points: Floats, azimuth: float, elevation: float, aspect: float) -> Camera:
    """A camera that sees points (n, 3), m, given from what it follows, whole and as large as they fit.

    Args:
        azimuth: rad, 0 from the character's right side, positive from its front. elevation: rad, from above.
        aspect: width of the picture over its height.
    """
    level = np.array([np.cos(azimuth), 0.0, -np.sin(azimuth)])
    forward = np.cos(elevation) * level - np.sin(elevation) * UP
    right = np.cross(forward, UP)
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    points = np.asarray(points, dtype=float)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    across, over, away = ((points - middle) @ axis for axis in (right, up, forward))
    half = np.tan(VIEW / 2.0)
    need = np.maximum(np.abs(over), np.abs(across) / aspect) * _ROOM / half - away
    return Camera(right, up, forward, float(need.max()), middle)
