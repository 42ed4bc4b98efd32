"""Motion of objects in recordings: what their quantities are called, and where an object was."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError

QUANTITIES = (
    *(("position_" + axis, "m") for axis in "xyz"),
    *(("orientation_" + axis, "1") for axis in "xyzw"),
    *(("velocity_" + axis, "m/s") for axis in "xyz"),
    *(("angular_velocity_" + axis, "rad/s") for axis in "xyz"),
)  # in the order in which a step writes them


class Recorded(Protocol):
    """What is asked of a recording."""

    @property
    def recorded_names(self) -> tuple[str, ...]: ...
    @property
    def recorded(self) -> Floats: ...


class ObjectMotion(NamedTuple):
    """Motion of an object over F frames, world; speeds are those half a step before."""

    position: Floats  # (F, 3) m, of its middle
    orientation: Floats  # (F, 4)
    velocity: Floats  # (F, 3) m/s
    angular_velocity: Floats  # (F, 3) rad/s


def object_quantities(name: str) -> tuple[str, ...]:
    """What recordings call the numbers of an object."""
    return tuple(f"objects.{name}.{quantity}" for quantity, _ in QUANTITIES)


def is_recorded(recording: Recorded, name: str) -> bool:
    """Whether a recording has the motion of an object."""
    return object_quantities(name)[0] in recording.recorded_names


def object_motion(recording: Recorded, name: str) -> ObjectMotion:
    """The motion of an object of a scene in a recording.

    Raises:
        ArgumentError: the recording does not have it.
    """
    names = object_quantities(name)
    if not is_recorded(recording, name):
        ending = "." + QUANTITIES[0][0]
        known = [one.split(".")[1] for one in recording.recorded_names if one.endswith(ending)]
        raise ArgumentError(f"nothing of an object {name!r} was recorded, but of {', '.join(known) or 'none'}")
    first = recording.recorded_names.index(names[0])
    values = np.asarray(recording.recorded[:, first : first + len(names)], dtype=float)
    return ObjectMotion(values[:, :3], values[:, 3:7], values[:, 7:10], values[:, 10:13])
