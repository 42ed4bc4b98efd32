"""Bones of a person's pelvis, which flow into one another; numbers only. Lengths and axes as in `skeleton`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.view.bones.blended import Part, blended, egg, fan, rod
from warpmuscle.view.bones.meshes import merged
from warpmuscle.view.bones.spine import vertebrae
from warpmuscle.view.hulls import Mesh

CELL, BLEND = 0.0094, 0.0026  # m
TALL = 0.095, 0.14  # m, from the hips to the highest point of the crests
RODS = 26  # of a wing
# A crest from front to back: how far from the hip aside, upwards in the height of the wing, and ahead, m.
CREST = ((0.028, 0.56, 0.052), (0.038, 0.74, 0.04), (0.043, 0.9, 0.012), (0.033, 1.0, -0.022), (0.008, 0.95, -0.055),
         (-0.03, 0.8, -0.078), (-0.045, 0.62, -0.084))  # fmt: skip
# Half width, half thickness, height in that of the wing and place along z, m, of the parts of a sacrum.
SACRUM = ((0.05, 0.021, 0.72, -0.05), (0.041, 0.0165, 0.52, -0.069), (0.03, 0.0125, 0.33, -0.082),
          (0.02, 0.0095, 0.16, -0.086), (0.009, 0.0065, 0.0, -0.078), (0.006, 0.005, -0.1, -0.066))  # fmt: skip


def pelvis_bones(hips: Sequence[Floats], top: Floats, scale: float) -> Mesh:
    """Two hip bones between the hips and the joint of the spine, the sacrum, and vertebrae up to that joint."""
    s, middle = scale, 0.5 * (hips[0] + hips[1])
    tall = float(np.clip(top[1] - middle[1], TALL[0] * s, TALL[1] * s))
    front = np.array([0.0, middle[1] - 0.034 * s, middle[2] + 0.05 * s])  # where both meet
    parts: list[Part] = [egg(front, (0.011 * s, 0.019 * s, 0.01 * s))]
    hollows: list[Part] = []
    for hip in hips:
        parts += _hip_bone(hip, front, np.sign(hip[0]), tall, s)
        hollows.append(egg(hip + s * np.array([np.sign(hip[0]) * 0.014, -0.002, 0.0]), (0.026 * s,) * 3))
    for wide, thick, up, ahead in SACRUM:
        place = np.array([0.0, middle[1] + up * tall, middle[2] + ahead * s])
        parts.append(egg(place, (wide * s, 0.021 * s, thick * s)))
    for sign in (1.0, -1.0):  # to the wings
        joint = np.array([sign * 0.045 * s, middle[1] + 0.62 * tall, middle[2] - 0.066 * s])
        parts.append(egg(joint, (0.014 * s, 0.026 * s, 0.017 * s)))
    bones = [blended(parts, CELL * s, BLEND * s, hollows)]
    begin = np.array([0.0, middle[1] + 0.8 * tall, middle[2] - 0.042 * s])
    if np.linalg.norm(top - begin) > 0.02 * s and top[1] > begin[1]:
        bones.append(vertebrae(begin + np.linspace(0.0, 1.0, 5)[:, None] * (top - begin), s))
    return merged(bones)


def _hip_bone(hip: Floats, front: Floats, side: float, tall: float, s: float) -> list[Part]:
    """Ilium, ischium and pubis of one side; `side` is 1 on the left."""

    def at(out: float, up: float, ahead: float) -> Floats:
        return np.asarray(hip + s * np.array([side * out, up, ahead]))

    crest = _smooth(hip + np.array(CREST) * [side * s, tall, s], RODS)
    rim = np.linspace(at(-0.004, 0.024, 0.03), at(-0.014, 0.02, -0.034), RODS)
    seat, end = at(-0.03, -0.08, -0.03), front + s * np.array([side * 0.013, 0.0, 0.0])
    return [
        *fan(rim, crest, 0.0082 * s, 0.0072 * s),
        rod(crest, 0.0075 * s),
        egg(crest[0], (0.009 * s, 0.012 * s, 0.009 * s)),
        egg(at(-0.01, 0.0, -0.002), (0.03 * s, 0.034 * s, 0.034 * s)),  # of the socket
        rod([at(-0.002, 0.026, 0.028), at(0.004, 0.045, 0.04)], s * np.array([0.011, 0.0075])),
        rod([at(-0.012, 0.015, -0.025), at(-0.035, 0.055, -0.062)], s * np.array([0.015, 0.013])),
        rod([at(-0.014, -0.012, -0.024), at(-0.024, -0.045, -0.04), seat], s * np.array([0.018, 0.0145, 0.0185])),
        rod([at(-0.024, -0.03, -0.042), at(-0.036, -0.028, -0.056)], s * np.array([0.009, 0.005])),
        rod([seat, seat + 0.55 * (end - seat) - [0.0, 0.02 * s, 0.0], end - [0.0, 0.014 * s, 0.0]],
            s * np.array([0.014, 0.0075, 0.009])),
        rod([at(-0.016, -0.004, 0.02), 0.5 * (at(-0.016, -0.004, 0.02) + end) + [0.0, 0.006 * s, 0.012 * s], end],
            s * np.array([0.016, 0.0095, 0.0115])),
    ]  # fmt: skip


def _smooth(points: Floats, count: int) -> Floats:
    """As many points along a smooth curve through points (N, 3)."""
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(np.linspace(0.0, 1.0, len(points)), points)(np.linspace(0.0, 1.0, count)))
