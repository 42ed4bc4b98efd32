"""Motions of many instances of one body as arrays (instance, time, ...): how files keep them, and tables show them.

Instances may end at different times. Behind its last frame an instance has NaN, and -1 in whole numbers; `frames` says
how many it has. All share one clock, of which each has the beginning.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.arguments import as_integer, as_kind, in_words, obtained_by
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.labelled import Labelled, to_xarray
from warpmuscle.core.plain_text import number_of
from warpmuscle.results.partial_motion import checked_quantities
from warpmuscle.results.recorded_quantities import (
    INTEGER_QUANTITIES,
    NAMED,
    QUANTITIES,
    UNITS,
    attributes_of,
    dimension,
    has_place,
)
from warpmuscle.results.recording import Recording

if TYPE_CHECKING:
    import xarray

TEXTS = (*NAMED.values(), *UNITS.values())  # fields of a recording that are texts
INSTANCE = "instance"


@obtained_by('wm.read_motions("walk.h5") reads them')
@dataclass(frozen=True, repr=False)
class Motions:
    """Motions of n instances of one character over F frames, with all or some quantities of a `Recording`.

    Attributes:
        time: (F,) s, of the longest. frames: (n,), how many each instance has. names: (n,), empty if they have none.
        arrays: (n, F, ...) by name of the quantity. texts: names and units along the axes, as in `Recording`.
    """

    time: Floats
    frames: Integers
    names: tuple[str, ...]
    arrays: Mapping[str, NDArray[Any]]
    texts: Mapping[str, tuple[str, ...]]

    def __post_init__(self) -> None:
        count, longest = len(self.frames), len(self.time)
        if count and not (self.frames.min() >= 0 and self.frames.max() <= longest):
            raise ArgumentError(f"frames of an instance must lie between 0 and {longest}")
        if self.names and len(self.names) != count:
            raise ArgumentError(f"{number_of(len(self.names), 'name')} for {number_of(count, 'instance')}")
        sizes = {axis: len(self.texts[name]) for axis, name in NAMED.items()}
        for name, array in self.arrays.items():
            expected = (count, longest, *(sizes.get(axis, len(axis.split())) for axis in QUANTITIES[name].axes[1:]))
            if array.shape != expected:
                raise ArgumentError(f"{name} has shape {array.shape}, not {expected}")

    def __len__(self) -> int:
        """Number of instances."""
        return len(self.frames)

    def __repr__(self) -> str:
        return (
            f"Motions({number_of(len(self), 'instance')}, {number_of(len(self.time), 'frame')}, "
            f"{number_of(len(self.arrays), 'quantity')})"
        )

    def __getitem__(self, name: str) -> NDArray[Any]:
        """The array (n, F, ...) of a quantity; raises ArgumentError if there is none."""
        if not isinstance(name, str) or name not in self.arrays:
            raise ArgumentError(f"these motions have no {in_words(name)}; there are {', '.join(self.arrays)}")
        return self.arrays[name]

    @classmethod
    def of(
        cls, recordings: Sequence[Recording], names: Sequence[str] = (), quantities: Sequence[str] | None = None
    ) -> Self:
        """Several recordings as one `Motions`, with all of their quantities or the named ones.

        Raises:
            ArgumentError: there are none, they are not of one body or clock, or a quantity is unknown.
        """
        recordings = [as_kind(Recording, one, "recordings") for one in recordings]
        chosen = checked_quantities(quantities)
        if (why := difference(recordings)) is not None:
            raise ArgumentError(why)
        longest = max(recordings, key=lambda one: one.frames)
        if quantities is not None and (gone := [name for name in chosen if name in longest.missing]):
            raise ArgumentError(f"the motions have no {', '.join(gone)}")
        chosen = [name for name in chosen if name not in longest.missing]
        texts = {name: getattr(longest, name) for name in TEXTS}
        arrays = {}
        for name in chosen:
            if name != "time" and has_place(name, texts):
                arrays[name] = _beside_each_other(name, [one[name] for one in recordings])
        return cls(longest.time, np.array([one.frames for one in recordings]), tuple(names), arrays, texts)

    def recording(self, instance: int) -> Recording:
        """The motion of one instance, with the quantities kept; raises ArgumentError for an unknown instance."""
        number = as_integer(instance, INSTANCE, 0)
        if number >= len(self):
            raise ArgumentError(f"instance must be less than {len(self)}, not {number}")
        count = int(self.frames[number])
        arrays = {name: array[number, :count] for name, array in self.arrays.items()}
        texts = [self.texts[name] for name in TEXTS]
        return Recording.of({"time": self.time[:count], **arrays}, *texts, kept=tuple(arrays))

    def to_xarray(self) -> xarray.Dataset:
        """All quantities as an `xarray.Dataset` over `instance`, `time`, `muscle_names` and so on.

        It is what `xarray.open_dataset` makes of the motions in a result file. Raises Error without xarray.
        """
        arrays = []
        for name, array in self.arrays.items():
            axes = (INSTANCE, *map(dimension, QUANTITIES[name].axes))
            arrays.append(Labelled(name, axes, array, attributes_of(name)))
        arrays.append(Labelled("frames", (INSTANCE,), self.frames))
        for axis, name in UNITS.items():
            if self.texts[name]:
                arrays.append(Labelled(name, (dimension(axis),), np.array(self.texts[name], dtype=str)))
        words = {axis: self.texts[NAMED[axis]] if axis in NAMED else axis.split() for axis in self.axes()}
        labels: dict[str, Sequence[Any]] = {dimension(axis): along for axis, along in words.items()}
        found = to_xarray(Labelled("time", ("time",), self.time, attributes_of("time")), arrays, labels)
        return found.assign_coords({INSTANCE: list(self.names) or np.arange(len(self))})

    @property
    def missing(self) -> tuple[str, ...]:
        """Names of the quantities that recordings of this character can have and these motions lack."""
        return tuple(n for n in QUANTITIES if n not in self.arrays and n != "time" and has_place(n, self.texts))

    def axes(self) -> list[str]:
        """Axes of the quantities other than instance and frame, each listed once."""
        return list(dict.fromkeys(axis for name in self.arrays for axis in QUANTITIES[name].axes[1:]))


def difference(recordings: Sequence[Recording]) -> str | None:
    """Why motions cannot stand side by side, None if they can."""
    if not recordings:
        return "there are no motions"
    first, longest = recordings[0], max(recordings, key=lambda one: one.frames)
    for number, one in enumerate(recordings):
        for name in TEXTS:
            if getattr(one, name) != getattr(first, name):
                return f"motion {number} is of another body than motion 0: their {name} differ"
        if one.frames and longest.frames and one.missing != longest.missing:
            return f"motion {number} has other quantities than the longest one"
        if not np.array_equal(one.time, longest.time[: one.frames]):
            return f"motion {number} was recorded at other times than the longest one"
    return None


def absent(name: str) -> float:
    """What stands for a quantity behind the last frame of an instance."""
    return -1 if name in INTEGER_QUANTITIES else np.nan


def _beside_each_other(name: str, parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Arrays (F', ...) of a quantity as one (n, F, ...), with what stands for nothing behind their ends."""
    longest = max(parts, key=len)
    found = np.full((len(parts), *longest.shape), absent(name), np.result_type(*parts))
    for row, part in zip(found, parts, strict=True):
        row[: len(part)] = part
    return found
