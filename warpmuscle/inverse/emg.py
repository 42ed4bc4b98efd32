"""Envelopes of EMG beside static optimisation."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError, SignalError
from warpmuscle.core.html_table import Tabulated
from warpmuscle.core.plain_text import few_of
from warpmuscle.core.sequences import reaches_over
from warpmuscle.inverse.laboratory.raw_emg import envelopes_of_c3d
from warpmuscle.inverse.plausibility.motions import time_notes
from warpmuscle.inverse.trial import TrialWarning, checked_names, checked_numbers, checked_times, of_file, put_fields
from warpmuscle.synergy.tables import check_rising, finite_columns, read_table

LISTED = 4


@dataclass(frozen=True, repr=False)
class Emg(Tabulated):
    """Envelopes of EMG as activations, 0 to 1, of K muscles of a model, over time.

    Raises:
        ArgumentError: shapes that do not go together, times that do not increase, a value that is not from 0 to 1.
    """

    muscles: tuple[str, ...]  # (K,)
    times: Floats  # (F,) s
    values: Floats  # (F, K)

    def __post_init__(self) -> None:
        put_fields(self, muscles=checked_names("EMG", self.muscles), times=checked_times("EMG", self.times))
        put_fields(self, values=checked_numbers("EMG", self.values, (len(self.times), len(self.muscles))))
        if not ((self.values >= 0.0) & (self.values <= 1.0)).all():
            raise ArgumentError("EMG: envelopes must be from 0 to 1; divide them by those of greatest efforts")

    def at(self, times: Floats) -> Floats:
        """Envelopes (n, K) at other times, whatever the rate of either.

        Raises:
            ArgumentError: times that the EMG does not reach over.
        """
        if not reaches_over(self.times, times[0], times[-1]):
            raise ArgumentError(
                f"the EMG reaches from {self.times[0]:g} to {self.times[-1]:g} s, the motion from {times[0]:g} to "
                f"{times[-1]:g} s; cut the motion, or give EMG of its time"
            )
        return np.stack([np.interp(times, self.times, column) for column in self.values.T], axis=1)


def read_emg(path: str | Path, muscles: Sequence[str], channels: Mapping[str, str] | None = None) -> Emg:
    """Envelopes from a `.sto`, `.mot` or `.csv`, whose columns have the names of muscles; others are left aside.

    Raw EMG of a `.c3d` is made envelopes, see `laboratory.raw_emg`.

    Args:
        muscles: of the model. channels: of a `.c3d`, names of its analog channels by muscle; without, they have the
            names of muscles.

    Warns:
        TrialWarning: columns that no muscle has the name of, envelopes that are zero throughout, holes in time.

    Raises:
        SignalError: the file cannot be read, has no times or muscles, or values that are not from 0 to 1.
    """
    if Path(path).suffix.lower() == ".c3d":
        found = envelopes_of_c3d(path, muscles, channels)
        with of_file(path):
            return Emg(*found)
    if channels:
        raise SignalError("channels are named for a .c3d only; name its columns as muscles", file=path)
    table = read_table(path)
    names = [name.strip() for name in table.names]
    if "time" not in names:
        raise SignalError("no column of time; name one `time`", file=path)
    known = [name for name in muscles if name in names]
    if not known:
        raise SignalError(f"no column has the name of a muscle; the model's are {', '.join(list(muscles)[:6])}, ...",
                          file=path)  # fmt: skip
    twice = next((name for name in ("time", *known) if names.count(name) > 1), None)
    if twice is not None:
        raise SignalError(f"two columns are called {twice!r}; rename or remove one", file=path)
    values = finite_columns(table, [names.index("time"), *map(names.index, known)], ["time", *known])
    check_rising(table, values[:, 0])
    left = [name for name in names if name not in (*known, "time")]
    for note in _notes(left, known, values):
        warnings.warn(f"{path}: {note}", TrialWarning, stacklevel=2)
    with of_file(path):
        return Emg(tuple(known), values[:, 0], values[:, 1:])


def _notes(left: Sequence[str], known: Sequence[str], values: Floats) -> list[str]:
    """What is to be known of envelopes: columns of no muscle, dead channels, holes."""
    notes = time_notes("EMG", values[:, 0])
    if left:
        some = few_of(list(map(repr, left)), LISTED)
        notes.append(f"no muscle of the model is called {some}: what stands there does not count")
    still = [name for name, column in zip(known, values[:, 1:].T, strict=True)
             if len(column) > 1 and column[0] > 0.0 and not np.ptp(column)]  # fmt: skip
    if still:
        notes.append(f"{', '.join(still[:LISTED])} never changes, as of a saturated channel: its muscle is held there; "
                     "remove the column if it was not measured")  # fmt: skip
    dead = [name for name, column in zip(known, values[:, 1:].T, strict=True) if not column.any()]
    if dead:
        notes.append(f"{', '.join(dead[:LISTED])} is zero throughout, as of a dead channel: its muscle is held back; "
                     "remove the column if it was not measured")  # fmt: skip
    return notes
