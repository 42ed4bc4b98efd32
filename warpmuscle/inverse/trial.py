"""What is recorded in one trial of an experiment, or found from it: markers, coordinates, forces on bodies.

Ground axes are those of OpenSim's models: x forward, y up, z to the right. Units are SI and radians.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError


class TrialWarning(UserWarning):
    """Something of a recording, or of what was found from it, is to be known before it is used."""


@dataclass(frozen=True)
class Markers:
    """Positions of K markers in F frames; NaN where one is missing.

    Raises:
        ArgumentError: shapes that do not go together, times that do not increase, a name that stands twice.
    """

    names: tuple[str, ...]  # (K,)
    times: Floats  # (F,) s
    positions: Floats  # (F, K, 3) m

    def __post_init__(self) -> None:
        _check_names("markers", self.names)
        _check_times("markers", self.times)
        _check_shape("markers", self.positions, (len(self.times), len(self.names), 3))
        if np.isinf(self.positions).any():
            frame, marker, _ = np.argwhere(np.isinf(self.positions))[0]
            raise ArgumentError(f"markers: {self.names[marker]!r} is infinitely far away in frame {frame + 1}")


@dataclass(frozen=True)
class Coordinates:
    """Values of C coordinates of a model in F frames, by their names in the model.

    Raises:
        ArgumentError: shapes that do not go together, times that do not increase, a name that stands twice, a value
            that is not finite.
    """

    names: tuple[str, ...]  # (C,)
    times: Floats  # (F,) s
    values: Floats  # (F, C) rad or m

    def __post_init__(self) -> None:
        _check_names("coordinates", self.names)
        _check_times("coordinates", self.times)
        _check_shape("coordinates", self.values, (len(self.times), len(self.names)))
        if not np.isfinite(self.values).all():
            frame, column = np.argwhere(~np.isfinite(self.values))[0]
            raise ArgumentError(f"coordinates: {self.names[column]!r} is not a finite number in frame {frame + 1}")

    def of(self, name: str) -> Floats:
        """Values (F,) of one coordinate.

        Raises:
            ArgumentError: none has that name.
        """
        if name not in self.names:
            raise ArgumentError(f"no coordinate {name!r}; there are {', '.join(self.names)}")
        return self.values[:, self.names.index(name)]


@dataclass(frozen=True)
class Plate:
    """A force on a body in F frames, as a force plate under a foot measures it; ground axes, unless told otherwise."""

    name: str
    body: str | None  # of the model; None: not told
    force: Floats  # (F, 3) N
    point: Floats  # (F, 3) m, where it acts
    moment: Floats  # (F, 3) N m, about that point
    axes_of: str | None = None  # body of an OpenSim model in whose axes force and moment are; None: the ground's
    point_on: str | None = None  # body from whose origin, in whose axes, the point is


@dataclass(frozen=True)
class Loads:
    """Forces of P plates in F frames.

    Raises:
        ArgumentError: shapes that do not go together, times that do not increase, a name that stands twice, a force
            that is not finite.
    """

    times: Floats  # (F,) s
    plates: tuple[Plate, ...]  # (P,)

    def __post_init__(self) -> None:
        _check_names("loads", [plate.name for plate in self.plates])
        _check_times("loads", self.times)
        for plate in self.plates:
            for what in ("force", "point", "moment"):
                values = getattr(plate, what)
                _check_shape(f"loads: {what} of {plate.name}", values, (len(self.times), 3))
                if not np.isfinite(values).all():
                    frame = int(np.argwhere(~np.isfinite(values))[0][0])
                    raise ArgumentError(f"loads: {what} of {plate.name!r} is not a finite number in frame {frame + 1}")


def _check_names(what: str, names: Sequence[str]) -> None:
    if len(set(names)) < len(names):
        twice = next(name for k, name in enumerate(names) if name in names[:k])
        raise ArgumentError(f"{what}: the name {twice!r} stands twice")


def _check_times(what: str, times: Floats) -> None:
    if np.ndim(times) != 1 or not len(times):
        raise ArgumentError(f"{what}: times must be one number a frame, at least one, not of shape {np.shape(times)}")
    if not np.isfinite(times).all() or (np.diff(times) <= 0.0).any():
        raise ArgumentError(f"{what}: times must be numbers that increase from frame to frame")


def _check_shape(what: str, values: Floats, shape: tuple[int, ...]) -> None:
    if np.shape(values) != shape:
        raise ArgumentError(f"{what}: an array of shape {shape} is needed, not of {np.shape(values)}")
