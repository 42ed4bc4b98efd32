"""Signals sampled at equal steps of time, with the place in a file that each sample comes from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import SignalError
from warpmuscle.core.plain_text import number_of

ROUNDING = 1e-12  # of a channel's greatest value; what varies less is constant


@dataclass(frozen=True)
class Signals:
    """T samples of C channels."""

    names: tuple[str, ...]  # (C,)
    rate: float  # samples a second, or a cycle
    values: Floats  # (T, C), in the unit of their source
    source: str = ""  # file that they come from
    start: float = 0.0  # s, or cycles, time of the first sample
    lines: Integers | None = None  # (T,), of the file; None where it has no lines

    @property
    def time(self) -> Floats:
        """Times of the samples (T,), s or cycles."""
        return self.start + np.arange(len(self.values)) / self.rate

    @property
    def end(self) -> float:
        """Time of the last sample, s or cycles."""
        return float(self.start + (len(self.values) - 1) / self.rate)

    def changed(self, values: Floats) -> Signals:
        """Other values at the same times."""
        return replace(self, values=values)

    def error(self, message: str, channel: int | None = None, sample: int | None = None) -> SignalError:
        """An error that names the file, and if given the channel and the line, or the time, of a sample."""
        line = 0
        if sample is not None and self.lines is not None:
            line = int(self.lines[sample])
        elif sample is not None:
            message = f"{message}, at {self.time[sample]:.6g} s"
        return SignalError(message, "" if channel is None else self.names[channel], self.source or None, line)

    def between(self, begin: float, end: float) -> Signals:
        """The samples from one time to another, s.

        Raises:
            SignalError: the window is empty, or not within the recording.
        """
        step = 0.5 / self.rate
        if not begin < end:
            raise self.error(f"a window must end after it begins, not go from {begin:g} s to {end:g} s")
        if begin < self.start - step or end > self.end + step:
            raise self.error(f"a window from {begin:g} s to {end:g} s is not within {self.start:g} s to {self.end:g} s")
        inside = np.flatnonzero((self.time >= begin - 1e-9) & (self.time <= end + 1e-9))
        if len(inside) < 2:
            raise self.error(f"the window from {begin:g} s to {end:g} s holds fewer than two samples")
        first, last = int(inside[0]), int(inside[-1]) + 1
        lines = None if self.lines is None else self.lines[first:last]
        return replace(self, values=self.values[first:last], start=float(self.time[first]), lines=lines)


def silent_channels(values: Floats) -> Integers:
    """Numbers of the channels (C,) of values (T, C) that are constant, as of an electrode that has come off."""
    return np.flatnonzero(np.ptp(values, axis=0) <= ROUNDING * np.abs(values).max(axis=0))


def without_silent(signals: Signals) -> tuple[Signals, tuple[str, ...]]:
    """Signals without the channels that are constant, and the names of those.

    Raises:
        SignalError: all channels are.
    """
    silent = silent_channels(signals.values)
    if not len(silent):
        return signals, ()
    kept = [k for k in range(len(signals.names)) if k not in silent]
    if not kept:
        raise signals.error("all channels are constant")
    names = tuple(signals.names[k] for k in kept)
    left_out = tuple(signals.names[k] for k in silent)
    return replace(signals, names=names, values=signals.values[:, kept]), left_out


def check_signals(signals: Signals, silent: bool = False) -> Signals:
    """The same signals, if they can be worked with; `silent`: channels may be constant.

    Raises:
        SignalError: no channels, fewer than two samples, names that repeat, a value that is not finite, or a channel
            that is constant.
    """
    values = signals.values
    if not signals.names:
        raise signals.error("holds no channels")
    if len(values) < 2:
        raise signals.error(f"holds {number_of(len(values), 'sample')}; two are the least")
    for index, name in enumerate(signals.names):
        if name in signals.names[:index]:
            raise signals.error("this name stands for two channels", index)
    wrong = np.argwhere(~np.isfinite(values))
    if len(wrong):
        sample, channel = map(int, wrong[0])
        raise signals.error(f"the value is {values[sample, channel]}, not a finite number", channel, sample)
    constant = silent_channels(values)
    if len(constant) and not silent:
        channel = int(constant[0])
        raise signals.error(f"is {values[0, channel]:g} throughout; leave it out by naming the others", channel)
    return signals


def choose_channels(names: Sequence[str], wanted: Sequence[str], source: str = "") -> list[int]:
    """Numbers of the channels that fit the wanted names or patterns (`*`, `?`), in the order of `wanted`; all if none.

    Raises:
        SignalError: nothing fits one of them.
    """
    if not wanted:
        return list(range(len(names)))
    chosen: list[int] = []
    for pattern in wanted:
        found = [k for k, name in enumerate(names) if name == pattern or fnmatchcase(name, pattern)]
        if not found:
            raise SignalError(f"no channel is called {pattern!r}; there are {', '.join(names)}", file=source or None)
        chosen += [k for k in found if k not in chosen]
    return chosen
