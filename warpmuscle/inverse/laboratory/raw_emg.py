"""Envelopes of raw EMG in a C3D file, by names of muscles."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SignalError
from warpmuscle.inverse.trial import TrialWarning
from warpmuscle.synergy.emg import Chain, band_passed, envelope
from warpmuscle.synergy.recordings import read_signals
from warpmuscle.synergy.signals import Signals

LEAST = 0.01  # that an envelope comes to, whose greatest effort is 1; volts do not
WITHIN = 0.9  # of half the sampling rate, that a band reaches at most


def envelopes_of_c3d(
    path: str | Path, muscles: Sequence[str], channels: Mapping[str, str] | None = None
) -> tuple[tuple[str, ...], Floats, Floats]:
    """Muscles (K,), times (T,) s, from 0 on, and envelopes (T, K) from 0 to 1 of the analog channels of a file.

    Raw EMG is band-passed, rectified and low-passed by the defaults of `synergy.emg.Chain`, and divided by its greatest
    value; what is nowhere negative is rectified already. Channels that are from 0 to 1 throughout, and not as small as
    volts are, are taken for envelopes as they are.

    Args:
        muscles: of the model. channels: names of channels by muscle; without, channels have the names of muscles.

    Warns:
        TrialWarning: of raw EMG, what it was divided by.

    Raises:
        SignalError: the file cannot be read, a channel is not there or constant, or none has a muscle's name.
    """
    path = Path(path)
    unknown = next((name for name in channels or {} if name not in muscles), None)
    if unknown is not None:
        raise SignalError(f"the model has no muscle {unknown!r}; it has {', '.join(list(muscles)[:6])}, ...", file=path)
    if channels is None:
        names = read_signals(path, silent=True).names
        channels = {name: name for name in muscles if name in names}
    if not channels:
        raise SignalError(
            f"no analog channel has the name of a muscle; the model's are {', '.join(list(muscles)[:6])}, ...; say "
            "which channel is of which muscle",
            file=path,
        )
    signals = read_signals(path, list(dict.fromkeys(channels.values())))
    values = signals.values
    if (values < 0.0).any() or (values > 1.0).any() or (values.max(axis=0) < LEAST).any():
        values = _envelopes(signals)
        values = values / values.max(axis=0)
        warnings.warn(
            f"{path}: raw EMG is divided by its greatest value in this trial: where that is less than a greatest "
            "effort, activations are too high by as much",
            TrialWarning, stacklevel=3,
        )  # fmt: skip
    at = [signals.names.index(name) for name in channels.values()]
    return tuple(channels), signals.time, np.asarray(values[:, at])


def _envelopes(signals: Signals) -> Floats:
    """Raw or rectified EMG low-passed (T, K)."""
    chain = Chain()
    if (signals.values < 0.0).any():
        assert chain.band is not None
        lowest, highest = chain.band[0], min(chain.band[1], 0.5 * WITHIN * signals.rate)
        if highest <= lowest:
            raise signals.error(
                f"EMG is sampled {signals.rate:g} times a second, too few for its band from {lowest:g} Hz on"
            )
        chain = replace(chain, band=(lowest, highest))
        signals = band_passed(signals, chain)
    return envelope(signals, chain).values
