"""Bones of the trunk of an animal on four legs, from pelvis to neck; numbers only. Lengths and axes: see `skeleton`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.view.bones.directions import ASIDE, perpendicular, turned, unit
from warpmuscle.view.bones.meshes import ellipsoid, merged, tube
from warpmuscle.view.hulls import Mesh

RIBS = 12  # a side
FIRST, LAST = 0.36, 0.93  # where the ribs are, along the spine from hips to neck
STERNUM = 0.55  # from where on ribs reach the breastbone, along the same
WIDE = 1.25  # half width of the barrel in the distance of a shoulder from the middle
BELOW = 0.25  # how far the breastbone is below the shoulders, in their depth below the spine
ARC = np.linspace(0.12, 1.0, 9)  # along a rib, from the spine to its end
RIB = (0.0075, 0.0055)  # m, radius at the spine and at the end, of a body of 75 kg
BLADE = (0.012, 0.05)  # half thickness and half width of a shoulder blade, m, of a body of 75 kg


def barrel_bones(hips: Sequence[Floats], neck: Floats, shoulders: Sequence[Floats], scale: float) -> Mesh:
    """Ribs along the spine, a breastbone, and a shoulder blade above each foreleg.

    Args:
        hips, neck, shoulders: places of joints in the frame of the trunk, m.
    """
    middle, fore = 0.5 * (hips[0] + hips[1]), 0.5 * (shoulders[0] + shoulders[1])
    tail = np.array([0.0, max(middle[1] + 0.1 * scale, fore[1]), middle[2]])
    withers = tail + np.clip((fore[2] - tail[2]) / (neck[2] - tail[2]), 0.0, 1.0) * (neck - tail)
    deep = (1.0 + BELOW) * (withers[1] - fore[1])
    wide = WIDE * abs(shoulders[0][0])
    bones, front = [], []
    for part in np.linspace(FIRST, LAST, RIBS):
        spine = tail + part * (neck - tail)
        round_ = 0.75 + 0.25 * np.sin(np.pi * (part - FIRST) / (LAST - FIRST))  # narrower at both ends
        reach = 1.0 if part >= STERNUM else 0.72  # false ribs end at the side
        angle = np.pi * reach * ARC
        down = 0.5 * deep * (1.0 - np.cos(angle))
        back = 0.25 * deep * np.sin(0.5 * angle)
        for sign in (1.0, -1.0):
            line = spine + np.stack([sign * round_ * wide * np.sin(angle), -down, -back], axis=1)
            bones.append(tube(line, scale * np.linspace(*RIB, len(ARC)), 6))
        if reach == 1.0:
            front.append(spine - np.array([0.0, deep, 0.25 * deep]))
    bones.append(tube(front, 0.012 * scale))
    bones += [_blade(shoulder, withers, scale) for shoulder in shoulders]
    return merged(bones)


def _blade(shoulder: Floats, withers: Floats, scale: float) -> Mesh:
    """A shoulder blade from the joint up to the side of the withers."""
    top = np.array([0.75 * shoulder[0], withers[1] - 0.01 * scale, withers[2] - 0.05 * scale])
    up, (thick, wide) = unit(top - shoulder), BLADE
    size = (thick * scale, 0.5 * float(np.linalg.norm(top - shoulder)), wide * scale)
    return ellipsoid(0.5 * (shoulder + top), size, turned(up, perpendicular(up, ASIDE)))
