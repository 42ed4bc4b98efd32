"""A person's skull, whose bones flow into one another; numbers only. Axes as in `skeleton`."""

from __future__ import annotations

from functools import cache

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.view.bones.blended import Part, blended, egg, fan, rod
from warpmuscle.view.bones.directions import AHEAD, perpendicular, unit
from warpmuscle.view.bones.meshes import ellipsoid, merged
from warpmuscle.view.bones.spine import vertebrae
from warpmuscle.view.hulls import Mesh

CELL, BLEND = 0.08, 0.022  # of a skull whose half height is 1


def skull(joint: Floats, center: Floats, radius: float) -> tuple[Mesh, Mesh]:
    """Skull, jaw and spine of the neck, as high as a sphere; and its hollows, which are dark."""
    up = unit(center - joint)
    ahead = perpendicular(up, AHEAD)
    axes = np.stack([np.cross(up, ahead), up, ahead], axis=1)

    def placed(mesh: Mesh) -> Mesh:
        return center + radius * mesh[0] @ axes.T, mesh[1] @ axes.T, mesh[2]

    bones, hollows = unit_skull()
    top = center + radius * (axes @ np.array([0.0, -0.36, -0.2]))
    neck = joint + np.linspace(0.0, 1.0, 5)[:, None] * (top - joint)
    return merged([placed(bones), vertebrae(neck, radius / 0.115, 0.82)]), placed(hollows)


@cache
def unit_skull() -> tuple[Mesh, Mesh]:
    """Bones and hollows about the origin, from -1 to 1 upwards; x is to the left, z ahead."""
    parts: list[Part] = [
        egg([0.0, 0.29, -0.1], (0.65, 0.66, 0.8)),
        egg([0.0, 0.32, 0.24], (0.55, 0.5, 0.52)),  # the forehead
        egg([0.0, 0.05, -0.42], (0.46, 0.42, 0.44)),
        egg([0.0, -0.16, 0.3], (0.36, 0.3, 0.36)),
        egg([0.0, -0.3, 0.52], (0.29, 0.28, 0.24)),  # the upper jaw
        rod([[0.0, 0.04, 0.73], [0.0, -0.08, 0.8], [0.0, -0.14, 0.86]], [0.07, 0.055, 0.035]),
        rod(_arc(0.27, 0.44, 0.3, -0.5), 0.085),
        rod(_arc(0.255, 0.45, 0.3, -0.585), 0.05),  # teeth
        rod(_arc(0.25, 0.44, 0.29, -0.685), 0.05),
        rod(_arc(0.26, 0.42, 0.3, -0.77), 0.085),
        egg([0.0, -0.86, 0.68], (0.13, 0.08, 0.09)),  # the chin
    ]
    for side in (1.0, -1.0):
        parts += _side(side)
    hollows: list[Part] = [egg([0.0, -0.28, 0.8], (0.085, 0.15, 0.16))]
    hollows += [egg([side * 0.25, -0.07, 0.74], (0.17, 0.145, 0.27)) for side in (1.0, -1.0)]
    dark = [ellipsoid(np.array([0.0, -0.28, 0.68]), (0.09, 0.15, 0.07))]
    dark += [ellipsoid(np.array([side * 0.25, -0.07, 0.57]), (0.165, 0.145, 0.11)) for side in (1.0, -1.0)]
    return blended(parts, CELL, BLEND, hollows), merged(dark)


def _side(side: float) -> list[Part]:
    """Brow, cheek, temple and jaw of one side."""

    def at(x: float, y: float, z: float) -> Floats:
        return np.array([side * x, y, z])

    joint = np.linspace(at(0.51, -0.2, 0.06), at(0.5, -0.26, 0.24), 4)
    angle = np.linspace(at(0.45, -0.62, 0.1), at(0.4, -0.66, 0.36), 4)
    return [
        rod([at(0.08, 0.08, 0.73), at(0.28, 0.12, 0.74), at(0.47, 0.05, 0.58)], [0.06, 0.075, 0.06]),
        rod([at(0.47, 0.05, 0.57), at(0.46, -0.18, 0.55)], [0.06, 0.075]),
        rod([at(0.46, -0.18, 0.54), at(0.36, -0.24, 0.64), at(0.2, -0.22, 0.72)], [0.09, 0.08, 0.05]),
        rod([at(0.44, -0.22, 0.54), at(0.58, -0.2, 0.3), at(0.56, -0.14, 0.0)], [0.085, 0.055, 0.07]),
        egg(at(0.47, -0.3, -0.08), (0.1, 0.19, 0.12)),  # behind the ear
        *fan(joint, angle, 0.06, 0.07),
        rod([at(0.45, -0.64, 0.12), at(0.38, -0.74, 0.38), at(0.22, -0.81, 0.62), at(0.0, -0.85, 0.7)],
            [0.07, 0.085, 0.085, 0.095]),
    ]  # fmt: skip


def _arc(wide: float, middle: float, deep: float, height: float) -> Floats:
    """Points of half an ellipse ahead, at a height."""
    angle = np.linspace(-0.45 * np.pi, 0.45 * np.pi, 9)
    return np.stack([wide * np.sin(angle), np.full(9, height), middle + deep * np.cos(angle)], axis=1)
