"""Colours of a film, those of the browser's picture, and how light falls on what has them."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import normalized
from warpmuscle.view.pieces import Piece

HORIZON, ZENITH = (0.845, 0.875, 0.9), (0.7, 0.76, 0.81)
TILES = (0.735, 0.765, 0.785), (0.76, 0.788, 0.807)
SHADOW, SHADOW_ALPHA = (0.10, 0.13, 0.18), 0.20
WATER, WATER_ALPHA = (0.30, 0.56, 0.76), 0.36
# Of activation, from rest to full; steps that are equal to the eye, see `assets/renderer.js`.
ACTIVATIONS = (
    (0.187, 0.412, 0.811), (0.481, 0.413, 0.719), (0.683, 0.39, 0.598), (0.856, 0.336, 0.436), (1.0, 0.253, 0.144)
)  # fmt: skip
TENDON = (0.95, 0.95, 0.97)
FORCES = ((0.0, 0.38, 0.62), (0.76, 0.31, 0.0))  # left, right
SKIN_ALPHA = 0.2
LIGHT = normalized([-0.45, 1.0, 0.35])  # from where it comes
SHORTEST = 1e-9  # a vector that is shorter has no direction
_LAYERS = {
    "bone": (0.96, 0.93, 0.85), "hollow": (0.3, 0.27, 0.25), "tendon": TENDON, "object": (0.72, 0.6, 0.42),
    "device": (0.16, 0.2, 0.24),
}  # fmt: skip
_SIDES = {"left": (0.56, 0.7, 0.83), "right": (0.9, 0.72, 0.58), "middle": (0.8, 0.81, 0.83)}


def tint_of(piece: Piece) -> tuple[float, float, float]:
    """The colour of a piece of a figure."""
    return _LAYERS.get(piece.layer) or _SIDES[piece.side]


def activation_colours(activation: Floats) -> Floats:
    """Colours (..., 3) of activations (...)."""
    stops = np.linspace(0.0, 1.0, len(ACTIVATIONS))
    return np.stack([np.interp(activation, stops, part) for part in np.array(ACTIVATIONS).T], axis=-1)


def lit(normals: Floats, towards: Floats, tints: Floats) -> Floats:
    """Colours (n, 3) of points with normals (n, 3) that are seen from directions (n, 3), all of unit length."""
    day = np.maximum((normals @ LIGHT + 0.3) / 1.3, 0.0)
    sky = 0.5 + 0.5 * normals[:, 1]
    half = normalized(towards + LIGHT, SHORTEST)
    shine = np.maximum(np.einsum("ij,ij->i", normals, half), 0.0) ** 30
    return np.asarray(tints * (0.5 + 0.2 * sky + 0.4 * day)[:, None] + 0.08 * shine[:, None])


def skin_alpha(normals: Floats, towards: Floats) -> Floats:
    """How much skin (n,) hides of what is behind it: its edges most."""
    rim = 1.0 - np.abs(np.einsum("ij,ij->i", normals, towards))
    return np.asarray(SKIN_ALPHA * (0.25 + 1.6 * rim * rim))
