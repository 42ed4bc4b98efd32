"""Bones of an animal's neck that carries its head: vertebrae in a slight curve, a skull with a muzzle or a beak."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.view.bones.meshes import ellipsoid, merged, tube
from warpmuscle.view.hulls import Mesh

LEAST = 0.3  # m, from which on a neck and head are an animal's, not a person's
HEAD = 0.3  # length of a head in that of the neck, at least
STOUT = 4.0  # and in the radius of the neck's flesh
VERTEBRA = 0.04  # m
AHEAD, DOWN = np.array([0.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0])
LEVEL = 0.95  # sine of how a neck may lean ahead
BOW = 0.035  # of the curve of the neck, in its length


class LongNeck:
    """A neck from its joint to its end, and a head that looks ahead."""

    def __init__(self, joint: Floats, end: Floats, radius: float) -> None:
        """Take over joint and end, m, in the body's frame, and the radius of the flesh, m."""
        reach = end - joint
        self.length = float(np.linalg.norm(reach))
        self.up = reach / self.length
        wanted = AHEAD if abs(self.up[2]) < LEVEL else DOWN  # a head at the end of a level neck looks down
        ahead = wanted - np.dot(wanted, self.up) * self.up
        self.ahead = ahead / float(np.linalg.norm(ahead))
        self.joint, self.end, self.radius = joint, end, radius
        self.size = max(HEAD * self.length, STOUT * radius)
        self.middle = end + self.size * (0.12 * self.ahead - 0.1 * self.up)  # of the skull
        self.tip = self.middle + self.size * (0.72 * self.ahead - 0.2 * self.up)  # of the upper jaw

    def bones(self) -> tuple[Mesh, Mesh]:
        """Vertebrae, skull and jaws; and the eyes, which are dark."""
        s, up, ahead = self.size, self.up, self.ahead
        aside = np.cross(up, ahead)
        axes = np.stack([aside, up, ahead], axis=1)
        count = 2 * max(int(self.length / (2.0 * VERTEBRA)), 4) + 1
        part = np.linspace(0.0, 1.0, 2 * count + 1)
        last = self.middle - 0.16 * s * ahead
        line = self.joint + part[:, None] * (last - self.joint)
        line = line - (BOW * self.length * np.sin(2.0 * np.pi * part))[:, None] * ahead
        thick = self.radius * (0.46 - 0.18 * part) * np.where(np.arange(len(part)) % 2, 0.68, 1.0)
        nose = self.middle + s * (0.24 * ahead - 0.03 * up)
        chin = self.middle + s * (0.6 * ahead - 0.27 * up)
        bones = [
            tube(line, thick),
            ellipsoid(self.middle, (0.17 * s, 0.18 * s, 0.26 * s), axes, 22),
            tube(
                [nose - 0.12 * s * ahead, nose, 0.5 * (nose + self.tip), self.tip],
                s * np.array([0.14, 0.12, 0.075, 0.03]),
            ),
        ]
        for sign in (1.0, -1.0):
            hinge = self.middle + s * (sign * 0.12 * aside - 0.13 * up - 0.02 * ahead)
            bones.append(tube([hinge, 0.5 * (hinge + chin) - 0.02 * s * up, chin], s * np.array([0.045, 0.035, 0.03])))
        eyes = []
        for sign in (1.0, -1.0):
            place = self.middle + s * (sign * 0.15 * aside + 0.04 * up + 0.14 * ahead)
            eyes.append(ellipsoid(place, (0.045 * s, 0.06 * s, 0.07 * s), axes))
        return merged(bones), merged(eyes)
