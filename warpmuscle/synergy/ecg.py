"""The heart's signal removed from electromyograms by independent component analysis (Willigenburg et al. 2012).

Channels are unmixed by scikit-learn's FastICA; of components that hold the heart's beats only what is faster than
40 Hz, which is muscle, is mixed again. Such a component goes with a reference channel, or without one is recognised by
its beats: short, regular, each like the others, 40 to 180 a minute. Artefacts of the steps of a regular gait are like
that, too; name a reference channel then, or leave the heart in.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, find_peaks, sosfiltfilt

from warpmuscle.core.array_types import Floats
from warpmuscle.core.extras import imported
from warpmuscle.synergy.signals import Signals

BEAT_BAND = (8.0, 30.0)  # Hz, where most of a QRS complex is
HEART = 40.0  # Hz, what is faster in a component of the heart is muscle that leaked into it
INTERVAL = (60.0 / 180.0, 60.0 / 40.0)  # s, between beats
BEAT = 0.1  # s, on both sides of a beat's peak
LEAST_BEATS = 4
SPREAD = 0.15  # of intervals: half the range of the middle half, over the median
CONCENTRATION = 0.6  # least share of the power near beats
LIKENESS = 0.8  # least median correlation of beats with their mean; bursts of EMG are noise that averages out
AGREEMENT = 0.5  # least correlation with a reference channel


@dataclass(frozen=True)
class EcgRemoval:
    """What was removed."""

    signals: Signals
    rates: tuple[float, ...]  # beats a minute, of each component that was removed
    share: Floats  # (C,) of each channel's power


def remove_ecg(signals: Signals, reference: Floats | None = None, seed: int = 0) -> EcgRemoval:
    """Signals without the components that hold the heart's beats; all of them if there is no such component.

    Args:
        signals: band-passed, of two channels or more; components are as many as channels.
        reference: (T,) an electrocardiogram, band-passed alike, which is unmixed with them.
        seed: of the start of the analysis.

    Raises:
        SignalError: fewer than two channels, or too low a sampling rate.
        Error: scikit-learn is not installed.
    """
    decomposition = imported("sklearn.decomposition", "removing the heart's signal needs")
    from sklearn.exceptions import ConvergenceWarning

    values = signals.values if reference is None else np.column_stack([signals.values, reference])
    if values.shape[1] < 2:
        raise signals.error("one channel alone holds nothing to tell the heart's signal by; at least two are needed")
    scale = values.std(axis=0)
    analysis = decomposition.FastICA(whiten="unit-variance", random_state=seed, max_iter=1000, tol=1e-4)
    with warnings.catch_warnings():
        # Gaussian components never settle; those of the heart do at once.
        warnings.simplefilter("ignore", ConvergenceWarning)
        sources = analysis.fit_transform(values / scale)
    if signals.rate <= 2.0 * HEART:
        raise signals.error(
            f"the heart's signal cannot be told from muscles' at {signals.rate:.6g} 1/s, too low a rate"
        )
    beats = [beat_rate(source, signals.rate) for source in sources.T]
    if reference is None:
        found = [k for k, beat in enumerate(beats) if beat > 0.0]
    else:
        centred = (reference - reference.mean()) / reference.std()
        agreement = np.abs(sources.T @ centred) / (len(centred) * sources.std(axis=0))
        found = np.flatnonzero(agreement >= AGREEMENT).tolist()
    slow = sosfiltfilt(butter(4, HEART, fs=signals.rate, output="sos"), sources[:, found], axis=0)
    removed = (slow @ analysis.mixing_[:, found].T * scale)[:, : signals.values.shape[1]]
    share = np.mean(removed**2, axis=0) / np.mean(signals.values**2, axis=0)
    return EcgRemoval(signals.changed(signals.values - removed), tuple(beats[k] for k in found), share)


def beat_rate(source: Floats, rate: float) -> float:
    """Beats a minute of a component (T,), sampled at `rate` 1/s; 0 unless they are short, regular and alike."""
    if len(source) < 2.0 * INTERVAL[1] * rate:
        return 0.0
    wave = sosfiltfilt(butter(2, BEAT_BAND, "bandpass", fs=rate, output="sos"), source)
    size, reach = np.abs(wave), int(BEAT * rate)
    peaks, _ = find_peaks(size, height=0.35 * np.quantile(size, 0.999), distance=max(1, int(INTERVAL[0] * rate)))
    peaks = peaks[(peaks >= reach) & (peaks < len(wave) - reach)]
    if len(peaks) < LEAST_BEATS:
        return 0.0
    low, middle, high = np.quantile(np.diff(peaks) / rate, (0.25, 0.5, 0.75))
    if high - low > 2.0 * SPREAD * middle or not INTERVAL[0] <= middle <= INTERVAL[1]:
        return 0.0
    beats = np.stack([wave[peak - reach : peak + reach] for peak in peaks])
    mean = beats.mean(axis=0)
    likeness = beats @ mean / (np.linalg.norm(beats, axis=1) * np.linalg.norm(mean))
    concentration = np.sum(beats**2) / np.sum(wave**2)
    alike = concentration >= CONCENTRATION and np.median(likeness) >= LIKENESS
    return 60.0 / float(middle) if alike else 0.0
