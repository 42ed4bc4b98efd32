"""From recordings to one matrix of activations: read, filter, cut, resample, join, normalise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import SignalError
from warpmuscle.core.plain_text import number_of
from warpmuscle.synergy.cycles import by_cycles, read_cycles
from warpmuscle.synergy.ecg import EcgRemoval, remove_ecg
from warpmuscle.synergy.emg import Chain, band_passed, envelope, given_envelope, normalised, resampled
from warpmuscle.synergy.recordings import read_signals
from warpmuscle.synergy.signals import Signals, silent_channels, without_silent


@dataclass(frozen=True)
class Preparation:
    """What is done with recordings."""

    channels: tuple[str, ...] = ()  # names or patterns; all if empty
    sampling_rate: float | None = None  # 1/s, of files without times
    chain: Chain = field(default_factory=Chain)
    already_filtered: bool = False  # what is read are envelopes
    ecg: str = ""  # remove the heart's signal: "auto", or the name of a channel with an electrocardiogram
    window: tuple[float, float] | None = None  # s
    rate: float | None = 100.0  # 1/s, of the activations; None for that of the files
    cycles: tuple[Path, ...] = ()  # a file of cycles a recording
    cycle_range: tuple[int, int] | None = None  # first and last cycle, counted from 1
    points: int = 200  # a cycle
    subtract_minimum: bool = False
    maxima: Path | None = None  # recording of maximum voluntary contractions; else the greatest values normalise


@dataclass(frozen=True)
class Activations:
    """T samples of M muscles, 0..1 but for what exceeds a maximum voluntary contraction."""

    muscles: tuple[str, ...]  # (M,)
    values: Floats  # (T, M)
    time: Floats  # (T,), s within each recording, or cycles
    time_unit: str  # "s" or "cycle"
    trial: Integers  # (T,), number of the recording, or of the cycle, from 0
    maxima: Floats  # (M,), what 1 stands for in the unit of the recordings
    sources: tuple[str, ...]  # files
    notes: tuple[str, ...] = ()  # what else is worth knowing


def prepare(paths: Sequence[str | Path], preparation: Preparation) -> Activations:
    """Activations of recordings, joined in their order and normalised over all of them.

    Raises:
        SignalError: a recording cannot be used, or does not fit what is asked for.
    """
    _check(paths, preparation)
    notes: list[str] = []
    parts: list[Signals] = []
    trials: list[Integers] = []
    left_out: set[str] = set()
    for index, path in enumerate(paths):
        whole, silent = _filtered(path, preparation, notes)
        left_out |= silent
        if parts and _without(whole, left_out).names != _without(parts[0], left_out).names:
            raise whole.error(f"its channels are {', '.join(whole.names)}, not {', '.join(parts[0].names)} as before")
        part = _cut(whole, preparation, index)
        count = len(part.values)
        begun = int(trials[-1][-1]) + 1 if trials else 0
        trials.append(begun + (np.arange(count) // preparation.points if preparation.cycles else np.zeros(count, int)))
        parts.append(part)
    strongest = None
    if preparation.maxima is not None:
        strongest, silent = _filtered(preparation.maxima, preparation, notes)
        left_out |= silent
    parts, values = _joined(parts, left_out)
    if len(quiet := silent_channels(values)):
        quieter = {parts[0].names[k] for k in quiet}
        notes.append(f"{', '.join(sorted(quieter))}: silent in what is used, and left out")
        left_out |= quieter
        parts, values = _joined(parts, left_out)
    maxima = values.max(axis=0)
    if strongest is not None:
        strongest = _without(strongest, left_out)
        if strongest.names != parts[0].names:
            raise strongest.error(f"its channels are {', '.join(strongest.names)}, not {', '.join(parts[0].names)}")
        maxima = strongest.values.max(axis=0)
    scaled = normalised(values, maxima, parts[0], preparation.subtract_minimum)
    if preparation.maxima is not None and scaled.max() > 1.0:
        most = int(scaled.max(axis=0).argmax())
        notes.append(f"{parts[0].names[most]} reaches {scaled[:, most].max():.2f} of its maximum voluntary contraction")
    time = np.concatenate([part.time for part in parts])
    unit = "cycle" if preparation.cycles else "s"
    sources = tuple(str(path) for path in paths)
    return Activations(parts[0].names, scaled, time, unit, np.concatenate(trials), maxima, sources, tuple(notes))


def _check(paths: Sequence[str | Path], preparation: Preparation) -> None:
    """There are recordings, and what cuts them fits."""
    if not paths:
        raise SignalError("there are no recordings")
    if preparation.cycles and len(preparation.cycles) != len(paths):
        raise SignalError(
            f"{number_of(len(preparation.cycles), 'cycle file')} for {number_of(len(paths), 'recording')}"
        )
    if preparation.cycles and preparation.window is not None:
        raise SignalError("a time window and cycles both cut a recording; give one of them")
    if preparation.cycle_range is not None and not preparation.cycles:
        raise SignalError("a range of cycles needs files of cycles")


def _joined(parts: list[Signals], left_out: set[str]) -> tuple[list[Signals], Floats]:
    """Recordings without some channels, and their values one behind the other."""
    kept = [_without(part, left_out) for part in parts]
    return kept, np.concatenate([part.values for part in kept])


def _without(signals: Signals, left_out: set[str]) -> Signals:
    """Signals without some channels.

    Raises:
        SignalError: none is left.
    """
    kept = [k for k, name in enumerate(signals.names) if name not in left_out]
    if not kept:
        raise signals.error("no channel is left that is not silent somewhere")
    return replace(signals, names=tuple(signals.names[k] for k in kept), values=signals.values[:, kept])


def _filtered(path: str | Path, preparation: Preparation, notes: list[str]) -> tuple[Signals, set[str]]:
    """The envelopes of a recording, of its whole length at its own rate, and what was silent in it."""
    reference = preparation.ecg if preparation.ecg not in ("", "auto") else ""
    wanted = (*preparation.channels, reference) if reference and preparation.channels else preparation.channels
    signals, silent = without_silent(read_signals(path, wanted, preparation.sampling_rate, silent=True))
    if reference and reference in silent:
        raise signals.error(f"the channel of the heart, {reference!r}, is constant")
    if silent:
        notes.append(f"{Path(path).name}: {', '.join(silent)} is silent and left out" if len(silent) == 1 else
                     f"{Path(path).name}: {', '.join(silent)} are silent and left out")  # fmt: skip
    if preparation.already_filtered:
        if preparation.ecg:
            raise signals.error("the heart's signal is removed from raw signals, not from envelopes")
        return given_envelope(signals), set(silent)
    signals = band_passed(signals, preparation.chain)
    if preparation.ecg:
        heart = None
        if reference:
            if reference not in signals.names:
                raise signals.error(f"no channel is called {reference!r}; there are {', '.join(signals.names)}")
            column = signals.names.index(reference)
            heart = signals.values[:, column]
            names = signals.names[:column] + signals.names[column + 1 :]
            signals = replace(signals, names=names, values=np.delete(signals.values, column, axis=1))
        removal = remove_ecg(signals, heart)
        signals = removal.signals
        notes.append(_removal_in_words(Path(path).name, removal))
    return envelope(signals, preparation.chain), set(silent)


def _removal_in_words(name: str, removal: EcgRemoval) -> str:
    """What was removed from a recording, in words."""
    if not removal.rates:
        return f"{name}: no component holds the heart's signal, nothing was removed"
    worst = int(removal.share.argmax())
    rates = ", ".join(f"{rate:.0f}" if rate > 0.0 else "irregular" for rate in removal.rates)
    return (
        f"{name}: the heart's signal was removed ({rates} beats a minute), at most "
        f"{removal.share[worst]:.0%} of a channel's power, in {removal.signals.names[worst]}"
    )


def _cut(signals: Signals, preparation: Preparation, index: int) -> Signals:
    """The part of a recording that is wanted, at the wanted rate or by cycles."""
    if preparation.cycles:
        cycles = read_cycles(preparation.cycles[index])
        if preparation.cycle_range is not None:
            cycles = cycles.chosen(*preparation.cycle_range)
        return by_cycles(signals, cycles, preparation.points)
    if preparation.window is not None:
        signals = signals.between(*preparation.window)
    if preparation.rate is None:
        return signals
    if not preparation.already_filtered and preparation.rate <= 2.0 * preparation.chain.low_pass:
        raise signals.error(
            f"{preparation.rate:g} activations a second cannot hold a low-pass of {preparation.chain.low_pass:g} Hz; "
            f"ask for more than {2.0 * preparation.chain.low_pass:g}"
        )
    return resampled(signals, preparation.rate)
