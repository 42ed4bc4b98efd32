"""Short tendons from where muscles of a model end to the bones that are drawn there; numbers only.

Models place the ends of muscles by their moment arms, so that an end may lie some centimetres beside a bone, more so
beside one of ours. What is drawn besides changes no path.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import conjugate, rotate
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import sides_of
from warpmuscle.scene.initial_pose import world_poses
from warpmuscle.scene.masses import TINY_MASS, body_mass
from warpmuscle.view.pieces import Hull, Limb, Piece

TOUCHING = 0.004  # m, an end that is no farther from a bone is on it
FARTHEST = 0.09  # m, an end that is farther from all bones of its body stays in the air
DETOUR = 1.6  # a tendon is no longer than this many times the way to the nearest bone: it might end on the jaw
RADII = 0.0042, 0.0065  # m, at the muscle's end and at the bone; all of a body of 75 kg


def attachments(
    scene: Scene, muscles: Iterable[str], body_names: Sequence[str], look: Sequence[Piece]
) -> list[Piece]:  # fmt: skip
    """The tendons between ends of muscles and bones of a figure.

    They go on in the direction in which the muscle ends at the start of the motion, so that none turns at once, where
    a bone lies there.

    Args:
        scene: without free parameters. muscles: names of those that are drawn. look: all pieces of the figure.
    """
    character = scene.character
    scale = float(np.clip((max(body_mass(character), TINY_MASS) / 75.0) ** (1.0 / 3.0), 0.3, 1.4))
    sides, poses = sides_of(character), world_poses(scene)
    edges = {body: _edges(look, body_names.index(body)) for body in character.bodies}
    found: list[Piece] = []
    for name in muscles:
        path = character.muscles[name].path
        ends = ((path[0], path[1]), (path[-1], path[-2])) if len(path) > 1 else ()  # none, where arms are given
        for end, beside in ends:
            if end.motion or not len(edges[end.body]):
                continue
            place = np.asarray(end.place(), dtype=np.float64)
            position, turn = poses[end.body]
            other = poses[beside.body][0] + rotate(poses[beside.body][1], np.asarray(beside.place()))
            along = place - rotate(conjugate(turn), other - position)
            along /= max(float(np.linalg.norm(along)), 1e-9)
            apart = float(np.linalg.norm(nearest(place, edges[end.body]) - place))
            if TOUCHING * scale < apart < FARTHEST * scale:
                ahead = (nearest(place + part * apart * along, edges[end.body]) for part in (1.0, 0.5, 0.0))
                bone = next(one for one in ahead if float(np.linalg.norm(one - place)) <= DETOUR * apart)
                radii = RADII[0] * scale, RADII[1] * scale
                found.append(Limb(body_names.index(end.body), sides[end.body], "tendon", place, bone, radii))
    return found


def nearest(place: Floats, edges: Floats) -> Floats:
    """The point (3,) that is nearest to a place (3,) on edges (n, 2, 3)."""
    along = edges[:, 1] - edges[:, 0]
    square = np.maximum(np.einsum("ij,ij->i", along, along), 1e-18)
    away = edges[:, 0] - place
    beside = np.einsum("ij,ij->i", away, along)
    part = np.clip(-beside / square, 0.0, 1.0)
    first = np.argmin(np.einsum("ij,ij->i", away, away) + part * (2.0 * beside + part * square))
    return np.asarray(edges[first, 0] + part[first] * along[first])


def _edges(look: Sequence[Piece], number: int) -> Floats:
    """Edges (n, 2, 3), m, of all triangles of a body's bones."""
    found = [np.zeros((0, 2, 3))]
    for piece in look:
        if isinstance(piece, Hull) and piece.layer == "bone" and piece.body == number:
            corners = np.asarray(piece.corners, dtype=np.float64)[np.asarray(piece.faces)]
            found.append(np.concatenate([corners[:, [i, (i + 1) % 3]] for i in range(3)]))
    return np.concatenate(found)
