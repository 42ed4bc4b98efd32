"""Bones of the trunk of an animal on two legs that lies or leans ahead of its hips, such as a bird's; numbers only.

Lengths and axes: see `skeleton`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.view.bones.directions import ASIDE, unit
from warpmuscle.view.bones.long_neck import LongNeck
from warpmuscle.view.bones.meshes import merged, tube
from warpmuscle.view.hulls import Mesh

RIBS = 10  # a side
FIRST, LAST = 0.3, 0.94  # where the ribs are, along the spine from the hips on
STERNUM = 0.5  # from where on ribs reach the breastbone, along the same
WIDE, DEEP = 0.75, 1.25  # half width and depth of the ribs, in the radius of the trunk
ARC = np.linspace(0.1, 1.0, 9)  # along a rib, from the spine to its end
RIB = (0.0075, 0.005)  # m, radius at the spine and at the end, of a body of 75 kg
AHEAD = 0.3  # sine of how far a trunk leans ahead, at least
LEAST = 0.25  # m, how long it is, at least, of a body of 75 kg
NECK = np.array([0.0, 0.75, 0.65])  # of a trunk without one, in its radius, to the head
FLESH = 0.32  # radius of that neck, in that of the trunk


class LowTrunk(NamedTuple):
    """Where such a trunk is in its own frame, m."""

    hips: Sequence[Floats]
    front: Floats  # the joint of the neck, or where a head is to be
    radius: float
    headless: bool  # nothing hangs in front of it

    @property
    def down(self) -> Floats:
        """Across the trunk, away from the spine."""
        along = unit(self.front - 0.5 * (self.hips[0] + self.hips[1]))
        return np.asarray(unit(np.cross(along, ASIDE)) * (1.0 if np.cross(along, ASIDE)[1] < 0.0 else -1.0))

    def neck(self) -> LongNeck:
        """A short neck with the head."""
        return LongNeck(self.front, self.front + self.radius * NECK, FLESH * self.radius)

    def ribs(self, scale: float) -> Mesh:
        """Ribs along the spine, and a breastbone."""
        middle, down = 0.5 * (self.hips[0] + self.hips[1]), self.down
        begin = middle - 0.5 * self.radius * down
        along, bones, breast = self.front - begin, [], []
        for part in np.linspace(FIRST, LAST, RIBS):
            full = 0.65 + 0.35 * np.sin(np.pi * (part - FIRST) / (LAST - FIRST))  # narrower at both ends
            reach = 1.0 if part >= STERNUM else 0.7  # false ribs end at the side
            angle = np.pi * reach * ARC
            deep = DEEP * self.radius * full
            fall = 0.5 * deep * (1.0 - np.cos(angle))[:, None] * down
            back = 0.2 * deep * np.sin(0.5 * angle)[:, None] * unit(along)
            for sign in (1.0, -1.0):
                out = sign * WIDE * self.radius * full * np.sin(angle)[:, None] * ASIDE
                bones.append(tube(begin + part * along + out + fall - back, scale * np.linspace(*RIB, len(ARC)), 6))
            if reach == 1.0:
                breast.append(begin + part * along + deep * down - 0.2 * deep * unit(along))
        bones.append(tube(breast, 0.011 * scale))
        return merged(bones)


def low_trunk(hips: Sequence[Floats], neck: Floats | None, end: Floats, radius: float, scale: float) -> LowTrunk | None:
    """The trunk from hips to the joint of the neck, or to the far end of a capsule; None if it does not lean ahead."""
    way = (end if neck is None else neck) - 0.5 * (hips[0] + hips[1])
    length = float(np.linalg.norm(way))
    if length < LEAST * scale or way[2] < AHEAD * length or abs(way[0]) > 0.1 * length:
        return None
    found = LowTrunk(hips, end if neck is None else neck, radius, neck is None)
    if neck is not None:
        return found
    return found._replace(front=end - 0.4 * radius * found.down)  # the spine is above the middle
