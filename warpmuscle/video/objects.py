"""Objects beside a character in a film: more capsules and boxes, which no body carries."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import rotate
from warpmuscle.scene import BoxObject, Scene
from warpmuscle.scene.objects.motion import ObjectMotion
from warpmuscle.scene.objects.shape import rounded
from warpmuscle.video.solids import Boxes, Capsules
from warpmuscle.view.track import Track

SIDE = "object"


def add_objects(
    track: Track, scene: Scene, capsules: Capsules, boxes: Boxes, ends: Floats, corners: Floats
) -> tuple[Capsules, Boxes, Floats, Floats]:
    """Solids with the objects of a scene without free parameters behind them.

    Args:
        ends: of capsules (F, C, 2, 3), m, world. corners: of boxes (F, B, 8, 3), m, world.
    """
    for body, (solid, motion) in enumerate(
        zip(scene.objects.values(), track.objects, strict=True), len(track.doll.names.bodies)
    ):
        half, radius = rounded(solid)
        if isinstance(solid, BoxObject):
            signs = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3, indexing="ij"), axis=-1).reshape(8, 3)
            own = signs * half[0]
            boxes = Boxes(np.append(boxes.body, body), np.concatenate([boxes.corners, own[None]]), (*boxes.side, SIDE))
            corners = np.concatenate([corners, _placed(motion, own)], axis=1)
        else:
            own = np.stack([-half[0], half[0]])
            capsules = Capsules(
                np.append(capsules.body, body), np.concatenate([capsules.ends, own[None]]),
                np.append(capsules.radius, radius[0]), (*capsules.side, SIDE), np.append(capsules.bone, False),
                np.append(capsules.device, False),
            )  # fmt: skip
            ends = np.concatenate([ends, _placed(motion, own)], axis=1)
    return capsules, boxes, ends, corners


def _placed(motion: ObjectMotion, points: Floats) -> Floats:
    """Points (n, 3) of an object in the world, (F, 1, n, 3), m."""
    return np.asarray(motion.position[:, None, None] + rotate(motion.orientation[:, None, None], points[None, None]))
