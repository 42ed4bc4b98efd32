"""Segments of a human body from its height and mass: masses, lengths, centres of mass, inertia.

Masses, centres of mass and radii of gyration: R. Dumas, L. Cheze, J.-P. Verriest, Adjustments to McConville et al. and
Young et al. body segment inertial parameters, J. Biomech. 40(3), 2007. Lengths over height: D. A. Winter, Biomechanics
and Motor Control of Human Movement, 2009, fig. 4.1, and for head, torso and pelvis those of Dumas' subjects.
Axes are those of scenes: x to the left, y up, z forward, of a body that stands with its arms hanging, palms forward.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.scene import Body
from warpmuscle.scene.number import Vector

Sex = Literal["female", "male"]

LENGTHS = {  # over height
    "head": 0.147,  # with the neck, from the cervical joint centre
    "torso": 0.270,  # from the cervical to the lumbar joint centre
    "pelvis": 0.053,  # from the lumbar joint centre down to the hip joints
    "upper_arm": 0.186,
    "forearm": 0.146,
    "hand": 0.108,
    "thigh": 0.245,
    "shank": 0.246,
    "foot": 0.152,
}
# Percent of the body's mass; percent of the length: centre of mass forwards, upwards and to the right of a right
# segment from its proximal end (of the foot from the ankle, of the head from below), and radii of gyration about
# the same axes. Products of inertia are left out.
Row = tuple[float, tuple[float, float, float], tuple[float, float, float]]
TABLES: dict[Sex, dict[str, Row]] = {
    "male": {
        "head": (6.7, (-6.2, 55.5, 0.1), (31.0, 25.0, 33.0)),
        "torso": (33.3, (-3.6, -42.0, -0.2), (27.0, 25.0, 28.0)),
        "pelvis": (14.2, (2.8, -28.0, -0.6), (101.0, 106.0, 95.0)),
        "upper_arm": (2.4, (1.7, -45.2, -2.6), (31.0, 14.0, 32.0)),
        "forearm": (1.7, (1.0, -41.7, 1.4), (28.0, 11.0, 27.0)),
        "hand": (0.6, (3.5, -35.7, 3.2), (26.0, 16.0, 24.0)),
        "thigh": (12.3, (-4.1, -42.9, 3.3), (29.0, 15.0, 30.0)),
        "shank": (4.8, (-4.8, -41.0, 0.7), (28.0, 10.0, 28.0)),
        "foot": (1.2, (26.4, -10.4, 1.8), (11.0, 25.0, 25.0)),
    },
    "female": {
        "head": (6.7, (-7.0, 59.7, 0.0), (32.0, 27.0, 34.0)),
        "torso": (30.4, (-1.6, -43.6, -0.6), (29.0, 27.0, 29.0)),
        "pelvis": (14.6, (-0.9, -23.2, 0.2), (91.0, 100.0, 79.0)),
        "upper_arm": (2.2, (-7.3, -45.4, -2.8), (33.0, 17.0, 33.0)),
        "forearm": (1.3, (2.1, -41.1, 1.9), (26.0, 14.0, 25.0)),
        "hand": (0.5, (3.3, -32.7, 2.1), (27.0, 18.0, 25.0)),
        "thigh": (14.6, (-7.7, -37.7, 0.9), (31.0, 19.0, 32.0)),
        "shank": (4.5, (-4.9, -40.4, 3.1), (28.0, 10.0, 28.0)),
        "foot": (1.0, (26.4, -10.4, 1.8), (12.0, 25.0, 25.0)),
    },
}


@dataclass(frozen=True)
class Segment:
    """A segment of a body, along the axes of scenes."""

    mass: float  # kg
    length: float  # m
    com: Vector  # m, centre of mass from the proximal end
    inertia: Vector  # kg m^2, about the centre of mass

    def body(self) -> Body:
        """The segment as a body of a scene, without shapes."""
        return Body(self.mass, self.inertia)


def segment(
    name: str, height: float, mass: float, sex: Sex = "male", side: Literal["left", "right"] = "right"
) -> Segment:
    """A segment of a body of a height, m, and mass, kg.

    Args:
        name: one of `LENGTHS`. side: of the body, which matters little to segments of its middle.

    Raises:
        Error: an unknown segment, or a height or mass that is not positive.
    """
    if name not in LENGTHS:
        raise Error(f"no segment {name!r}; known: {', '.join(LENGTHS)}")
    if not (0.0 < height < np.inf and 0.0 < mass < np.inf):
        raise Error(f"a body has a positive height and mass, not {height:g} m and {mass:g} kg")
    percent, (forward, up, right), (about_forward, about_up, about_side) = TABLES[sex][name]
    length, own = LENGTHS[name] * height, 0.01 * percent * mass
    sideways = right if side == "right" else -right
    com = tuple(0.01 * length * share for share in (-sideways, up, forward))
    inertia = tuple(own * (0.01 * length * radius) ** 2 for radius in (about_side, about_up, about_forward))
    return Segment(own, length, com, inertia)  # type: ignore[arg-type]
