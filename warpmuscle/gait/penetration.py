"""How deep the bodies of a recorded motion are inside each other."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import normalized, rotate
from warpmuscle.model.collisions import CapsuleRows, Pair, apart, capsule_of, segment_distance
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
    placed = {name: _placed(recording, scene, name) for name in dict.fromkeys(itertools.chain(*pairs))}
    deepest, inside = Penetration(0.0, 0.0, None, 0.0), np.zeros(recording.frames, dtype=bool)
    for pair in pairs:
        depths = [_depth(one, other) for one, other in itertools.product(placed[pair[0]], placed[pair[1]])]
        depth = np.max(depths, axis=0, initial=0.0)
        inside |= depth > NOTICED
        frame = int(np.argmax(depth)) if len(depth) else 0
        if len(depth) and depth[frame] > deepest.depth:
            deepest = Penetration(float(depth[frame]), 0.0, pair, float(recording.time[frame]))
    return deepest._replace(share=float(inside.mean()) if len(inside) else 0.0)


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
