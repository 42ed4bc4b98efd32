"""The heart's signal is removed from EMG, and nothing else."""

import numpy as np
import pytest
from synthetic_emg import NAMES, RATE, raw_emg

from warpmuscle.core.errors import SignalError
from warpmuscle.synergy.ecg import remove_ecg
from warpmuscle.synergy.emg import Chain, band_passed, envelope
from warpmuscle.synergy.signals import Signals

GAINS = np.array([0.0, 2.0, 0.1, 0.0, 0.0, 0.05, 3.0])  # of the heart in each channel


def heart(time):
    """Beats (T,), 72 a minute with some change: Q, R and S waves of 10 to 20 ms."""
    beats = np.cumsum(60.0 / 72.0 + 0.03 * np.sin(np.arange(40)))
    shape = [(-0.025, -0.2, 0.010), (0.0, 1.0, 0.012), (0.028, -0.3, 0.012)]
    return sum(
        height * np.exp(-(((time[:, None] - beats - shift) / width) ** 2)).sum(axis=1) for shift, height, width in shape
    )


@pytest.mark.parametrize("with_reference", [False, True])
def test_heart_is_removed_and_muscles_are_kept(with_reference):
    clean = raw_emg(12.0)
    ecg = heart(clean.time)
    dirty = clean.changed(clean.values + ecg[:, None] * GAINS)
    noisy = ecg + 0.02 * np.random.default_rng(1).normal(size=len(ecg))
    reference = band_passed(Signals(("ECG",), RATE, noisy[:, None]), Chain()).values[:, 0]
    found = remove_ecg(band_passed(dirty, Chain()), reference if with_reference else None)
    assert len(found.rates) == 1
    assert found.rates[0] == pytest.approx(72.0, abs=3.0)
    wanted = envelope(band_passed(clean, Chain()), Chain()).values
    before = envelope(band_passed(dirty, Chain()), Chain()).values
    after = envelope(found.signals, Chain()).values
    for channel in (1, 6):
        assert np.corrcoef(before[:, channel], wanted[:, channel])[0, 1] < 0.9
        assert np.corrcoef(after[:, channel], wanted[:, channel])[0, 1] > 0.97
    for channel in (0, 2, 3, 4, 5):
        assert np.corrcoef(after[:, channel], wanted[:, channel])[0, 1] > 0.99
    assert found.share.argmax() == 6


def test_nothing_is_removed_where_there_is_no_heart():
    clean = band_passed(raw_emg(12.0), Chain())
    found = remove_ecg(clean)
    assert found.rates == ()
    np.testing.assert_array_equal(found.signals.values, clean.values)


def test_one_channel_alone_is_refused():
    with pytest.raises(SignalError, match="at least two are needed"):
        remove_ecg(Signals(NAMES[:1], RATE, raw_emg().values[:, :1]))
