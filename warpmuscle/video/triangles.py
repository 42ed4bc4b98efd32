"""What a figure is made of as triangles that bodies carry; numbers only."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.pose import cross, rotate
from warpmuscle.video.colours import tint_of
from warpmuscle.view.bones.meshes import ellipsoid, merged, tube
from warpmuscle.view.hulls import Mesh
from warpmuscle.view.pieces import Block, Ellipsoid, Limb, Piece

SHOWN = ("flesh", "bone", "hollow", "tendon", "object", "device")  # layers; wrapping surfaces and exact shapes are not
SECTORS = 14  # around a limb
SHORT = 1e-9  # m, a limb without length is a sphere


class Triangles(NamedTuple):
    """V corners and T triangles, each counter-clockwise from outside."""

    body: Integers  # (V,) that carries each corner
    corners: Floats  # (V, 3) m, in the body's frame
    normals: Floats  # (V, 3)
    tints: Floats  # (V, 3) 0..1
    faces: Integers  # (T, 3)
    glass: Integers  # (T,) 1 where a triangle is skin that bones and muscles are seen through
    casts: Integers  # (T,) 1 where it casts a shadow: skin and objects, or all where there is no skin

    def placed(self, position: Floats, orientation: Floats) -> tuple[Floats, Floats]:
        """Corners (V, 3), m, and normals (V, 3), world, of bodies at positions (B, 3), m, with orientations (B, 4)."""
        turn = orientation[self.body]
        return position[self.body] + rotate(turn, self.corners), rotate(turn, self.normals)


def triangles_of(pieces: Sequence[Piece]) -> Triangles:
    """The triangles of the pieces that are shown."""
    shown = [piece for piece in pieces if piece.layer in SHOWN]
    if not shown:
        none, no_places = np.zeros(0, dtype=np.int64), np.zeros((0, 3))
        return Triangles(none, no_places, no_places, no_places, np.zeros((0, 3), dtype=np.int64), none, none)
    meshes = [mesh_of(piece) for piece in shown]
    corners, normals, faces = merged(meshes)
    counts = [len(mesh[0]) for mesh in meshes]
    triangles = [len(mesh[2]) for mesh in meshes]
    tints = np.array([tint_of(piece) for piece in shown])
    skinned = any(piece.layer == "flesh" for piece in shown)
    casts = [int(not skinned or piece.layer in ("flesh", "object")) for piece in shown]
    return Triangles(
        np.repeat([piece.body for piece in shown], counts),
        corners,
        normals,
        np.repeat(tints, counts, axis=0),
        faces,
        np.repeat([int(piece.layer == "flesh") for piece in shown], triangles),
        np.repeat(casts, triangles),
    )


def mesh_of(piece: Piece) -> Mesh:
    """A piece as a mesh in its body's frame."""
    if isinstance(piece, Limb):
        if np.linalg.norm(piece.end - piece.start) < SHORT:
            return ellipsoid(piece.start, [max(piece.radii)] * 3)
        ends = np.array([piece.start, piece.end])
        return _bar(ends, piece.radii) if piece.flat else tube(ends, piece.radii, SECTORS)
    if isinstance(piece, Ellipsoid):
        axes = np.stack([rotate(piece.orientation, axis) for axis in np.eye(3)], axis=1)
        return ellipsoid(piece.position, [float(radius) for radius in piece.radii], axes)
    if isinstance(piece, Block):
        return _box(piece.position, piece.radii)
    return piece.corners, piece.normals, piece.faces


def _bar(ends: Floats, radii: tuple[float, float]) -> Mesh:
    """A round bar or cone between two points (2, 3), m, with flat ends."""
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    across = cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    across /= np.linalg.norm(across)
    angle = 2.0 * np.pi * np.arange(SECTORS)[:, None] / SECTORS
    ring = np.cos(angle) * across + np.sin(angle) * cross(along, across)
    rims = [end + radius * ring for end, radius in zip(ends, radii, strict=True)]
    a, b = np.arange(SECTORS), (np.arange(SECTORS) + 1) % SECTORS
    side = np.concatenate([np.stack([a, b, a + SECTORS], 1), np.stack([b, b + SECTORS, a + SECTORS], 1)])
    fan = np.stack([0 * a, a, b], axis=1)[1:-1]
    ring_normals = np.tile(ring, (2, 1))
    caps = [(rims[0], np.tile(-along, (SECTORS, 1)), fan[:, ::-1]), (rims[1], np.tile(along, (SECTORS, 1)), fan)]
    return merged([(np.concatenate(rims), ring_normals, side), *caps])


def _box(middle: Floats, half: Floats) -> Mesh:
    """A box along the axes; each face has corners of its own, so that its edges stay sharp."""
    sides: list[Mesh] = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            normal = sign * np.eye(3)[axis]
            first, second = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
            signs = ((-sign, -1.0), (sign, -1.0), (sign, 1.0), (-sign, 1.0))
            places = [middle + half * (normal + s * first + t * second) for s, t in signs]
            sides.append((np.array(places), np.tile(normal, (4, 1)), np.array([[0, 1, 2], [0, 2, 3]])))
    return merged(sides)


def arrow(start: Floats, tip: Floats) -> Mesh:
    """An arrow between two points (3,), m: a bar and a cone."""
    along = tip - start
    length = float(np.linalg.norm(along))
    neck = tip - along * min(HEAD[0], length) / length
    shaft = [_bar(np.array([start, neck]), (SHAFT, SHAFT))] if length > HEAD[0] + SHORT else []
    return merged([*shaft, _bar(np.array([neck, tip]), (HEAD[1], 0.0))])


SHAFT, HEAD = 0.011, (0.09, 0.03)  # m, radius of an arrow; length and radius of its head
