"""From raw electromyograms to envelopes: band-pass, rectify, low-pass, resample, normalise.

The chain of Cruz Ruiz et al. 2015 (section 2.2, after Konrad 2005): 10-450 Hz, rectified, 6 Hz. Filters are of
Butterworth's kind and run forwards and backwards, so that they add no lag; the order is that of one pass. A low-pass of
6 Hz suits slow movements and makes envelopes so smooth that few synergies explain much; for gait 20 Hz is usual.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import butter, sosfiltfilt

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SignalError
from warpmuscle.core.limits import check_size
from warpmuscle.core.plain_text import number_of
from warpmuscle.synergy.signals import Signals, check_signals

FINEST = 10  # times the rate of a recording, to which it can be resampled


@dataclass(frozen=True)
class Chain:
    """How a raw signal becomes an envelope."""

    band: tuple[float, float] | None = (10.0, 450.0)  # Hz
    low_pass: float = 6.0  # Hz
    order: int = 4  # of each pass of each filter; a band-pass has it at both ends

    def __post_init__(self) -> None:
        """Raise SignalError for frequencies that make no filter."""
        if self.band is not None and not 0.0 < self.band[0] < self.band[1] < np.inf:
            raise SignalError(f"a band must lie above 0 Hz and end above its start, not {self.band[0]:g} to "
                              f"{self.band[1]:g} Hz")  # fmt: skip
        if not 0.0 < self.low_pass < np.inf:
            raise SignalError(f"a low-pass must lie above 0 Hz, not at {self.low_pass:g} Hz")
        if not 1 <= self.order <= 10:
            raise SignalError(f"the order of a filter must be from 1 to 10, not {self.order}")


def band_passed(signals: Signals, chain: Chain) -> Signals:
    """The signals without their mean, within the band.

    Raises:
        SignalError: the sampling rate is too low for the band, or the recording too short for the filter.
    """
    values = signals.values - signals.values.mean(axis=0)
    if chain.band is None:
        return signals.changed(values)
    _check_rate(signals, chain.band[1], f"a band up to {chain.band[1]:g} Hz")
    _check_length(signals, chain.band[0], f"a band from {chain.band[0]:g} Hz on")
    sections = butter(chain.order, chain.band, "bandpass", fs=signals.rate, output="sos")
    return signals.changed(_zero_lag(signals, sections, values))


def envelope(signals: Signals, chain: Chain) -> Signals:
    """Rectified and low-passed, nowhere negative.

    Raises:
        SignalError: the sampling rate is too low for the low-pass, or the recording too short for the filter.
    """
    _check_rate(signals, chain.low_pass, f"a low-pass of {chain.low_pass:g} Hz")
    _check_length(signals, chain.low_pass, f"a low-pass of {chain.low_pass:g} Hz")
    sections = butter(chain.order, chain.low_pass, "lowpass", fs=signals.rate, output="sos")
    return signals.changed(np.maximum(_zero_lag(signals, sections, np.abs(signals.values)), 0.0))


def given_envelope(signals: Signals) -> Signals:
    """Signals that are envelopes already, if they can be.

    Raises:
        SignalError: a value is negative.
    """
    negative = np.argwhere(signals.values < 0.0)
    if len(negative):
        sample, channel = map(int, negative[0])
        raise signals.error(
            f"is {signals.values[sample, channel]:g}, but an envelope is never negative; is this a raw signal?",
            channel, sample,
        )  # fmt: skip
    return signals


def resampled(signals: Signals, rate: float) -> Signals:
    """Signals at another rate, 1/s, interpolated between samples; low-pass them below half of it first.

    Raises:
        SignalError: the rate is not greater than 0, leaves fewer than two samples, or is far above the signals' own.
    """
    if not (np.isfinite(rate) and rate > 0.0):
        raise signals.error(f"a rate must be greater than 0, not {rate:g} 1/s")
    if rate > FINEST * signals.rate:
        raise signals.error(
            f"at most {FINEST * signals.rate:g} activations a second are interpolated from {signals.rate:g} a second"
        )
    count = int(np.floor((signals.end - signals.start) * rate + 1e-6)) + 1
    check_size("samples", count * len(signals.names), signals.error)
    if count < 2:
        raise signals.error(f"lasts {signals.end - signals.start:g} s, too short for samples at {rate:g} 1/s")
    changed = replace(signals, rate=rate, lines=None, values=np.zeros((count, 0)))
    return changed.changed(at_times(signals, changed.time))


def at_times(signals: Signals, time: Floats) -> Floats:
    """Values (n, C) at times (n,), s, interpolated."""
    own = signals.time
    return np.stack([np.interp(time, own, column) for column in signals.values.T], axis=1)


def _check_rate(signals: Signals, frequency: float, what: str) -> None:
    if frequency >= 0.5 * signals.rate:
        raise signals.error(
            f"{what} needs a sampling rate above {2.0 * frequency:g} 1/s, this one is {signals.rate:.6g} 1/s; "
            "ask for a lower frequency"
        )


def _check_length(signals: Signals, frequency: float, what: str) -> None:
    """What is shorter than a period of a filter is all transient: its envelope may well be 0 throughout."""
    lasts = len(signals.values) / signals.rate
    if lasts < 1.0 / frequency:
        raise signals.error(
            f"{number_of(len(signals.values), 'sample', 'last')} {lasts:.3g} s, too short for {what}, which takes "
            "at least one period, "
            f"{1.0 / frequency:.3g} s"
        )


def _zero_lag(signals: Signals, sections: Floats, values: Floats) -> Floats:
    try:
        return np.asarray(sosfiltfilt(sections, values, axis=0), np.float64)
    except ValueError:  # says how long a signal must be, in the library's words
        raise signals.error(f"holds {number_of(len(values), 'sample')}, too few for the filter") from None


def normalised(values: Floats, maxima: Floats, signals: Signals, subtract_minimum: bool = False) -> Floats:
    """Values (T, C) over their maxima (C,), each channel's least value subtracted from both before if asked for.

    Raises:
        SignalError: a channel has nothing to normalise by.
    """
    if subtract_minimum:
        least = values.min(axis=0)
        values, maxima = values - least, maxima - least
    check_signals(replace(signals, values=values, lines=None))
    lacking = np.flatnonzero(maxima <= 0.0)
    if len(lacking):
        raise signals.error(f"its maximum is {maxima[lacking[0]]:g}, nothing to normalise by", int(lacking[0]))
    return values / maxima
