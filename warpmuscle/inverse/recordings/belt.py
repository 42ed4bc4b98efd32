"""The belt of a treadmill below a recorded motion, which moves as the points of the feet do that loads act on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.sequences import weighted_median
from warpmuscle.results.recording import Recording
from warpmuscle.scene.treadmill.belt_motion import MEASURED_BELT

LEAST = 0.2  # m/s; what is slower is no belt
CARRIED = 20.0  # N, that a foot carries at some time at least
FEW = 3  # frames, which have no rates


def belt_velocity(times: Floats, place: Floats, turning: Floats, force: Floats, point: Floats) -> Floats:
    """Velocity (3,) of the belt, m/s, world axes; 0 along an axis where it is slow, and where no foot is loaded.

    Half of the upward force acts on slower points of the feet, and half on faster ones.

    Args:
        times: (n,) s. place: (n, L, 3) m, of the feet that L loads act on. turning: (n, L, 3) rad/s, of these.
        force: (n, L, 3) N. point: (n, L, 3) m, where it acts.
    """
    if len(times) < FEW or force[..., 1].max(initial=0.0) < CARRIED:
        return np.zeros(3)
    velocity = np.gradient(place, times, axis=0) + np.cross(turning, point - place)
    return loaded_velocity(velocity, np.maximum(force[..., 1], 0.0))


def loaded_velocity(velocity: Floats, weight: Floats) -> Floats:
    """Velocity (3,) of points (..., 3), m/s, half of whose weight (...) is on slower ones; 0 along what is slow."""
    found = np.zeros(3)
    for axis in (0, 2):
        middle = weighted_median(velocity[..., axis], weight)
        found[axis] = middle if abs(middle) > LEAST else 0.0
    return found


def on_belt(motion: Recording, velocity: Floats) -> Recording:
    """The motion, which says how fast the belt below it is, and whose centre of mass moves relative to it."""
    if not np.any(velocity):
        return motion
    columns = np.broadcast_to(velocity[[0, 2]], (motion.frames, 2))
    return replace(
        motion,
        com_velocity=(motion.com_velocity - velocity).astype(motion.com_velocity.dtype),
        recorded=np.hstack([motion.recorded, columns]).astype(motion.recorded.dtype),
        recorded_names=(*motion.recorded_names, *MEASURED_BELT),
        recorded_units=(*motion.recorded_units, "m/s", "m/s"),
    )


def belt_of(motion: Recording) -> Floats:
    """Velocity (3,) of the belt that a motion tells, m/s; 0 of others."""
    found = np.zeros(3)
    for axis, name in zip((0, 2), MEASURED_BELT, strict=True):
        if name in motion.recorded_names and motion.frames:
            found[axis] = motion.recorded[0, motion.recorded_names.index(name)]
    return found
