"""The heart's signal removed from electromyograms by independent component analysis (Willigenburg et al. 2012).

Channels are unmixed by scikit-learn's FastICA; components that hold the heart's beats are left out when they are mixed
again. Such a component is the one that goes with a reference channel, or without one it is recognised by its beats:
short, regular, 40 to 180 a minute.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.signal import butter, find_peaks, sosfiltfilt

from warpmuscle.errors import Error
from warpmuscle.synergy.signals import Floats, Signals

BEAT_BAND = (8.0, 30.0)  # Hz, where most of a QRS complex is
INTERVAL = (60.0 / 180.0, 60.0 / 40.0)  # s, between beats
BEAT = 0.1  # s, on both sides of a beat's peak
LEAST_BEATS = 4
SPREAD = 0.15  # of intervals: half the range of the middle half, over the median
CONCENTRATION = 0.6  # least share of the power near beats
AGREEMENT = 0.5  # least correlation with a reference channel


@dataclass(frozen=True)
class EcgRemoval:
    """What was removed."""

    signals: Signals
    components: int  # how many
    share: Floats  # (C,) of each channel's power


def remove_ecg(signals: Signals, reference: Floats | None = None, seed: int = 0) -> EcgRemoval:
    """Signals without the components that hold the heart's beats; all of them if there is no such component.

    Args:
        signals: band-passed, of two channels or more; components are as many as channels.
        reference: (T,) an electrocardiogram, band-passed alike, which is unmixed with them.
        seed: of the start of the analysis.

    Raises:
        SignalError: fewer than two channels.
        Error: scikit-learn is not installed.
    """
    decomposition, convergence = _sklearn()
    values = signals.values if reference is None else np.column_stack([signals.values, reference])
    if values.shape[1] < 2:
        raise signals.error("one channel alone holds nothing to tell the heart's signal by; at least two are needed")
    scale = values.std(axis=0)
    analysis = decomposition.FastICA(whiten="unit-variance", random_state=seed, max_iter=1000, tol=1e-4)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", convergence)  # gaussian components never settle; those of the heart do at once
        sources = analysis.fit_transform(values / scale)
    if reference is None:
        found = [k for k in range(sources.shape[1]) if is_heart(sources[:, k], signals.rate)]
    else:
        centred = (reference - reference.mean()) / reference.std()
        agreement = np.abs(sources.T @ centred) / (len(centred) * sources.std(axis=0))
        found = np.flatnonzero(agreement >= AGREEMENT).tolist()
    removed = (sources[:, found] @ analysis.mixing_[:, found].T * scale)[:, : signals.values.shape[1]]
    share = np.mean(removed**2, axis=0) / np.mean(signals.values**2, axis=0)
    return EcgRemoval(signals.changed(signals.values - removed), len(found), share)


def is_heart(source: Floats, rate: float) -> bool:
    """Whether a component (T,), sampled at `rate` 1/s, consists of short regular beats."""
    if rate <= 2.0 * BEAT_BAND[1]:
        return False
    beats = np.abs(sosfiltfilt(butter(2, BEAT_BAND, "bandpass", fs=rate, output="sos"), source))
    peaks, _ = find_peaks(beats, height=0.35 * np.quantile(beats, 0.999), distance=max(1, int(INTERVAL[0] * rate)))
    if len(peaks) < LEAST_BEATS:
        return False
    low, middle, high = np.quantile(np.diff(peaks) / rate, (0.25, 0.5, 0.75))
    near = np.zeros(len(beats), bool)
    reach = int(BEAT * rate)
    for peak in peaks:
        near[max(0, peak - reach) : peak + reach] = True
    concentrated = float(np.sum(beats[near] ** 2) / np.sum(beats**2)) >= CONCENTRATION
    regular = bool(high - low <= 2.0 * SPREAD * middle)
    return concentrated and regular and bool(INTERVAL[0] <= middle <= INTERVAL[1])


def _sklearn() -> tuple[Any, type[Warning]]:
    try:
        from sklearn import decomposition
        from sklearn.exceptions import ConvergenceWarning
    except ImportError:
        raise Error("removing the heart's signal needs scikit-learn: pip install 'warpmuscle[synergies]'") from None
    return decomposition, ConvergenceWarning
