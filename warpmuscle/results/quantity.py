"""What one array of a recording holds, and how it is made from what a device wrote."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import conjugate

START, OVER, END = "start of the step", "over the step", "end of the step"  # of that which starts at a frame's time
BEFORE = "over the step before"
BESIDE = "by the activation recorded beside it"
LENGTH = f"{START}; with a compliant tendon: {BESIDE}"
SPEED = f"middle of the step before, by moment arms of the start; with a compliant tendon: {BEFORE}, {BESIDE}"
END_UNLESS = f"{END}; of neural activation: {START}"


@dataclass(frozen=True)
class RawFrames:
    """What a device wrote of one instance: F frames of `kernels.structs.Record`, and what reading them takes."""

    time: Floats  # (F,) s
    arrays: Mapping[str, Floats]  # by field of the record
    parents: list[int]  # (J,) body that each joint's child hangs on
    root_velocity: Floats  # (F, 3) m/s
    centers: Floats  # (B, 3) m, centres of mass from the joints, body axes

    def __getitem__(self, name: str) -> Floats:
        if name not in self.arrays:
            raise TypeError(f"a quantity is made of {name!r}, which nothing writes: there are {', '.join(self.arrays)}")
        return self.arrays[name]

    def recorded(self, name: str) -> Floats:
        """What was written of an array along frames alone; no frames of one that was not."""
        return self.arrays.get(name, np.zeros(0))

    @property
    def unturned(self) -> Floats:
        """Orientation of the world in each joint's parent, (F, J, 4)."""
        return conjugate(self["orientation"][:, self.parents])


class Quantity(NamedTuple):
    """What one array of a recording holds.

    Attributes:
        units: unit symbol, "1" for a number without one.
        axes: one name per axis; `frame` and those of `NAMED` are counted by the recording, the words of any other name
            are the components along that axis.
        description: one line.
        of: makes it from what a device wrote.
        at: when, if not at the frame's time: a frame is written by the step that starts then.
    """

    units: str
    axes: tuple[str, ...]
    description: str
    of: Callable[[RawFrames], Floats]
    at: str = START


def quantity(
    units: str, axes: tuple[str, ...], description: str, of: Callable[[RawFrames], Floats], at: str = START
) -> Any:
    """A field that holds a quantity."""
    return field(metadata={"quantity": Quantity(units, axes, description, of, at)})


def of_muscles(units: str, place: int, description: str, at: str = START) -> Any:
    """A field that holds what the device writes of every muscle in a place of its own."""
    return quantity(units, ("frame", "muscle"), description, lambda raw: raw["muscle"][:, place], at)
