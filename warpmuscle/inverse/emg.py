"""Envelopes of EMG beside static optimisation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError, SignalError
from warpmuscle.synergy.tables import read_table


@dataclass(frozen=True)
class Emg:
    """Envelopes of EMG as activations, 0 to 1, of K muscles of a model, over time.

    Raises:
        ArgumentError: shapes that do not go together, times that do not increase, a value that is not from 0 to 1.
    """

    muscles: tuple[str, ...]  # (K,)
    times: Floats  # (F,) s
    values: Floats  # (F, K)

    def __post_init__(self) -> None:
        if np.shape(self.values) != (len(self.times), len(self.muscles)):
            raise ArgumentError(
                f"EMG: values are (times, muscles), {(len(self.times), len(self.muscles))}, not {np.shape(self.values)}"
            )
        if len(self.times) < 1 or not (np.diff(self.times) > 0.0).all():
            raise ArgumentError("EMG: times must increase")
        if not ((self.values >= 0.0) & (self.values <= 1.0)).all():
            raise ArgumentError("EMG: envelopes must be from 0 to 1; divide them by those of greatest efforts")

    def at(self, times: Floats) -> Floats:
        """Envelopes (n, K) at other times, whatever the rate of either.

        Raises:
            ArgumentError: times that the EMG does not reach over.
        """
        late = 1.5 * float(np.median(np.diff(self.times))) if len(self.times) > 1 else 0.0
        if times[0] < self.times[0] - late or times[-1] > self.times[-1] + late:
            raise ArgumentError(
                f"the EMG reaches from {self.times[0]:g} to {self.times[-1]:g} s, the motion from {times[0]:g} to "
                f"{times[-1]:g} s; cut the motion, or give EMG of its time"
            )
        return np.stack([np.interp(times, self.times, column) for column in self.values.T], axis=1)


def read_emg(path: str | Path, muscles: Sequence[str]) -> Emg:
    """Envelopes from a `.sto`, `.mot` or `.csv`, whose columns have the names of muscles; others are left aside.

    Args:
        muscles: of the model.

    Raises:
        SignalError: the file cannot be read, has no times or muscles, or values that are not from 0 to 1.
    """
    table = read_table(path)
    names = [name.strip() for name in table.names]
    if "time" not in names:
        raise SignalError("no column of time; name one `time`", file=path)
    known = [name for name in muscles if name in names]
    if not known:
        raise SignalError(f"no column has the name of a muscle; the model's are {', '.join(list(muscles)[:6])}, ...",
                          file=path)  # fmt: skip
    values = table.columns([names.index("time"), *map(names.index, known)])
    if not np.isfinite(values).all():
        row, column = np.argwhere(~np.isfinite(values))[0]
        what = ["time", *known][int(column)]
        raise SignalError(f"column {what!r} is not a finite number", file=path, line=int(table.lines[int(row)]))
    try:
        return Emg(tuple(known), values[:, 0], values[:, 1:])
    except ArgumentError as error:
        raise SignalError(str(error), file=path) from None
