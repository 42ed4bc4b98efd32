"""What is recorded in one trial of an experiment, or found from it: markers, coordinates, forces on bodies.

Ground axes are those of OpenSim's models: x forward, y up, z to the right. Units are SI and radians.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from warpmuscle.core.arguments import as_array, as_kind, as_texts, in_words
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError, SignalError
from warpmuscle.core.html_table import Tabulated
from warpmuscle.core.labelled import Labelled, to_dataframe

if TYPE_CHECKING:
    import pandas

LATEST = 1.0e12  # s; far beyond the years 1970 to now
SHORTEST = 1.0e-8  # s between frames, which no laboratory records
FARTHEST = 1.0e9  # m, that no point of a plate without a force is away, however it was divided by nothing
STRONGEST = 1.0e9  # N or N m


class TrialWarning(UserWarning):
    """Something of a recording, or of what was found from it, is to be known before it is used."""


@dataclass(frozen=True, repr=False)
class Markers(Tabulated):
    """Positions of K markers in F frames; NaN where one is missing.

    Raises:
        ArgumentError: shapes that do not go together, times that do not increase, a name that stands twice.
    """

    names: tuple[str, ...]  # (K,)
    times: Floats  # (F,) s
    positions: Floats  # (F, K, 3) m

    def __post_init__(self) -> None:
        put_fields(self, names=checked_names("markers", self.names), times=checked_times("markers", self.times))
        put_fields(self, positions=checked_numbers("markers", self.positions, (len(self.times), len(self.names), 3)))
        if np.isinf(self.positions).any():
            frame, marker, _ = np.argwhere(np.isinf(self.positions))[0]
            raise ArgumentError(f"markers: {self.names[marker]!r} is infinitely far away in frame {frame + 1}")


class ByCoordinate(Tabulated):
    """A dataclass of values over time, a column for each coordinate of a model."""

    names: tuple[str, ...]  # (K,)
    times: Floats  # (F,) s
    values: Floats  # (F, K)

    def of(self, name: str) -> Floats:
        """Values (F,) of one coordinate.

        Raises:
            ArgumentError: none has that name.
        """
        return column_of(self.names, self.values, name)

    __getitem__ = of

    def to_dataframe(self) -> pandas.DataFrame:
        """A row for each time, a column for each coordinate; needs pandas."""
        return columns_to_dataframe(self.times, self.names, self.values)


@dataclass(frozen=True, repr=False)
class Coordinates(ByCoordinate):
    """Values of C coordinates of a model in F frames, by their names in the model.

    Raises:
        ArgumentError: shapes that do not go together, times that do not increase, a name that stands twice, a value
            that is not finite.
    """

    names: tuple[str, ...]  # (C,)
    times: Floats  # (F,) s
    values: Floats  # (F, C) rad or m

    def __post_init__(self) -> None:
        put_fields(self, names=checked_names("coordinates", self.names), times=checked_times("coordinates", self.times))
        put_fields(self, values=checked_numbers("coordinates", self.values, (len(self.times), len(self.names))))
        if not np.isfinite(self.values).all():
            frame, column = np.argwhere(~np.isfinite(self.values))[0]
            raise ArgumentError(f"coordinates: {self.names[column]!r} is not a finite number in frame {frame + 1}")


def column_of(names: Sequence[str], values: Floats, name: str, what: str = "coordinate") -> Floats:
    """The values (F,) of one coordinate, of (F, K) in the order of the names; see `Coordinates.of`."""
    if name not in names:
        raise ArgumentError(f"no {what} {name!r}; there are {', '.join(names)}")
    return values[:, names.index(name)]


def columns_to_dataframe(times: Floats, names: Sequence[str], values: Floats) -> pandas.DataFrame:
    """Values (F, K) over times (F,) as a table; raises Error where pandas is not installed."""
    columns = [Labelled(name, ("time",), one) for name, one in zip(names, values.T, strict=True)]
    return to_dataframe(Labelled("time", ("time",), times), columns, {})


@dataclass(frozen=True, repr=False)
class Plate(Tabulated):
    """A force on a body in F frames, as a force plate under a foot measures it; ground axes, unless told otherwise."""

    name: str
    body: str | None  # of the model; None: not told
    force: Floats  # (F, 3) N
    point: Floats  # (F, 3) m, where it acts
    moment: Floats  # (F, 3) N m, about that point
    axes_of: str | None = None  # body of an OpenSim model in whose axes force and moment are; None: the ground's
    point_on: str | None = None  # body from whose origin, in whose axes, the point is


@dataclass(frozen=True, repr=False)
class Loads(Tabulated):
    """Forces of P plates in F frames.

    Raises:
        ArgumentError: shapes that do not go together, times that do not increase, a name that stands twice, a force
            that is not finite.
    """

    times: Floats  # (F,) s
    plates: tuple[Plate, ...]  # (P,)

    def __post_init__(self) -> None:
        if not isinstance(self.plates, list | tuple):
            raise ArgumentError(f"loads: plates must be a list of plates, not {in_words(self.plates)}")
        for plate in self.plates:
            as_kind(Plate, plate, "loads: each plate")
        checked_names("loads", [plate.name for plate in self.plates])
        put_fields(self, plates=tuple(self.plates), times=checked_times("loads", self.times))
        for plate in self.plates:
            for what, unit, most in (("force", "N", STRONGEST), ("point", "m", FARTHEST), ("moment", "N m", STRONGEST)):
                values = checked_numbers(f"loads: {what} of {plate.name!r}", getattr(plate, what), (len(self.times), 3))
                put_fields(plate, **{what: values})
                if not (np.abs(values) <= most).all():
                    frame, axis = np.argwhere(~(np.abs(values) <= most))[0].tolist()
                    found = values[frame, axis]
                    wrong = f"{found:.3g} {unit}" if np.isfinite(found) else "not a finite number"
                    raise ArgumentError(f"loads: {what} of {plate.name!r} is {wrong} in frame {frame + 1}")


def each_of(kind: type, given: Any, what: str, hint: str = "", none: bool = False) -> list[Any]:
    """One of a kind, or several, as a list; raises ArgumentError where one is of another kind.

    Args:
        what: the argument's name, in the plural. hint: where such a thing comes from. none: whether None is one.
    """
    several = isinstance(given, Iterable) and not isinstance(given, str | bytes | PathLike | Mapping | np.ndarray)
    found = list(given) if several and not isinstance(given, kind) else [given]
    for one in found:
        if not isinstance(one, kind) and not (none and one is None):
            raise ArgumentError(f"{what} must be {kind.__name__} of each trial{hint}, not {in_words(one)}")
    return found


@contextmanager
def of_file(path: str | PathLike[str]) -> Iterator[None]:
    """What is wrong with a trial, told with the file that it was read from, as SignalError."""
    try:
        yield
    except ArgumentError as error:
        raise SignalError(str(error), file=str(path)) from None


def checked_times(what: str, times: Any) -> Floats:
    """Times (F,), s, that can be those of a recording; raises ArgumentError."""
    found = _plain(what, times, "times")
    if found.ndim != 1 or not len(found):
        raise ArgumentError(f"{what}: times must be one number a frame, at least one, not of shape {found.shape}")
    known = bool(np.isfinite(found).all())
    steps = np.diff(found) if known else found
    if not known or (steps <= 0.0).any():
        raise ArgumentError(f"{what}: times must be numbers that increase from frame to frame")
    if max(-found[0], found[-1]) > LATEST:
        raise ArgumentError(f"{what}: times reach to {found[np.abs(found).argmax()]:.3g} s; are they in seconds?")
    if len(steps) and steps.min() < SHORTEST:
        frame = int(steps.argmin())
        raise ArgumentError(
            f"{what}: frames {frame + 1} and {frame + 2} are {steps[frame]:.2g} s apart, at {found[frame]:g} s: are "
            "times in seconds?"
        )
    return found


def put_fields(trial: object, **values: object) -> None:
    """Give fields of a frozen part of a trial their values."""
    for name, value in values.items():
        object.__setattr__(trial, name, value)


def checked_names(what: str, names: Any) -> tuple[str, ...]:
    """Names of which none stands twice; raises ArgumentError."""
    if isinstance(names, str):
        raise ArgumentError(f"{what}: names must be a list of texts, not {in_words(names)}")
    found = as_texts(names, f"{what}: names")
    if len(set(found)) < len(found):
        twice = next(name for k, name in enumerate(found) if name in found[:k])
        raise ArgumentError(f"{what}: the name {twice!r} stands twice")
    return found


def _plain(what: str, values: Any, of: str) -> Floats:
    """An array of double precision: the same one if it is; what is masked is no number."""
    if type(values) is np.ndarray and values.dtype == np.float64:
        return values
    if isinstance(values, np.ma.MaskedArray) and values.dtype.kind in "iuf":
        values = np.where(np.ma.getmaskarray(values), np.nan, np.ma.getdata(values))
    return as_array(values, f"{what}: {of}").astype(np.float64)


def checked_numbers(what: str, values: Any, shape: tuple[int, ...]) -> Floats:
    """Numbers of this shape in double precision; raises ArgumentError."""
    found = _plain(what, values, "values")
    if found.shape != shape:
        raise ArgumentError(f"{what}: an array of shape {shape} is needed, not of {found.shape}")
    return found
