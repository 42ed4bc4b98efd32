"""Cyclic movements on a common scale: each cycle, such as a stride, by the same number of points.

A file of cycles is a table with a row a cycle: the time, s, at which it begins, such as a touchdown, and if there is a
second column the time at which its second phase begins, such as the lift-off. A cycle ends where the next one begins.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SignalError
from warpmuscle.core.limits import check_size
from warpmuscle.core.plain_text import number_of
from warpmuscle.synergy.emg import at_times
from warpmuscle.synergy.signals import Signals
from warpmuscle.synergy.tables import read_table

MOST_POINTS = 10_000  # of a cycle


@dataclass(frozen=True)
class Cycles:
    """K cycles one after the other."""

    phases: Floats  # (K, P + 1) s: start of each phase, and end of the last one
    source: str = ""

    def chosen(self, first: int, last: int) -> Cycles:
        """Cycles from one number to another, both included, counted from 1.

        Raises:
            SignalError: there are no such cycles.
        """
        if not 1 <= first <= last <= len(self.phases):
            raise SignalError(
                f"holds {number_of(len(self.phases), 'whole cycle')}, so that {first} to {last} cannot be chosen",
                file=self.source or None,
            )
        return Cycles(self.phases[first - 1 : last], self.source)


def read_cycles(path: str | Path) -> Cycles:
    """Read a file of cycles; its last row only ends the cycle before.

    Raises:
        SignalError: the file cannot be read, has not one or two columns or fewer than two rows, or times that do not
            increase.
    """
    table = read_table(path)
    if len(table.names) not in (1, 2):
        raise SignalError(f"has {number_of(len(table.names), 'column')}; cycles have one or two", file=table.path)
    times = table.columns(range(len(table.names)))
    if len(times) < 2:
        raise SignalError(f"holds {number_of(len(times), 'start')} of cycles; two are the least", file=table.path)
    order = times.ravel()
    wrong = np.flatnonzero(~(np.diff(order) > 0.0))  # so that what is no number counts, too
    if len(wrong):
        at = int(wrong[0]) + 1
        line = int(table.lines[at // times.shape[1]])
        what = f"times must increase, but {order[at]:g} s follows {order[at - 1]:g} s"
        raise SignalError(what, table.names[at % times.shape[1]], table.path, line)
    return Cycles(np.concatenate([times[:-1], times[1:, :1]], axis=1), str(path))


def by_cycles(signals: Signals, cycles: Cycles, points: int) -> Signals:
    """Signals (K * points, C) on a scale of cycles: `rate` is the points of a cycle, times count cycles from 0.

    Phases of a cycle get the same number of points each, whatever they last.

    Raises:
        SignalError: a cycle is not within the recording, or the points cannot be shared out among the phases.
    """
    phases = cycles.phases.shape[1] - 1
    if points < 2 * phases or points % phases or points > MOST_POINTS:
        what = f"a multiple of {phases}, from {2 * phases} to {MOST_POINTS}"
        raise SignalError(f"the points of a cycle of {number_of(phases, 'phase')} must be {what}, not {points}")
    begin, end = float(cycles.phases[0, 0]), float(cycles.phases[-1, -1])
    if begin < signals.start or end > signals.end:
        raise SignalError(
            f"cycles from {begin:g} s to {end:g} s are not within {signals.source or 'the recording'}, "
            f"{signals.start:g} s to {signals.end:g} s",
            file=cycles.source or None,
        )
    check_size("samples", len(cycles.phases) * points * len(signals.names), signals.error)
    share = np.arange(points // phases) * (phases / points)
    bounds = cycles.phases
    time = bounds[:, :-1, None] + share * np.diff(bounds, axis=1)[:, :, None]
    return Signals(signals.names, float(points), at_times(signals, time.ravel()), signals.source)
