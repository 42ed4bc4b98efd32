"""Muscles as triangles: bellies and tendons along their paths, as the browser draws them; numbers only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.pose import cross, normalized
from warpmuscle.scene import Scene
from warpmuscle.video.colours import SHORTEST, TENDON, activation_colours
from warpmuscle.view.content import moving_content
from warpmuscle.view.track import Doll

TENDON_RADIUS = 0.0042  # m, of a body of 75 kg
SECTORS = 8
RINGS = ((2, 18), (6, 8), (10**9, 3))  # of each stretch between two points of a path that has at most so many stretches
BELLY = 0.02, 0.2  # of the swelling, where the tendon's colour turns into the muscle's


@dataclass(frozen=True)
class Bellies:
    """The M muscles of a figure; P points of their paths lie one muscle behind the other."""

    start: Integers  # (M + 1,) points of muscle m are start[m]..start[m + 1] - 1
    share: Floats  # (M,) of its length that is belly
    belly: Floats  # (M,) m, radius at its middle at its usual length
    length: Floats  # (M,) m, that one
    tendon: float  # m, radius

    def drawn(self, points: Floats, activation: Floats) -> tuple[Floats, Floats, Floats, Integers]:
        """Corners (V, 3), m, normals (V, 3), tints (V, 3) and faces (T, 3).

        Args:
            points: (P, 3) m, world. activation: (M,)
        """
        stretches = np.diff(self.start) - 1
        step = np.concatenate([np.zeros(1), np.linalg.norm(np.diff(points, axis=0), axis=1)])
        step[self.start[:-1][stretches >= 0]] = 0.0
        way = np.cumsum(step)
        parts, before, offset = [], 0, 0
        for most, rings in RINGS:
            muscles = np.flatnonzero((stretches > before) & (stretches <= most))
            before = most
            if len(muscles):
                one = self._group(muscles, rings, points, way, activation)
                parts.append((*one[:3], one[3] + offset))
                offset += len(one[0])
        if not parts:
            return np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
        corners, normals, tints, faces = (np.concatenate(part) for part in zip(*parts, strict=True))
        return corners, normals, tints, faces

    def _group(
        self, muscles: Integers, rings: int, points: Floats, way: Floats, activation: Floats
    ) -> tuple[Floats, Floats, Floats, Integers]:
        """Those of muscles whose stretches have so many rings each."""
        start, end = self.start[muscles], self.start[muscles + 1] - 1
        count = end - start
        owner = np.repeat(np.arange(len(muscles)), count)
        first = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count) + start[owner]
        total = np.maximum(way[end] - way[start], 1e-9)
        along = normalized(points[first + 1] - points[first], SHORTEST)
        # At the ends of a stretch rings lie across the way as it bends there.
        ahead = np.where((first + 1 < end[owner])[:, None], np.roll(along, -1, axis=0), 0.0)
        behind = np.where((first > start[owner])[:, None], np.roll(along, 1, axis=0), 0.0)
        part = np.linspace(0.0, 1.0, rings)
        axis = np.repeat(along[:, None], rings, axis=1)
        axis[:, 0] += behind
        axis[:, -1] += ahead
        axis = normalized(axis, SHORTEST)
        place = points[first][:, None] + part[:, None] * (points[first + 1] - points[first])[:, None]
        passed = (way[first] - way[start][owner])[:, None] + part * (way[first + 1] - way[first])[:, None]
        middle = 2.0 * (passed / total[owner][:, None] - 0.5) / self.share[muscles][owner][:, None]
        bulge = np.maximum(1.0 - middle * middle, 0.0)
        swollen = self.belly[muscles] * np.sqrt(
            self.length[muscles] / np.maximum(total, 0.5 * self.length[muscles])
        )  # its volume stays
        radius = self.tendon + (swollen[owner][:, None] - self.tendon) * bulge
        blend = np.clip((bulge - BELLY[0]) / (BELLY[1] - BELLY[0]), 0.0, 1.0)
        blend = (blend * blend * (3.0 - 2.0 * blend))[..., None]
        tint = (1.0 - blend) * np.array(TENDON) + blend * activation_colours(activation[muscles])[owner][:, None]
        aside = np.where(np.abs(axis[..., :1]) < 0.9, np.eye(3)[0], np.eye(3)[1])
        across = normalized(cross(axis, aside), SHORTEST)
        angle = 2.0 * np.pi * np.arange(SECTORS) / SECTORS
        normals = (
            np.cos(angle)[:, None] * across[..., None, :] + np.sin(angle)[:, None] * cross(axis, across)[..., None, :]
        )
        corners = place[..., None, :] + radius[..., None, None] * normals
        tints = np.repeat(tint[..., None, :], SECTORS, axis=2)
        return (corners.reshape(-1, 3), normals.reshape(-1, 3), tints.reshape(-1, 3), _grids(len(first), rings))


def _grids(stretches: int, rings: int) -> Integers:
    """Triangles between the rings of each stretch."""
    ring, sector = np.meshgrid(np.arange(rings - 1), np.arange(SECTORS), indexing="ij")
    a = (ring * SECTORS + sector).ravel()
    b = (ring * SECTORS + (sector + 1) % SECTORS).ravel()
    one = np.concatenate([np.stack([a, b, a + SECTORS], 1), np.stack([b, b + SECTORS, a + SECTORS], 1)])
    return np.asarray((np.arange(stretches)[:, None, None] * rings * SECTORS + one).reshape(-1, 3))


def bellies_of(doll: Doll, scene: Scene) -> Bellies:
    """The muscles of a doll, made of a scene without free parameters."""
    content = moving_content(doll, scene)
    share, belly, length = (np.array(content["muscles"][name], dtype=float) for name in ("share", "belly", "length"))
    return Bellies(doll.muscles.start, share, belly, length, TENDON_RADIUS * content["scale"])
