"""Convex hulls of spheres: the round bodies of trunk, pelvis and feet; numbers only."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Self

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.pose import normalized
from warpmuscle.scene import Box
from warpmuscle.scene.initial_pose import plain_vector

Mesh = tuple[Floats, Floats, Integers]  # corners (V, 3), normals (V, 3), faces (F, 3)
ROUND = 0.6  # of half the least edge of a box, the radius of its edges
TRIALS = 12  # to find the radius of a volume
# Of a trunk: how far up from its lower joint to the shoulders, and how far aside in their half distance.
TRUNK = ((0.0, 0.42), (0.62, 0.6), (0.9, 0.8))
CREST = 0.85  # half the width of a pelvis at its upper joint, in that between its hips
SPREAD = 0.9  # radius of a hull of a volume, at most in the distance between its seeds


class Seeds(NamedTuple):
    """Spheres that a hull holds."""

    places: Floats  # (S, 3) m
    radii: Floats  # (S,) m

    def joined(self, other: Seeds) -> Seeds:
        """These and the other ones."""
        return Seeds(np.concatenate([self.places, other.places]), np.concatenate([self.radii, other.radii]))

    def moved(self, way: Floats) -> Self:
        """The same elsewhere."""
        return self._replace(places=self.places + way)


def box_seeds(box: Box) -> Seeds:
    """Spheres in the corners of a box, which touch its faces."""
    low, high = plain_vector(box.low), plain_vector(box.high)
    radius = ROUND * 0.5 * float(np.min(high - low))
    inner = np.array([low + radius, high - radius])
    corners = np.stack(np.meshgrid(*inner.T, indexing="ij"), axis=-1).reshape(-1, 3)
    return Seeds(corners, np.full(len(corners), radius))


def rounded_hull(seeds: Seeds, coarse: bool = False) -> Mesh | None:
    """The hull of spheres; None if they hold no volume."""
    return _hull(seeds, _directions(0 if coarse else 2))


def _hull(seeds: Seeds, directions: Floats) -> Mesh | None:
    points = _samples(seeds, directions)
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return None
    used, faces = np.unique(hull.simplices, return_inverse=True)
    faces = faces.reshape(hull.simplices.shape)
    corners = points[used]
    a, b, c = (corners[faces[:, k]] for k in range(3))
    area = np.cross(b - a, c - a)
    wrong = np.sum(area * hull.equations[:, :3], axis=1) < 0.0
    faces[wrong] = faces[wrong][:, ::-1]
    owner = _owners(seeds, len(points))[used]
    outward = corners - seeds.places[owner]  # what lies between spheres is as smooth as they are
    length = np.linalg.norm(outward, axis=1, keepdims=True)
    return corners, outward / np.maximum(length, 1e-12), faces


def sized_hull(places: Floats, volume: float, coarse: bool = False) -> Mesh | None:
    """The hull of equal spheres about points (S, 3), m, with a volume, m^3, or as near as its form allows."""
    directions = _directions(1 if coarse else 2)
    widest = float(np.max(np.linalg.norm(places[:, None] - places[None], axis=-1)))
    low, high = 0.01 * widest, SPREAD * widest
    for _ in range(TRIALS):
        radius = 0.5 * (low + high)
        try:
            found = ConvexHull(_samples(Seeds(places, np.full(len(places), radius)), directions)).volume
        except (QhullError, ValueError):
            return None
        low, high = (radius, high) if found < volume else (low, radius)
    return _hull(Seeds(places, np.full(len(places), radius)), directions)


def trunk_places(joint: Floats, shoulders: Sequence[Floats]) -> list[Floats]:
    """Points (3,), m, at a waist, a chest and below the shoulders of a trunk, from its lower joint and shoulders."""
    middle = 0.5 * (shoulders[0] + shoulders[1])
    return [joint + up * (middle - joint) + wide * (end - middle) for up, wide in TRUNK for end in shoulders]


def pelvis_places(top: Floats, hips: Sequence[Floats]) -> Floats:
    """Points (4, 3), m, at the hips and at the crests of a pelvis, whose upper joint is at the top."""
    middle = 0.5 * (hips[0] + hips[1])
    return np.array([*hips, *(top + CREST * (hip - middle) for hip in hips)])


def _samples(seeds: Seeds, directions: Floats) -> Floats:
    """Points (S D, 3) on spheres, one sphere behind the other."""
    return np.asarray((seeds.places[:, None] + seeds.radii[:, None, None] * directions).reshape(-1, 3))


def _owners(seeds: Seeds, points: int) -> Integers:
    return np.repeat(np.arange(len(seeds.radii)), points // max(len(seeds.radii), 1))


def _directions(level: int) -> Floats:
    """Corners of an octahedron whose faces were split so often, on the unit sphere: 6, 18 or 66."""
    steps = 2**level
    grid = [(i, j, k) for i in range(-steps, steps + 1) for j in range(-steps, steps + 1)
            for k in range(-steps, steps + 1) if abs(i) + abs(j) + abs(k) == steps]  # fmt: skip
    points = np.array(grid, dtype=np.float64)
    return normalized(points)
