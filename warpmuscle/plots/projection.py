"""Pieces of a character as they are seen in a frame of a recording."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import rotate
from warpmuscle.results.recording import Recording
from warpmuscle.scene.anatomy import Piece, convex_hull

_CIRCLE = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)


def project(recording: Recording, piece: Piece, frame: int, axes: tuple[int, int]) -> Floats:
    """Points (m, 2) to draw of a piece in one frame, m, on two of the world's axes."""
    index = recording.body_names.index(piece.body)
    turned = rotate(recording.body_orientation[frame, index], piece.points)
    flat: Floats = (recording.body_position[frame, index] + turned)[:, list(axes)]
    if not piece.outline:
        return flat
    circle = np.stack([np.cos(_CIRCLE), np.sin(_CIRCLE)], axis=1)
    return convex_hull((flat[:, None] + np.reshape(piece.radii, (-1, 1, 1)) * circle).reshape(-1, 2))
