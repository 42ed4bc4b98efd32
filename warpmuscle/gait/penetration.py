"""How deep the bodies of a recorded motion are inside each other."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import normalized, rotate
from warpmuscle.model.collisions import CapsuleRows, Pair, apart, capsule_of, collision_pairs, segment_distance
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.topology import topology

NOTICED = 0.001  # m; bodies that are deeper in each other than this count as inside each other


class Penetration(NamedTuple):
    """How deep bodies are inside each other: the deepest pair, and the share of the time that any pair is."""

    depth: float  # m, the greatest; 0 if none ever is
    share: float  # of the time in which some pair is deeper than `NOTICED`
    pair: Pair | None  # the deepest one
    time: float  # s, when it is deepest


def penetration(recording: Recording, scene: Scene) -> Penetration | None:
    """The deepest that bodies are inside each other, from the first frame on, and for how much of the time.

    All bodies with shapes count but those that a joint joins, and those that have a neighbour in common and overlap in
    the initial pose. Shapes are capsules, as in `Failure`.

    Args:
        recording: of the scene's character. scene: without free parameters.

    Returns:
        None where no two bodies with shapes are apart.
    """
    names = topology(scene.character)
    pairs = apart(scene, names)
    if not pairs:
        return None
    deepest, inside = Penetration(0.0, 0.0, None, 0.0), np.zeros(recording.frames, dtype=bool)
    for pair, found in _depths(recording, scene, pairs).items():
        depth = np.maximum(found, 0.0)
        inside |= depth > NOTICED
        frame = int(np.argmax(depth)) if len(depth) else 0
        if len(depth) and depth[frame] > deepest.depth:
            deepest = Penetration(float(depth[frame]), 0.0, pair, float(recording.time[frame]))
    return deepest._replace(share=float(inside.mean()) if len(inside) else 0.0)


def nearest_pair(recording: Recording, scene: Scene) -> Pair | None:
    """The bodies that are deepest inside each other in the last frame, or else nearest, of those that a scene tests.

    A simulation that ends between two frames has its last one before the bodies are as deep as they may be.

    Args:
        recording: of the scene's character, of one frame or more. scene: without free parameters.

    Returns:
        None where no two bodies with shapes are apart.
    """
    depths = _depths(recording, scene, collision_pairs(scene, topology(scene.character)))
    return max(depths, key=lambda pair: float(depths[pair][-1])) if depths else None


def _depths(recording: Recording, scene: Scene, pairs: list[Pair]) -> dict[Pair, Floats]:
    """How deep pairs of bodies are inside each other, m, in all frames; below 0 how far they are from each other."""
    placed = {name: _placed(recording, scene, name) for name in dict.fromkeys(itertools.chain(*pairs))}
    return {
        (one, other): np.max([_depth(a, b) for a, b in itertools.product(placed[one], placed[other])], axis=0)
        for one, other in pairs
    }


def _placed(recording: Recording, scene: Scene, name: str) -> list[CapsuleRows]:
    """The capsules of a body in all frames, world: middle and half (F, 3), m, and radius (1,), m."""
    body = recording.body_names.index(name)
    position = np.asarray(recording.body_position[:, body], dtype=np.float64)
    orientation = normalized(np.asarray(recording.body_orientation[:, body], dtype=np.float64))
    return [
        (position + rotate(orientation, middle), rotate(orientation, half), radius)
        for middle, half, radius in map(capsule_of, scene.character.bodies[name].shapes)
    ]


def _depth(a: CapsuleRows, b: CapsuleRows) -> Floats:
    (middle_a, half_a, radius_a), (middle_b, half_b, radius_b) = a, b
    return radius_a + radius_b - segment_distance(middle_b - middle_a, half_a, half_b)
