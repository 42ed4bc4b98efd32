"""Which capsules bodies are in water, and the mass of water that moves with them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats

_HALVINGS = 60


class WaterCapsule(NamedTuple):
    """A capsule, rows of numbers."""

    middle: Floats  # (rows, 3) m, body axes, from the centre of mass
    half: Floats  # (rows, 3) m, from there to the tip, round end included
    radius: Floats  # (rows,) m
    volume: Floats  # (rows,) m^3


def capsule_volume(half_length: Floats, radius: Floats) -> Floats:
    """Volume, m^3, of a capsule from tip to tip."""
    return np.asarray(np.pi * radius**2 * (2.0 * half_length - 2.0 / 3.0 * radius))


def length_by_inertia(volume: Floats, inertia_over_mass: Floats) -> Floats:
    """Length, m, of a cylinder of a volume whose inertia across its length over its mass is this, m^2.

    I/m = (3 r^2 + l^2)/12 with r^2 = V/(pi l); 0 where no cylinder that is longer than wide has it.
    """
    volume, asked = np.broadcast_arrays(np.asarray(volume, dtype=float), 12.0 * inertia_over_mass)
    low = np.cbrt(4.0 * volume / np.pi)  # as long as it is wide
    high = np.maximum(np.sqrt(asked), low)

    def found(length: Floats) -> Floats:
        return np.asarray(length**2 + 3.0 * volume / (np.pi * length))

    short = found(low) >= asked
    below, above = low.copy(), high.copy()
    for _ in range(_HALVINGS):
        middle = 0.5 * (below + above)
        less = found(middle) < asked
        below, above = np.where(less, middle, below), np.where(less, above, middle)
    return np.where(short, 0.0, below)


def radius_of(volume: Floats, length: Floats) -> Floats:
    """Radius, m, of the capsule of a volume and length; of the ball of the volume where no capsule is as short."""
    ball = np.cbrt(3.0 * volume / (4.0 * np.pi))
    low, high = np.zeros_like(volume), np.maximum(0.5 * length, 1e-12)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        less = capsule_volume(0.5 * length, middle) < volume
        low, high = np.where(less, middle, low), np.where(less, high, middle)
    return np.where(2.0 * ball >= length, ball, low)


def by_mass(mass: Floats, inertia: Floats, density: Floats) -> WaterCapsule:
    """The capsule that stands for a body: about its centre of mass, along its principal axis of least inertia.

    Args:
        mass: (rows,) kg. inertia: (rows, 3) kg m^2, principal. density: (rows,) kg/m^3.
    """
    volume = mass / density
    number = inertia.argmin(axis=1)
    axis = np.eye(3)[number]
    across = (inertia.sum(axis=1) - inertia.min(axis=1)) / 2.0
    length = length_by_inertia(volume, across / np.maximum(mass, 1e-30))
    radius = radius_of(*np.broadcast_arrays(volume, length))
    half = np.maximum(0.5 * length, radius)
    return WaterCapsule(np.zeros((1, 3)), half[:, None] * axis, radius, volume)


def added_mass(half_length: Floats, radius: Floats) -> tuple[Floats, Floats]:
    """Added mass along and across the axis of a prolate spheroid in that of what it displaces.

    Lamb 1932, art. 114: k = a0/(2 - a0), with e the eccentricity; 1/2 each for a ball, 0 and 1 for a long one.

    Args:
        half_length: m, half its long axis. radius: m, half its short one.
    """
    ratio = np.minimum(radius / half_length, 1.0 - 1e-4)
    e = np.sqrt(1.0 - ratio**2)
    log = np.log((1.0 + e) / (1.0 - e))
    along = 2.0 * (1.0 - e**2) / e**3 * (0.5 * log - e)
    across = 1.0 / e**2 - (1.0 - e**2) / (2.0 * e**3) * log
    return along / (2.0 - along), across / (2.0 - across)
