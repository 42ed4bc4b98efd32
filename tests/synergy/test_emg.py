"""The chain from raw EMG to envelopes, step by step."""

import numpy as np
import pytest
from synthetic_emg import RATE, WEIGHTS, coefficients, raw_emg

from warpmuscle.core.errors import SignalError
from warpmuscle.synergy.emg import Chain, band_passed, envelope, given_envelope, normalised, resampled
from warpmuscle.synergy.signals import Signals


def tone(frequency, seconds=4.0, rate=1000.0):
    time = np.arange(int(seconds * rate)) / rate
    return Signals(("a",), rate, np.sin(2.0 * np.pi * frequency * time)[:, None])


@pytest.mark.parametrize(("frequency", "gain"), [(2.0, 0.0), (10.0, 0.5), (100.0, 1.0), (450.0, 0.5), (490.0, 0.0)])
def test_band_pass_halves_at_its_ends_and_adds_no_lag(frequency, gain):
    signals = tone(frequency)
    middle = slice(1000, 3000)
    passed = band_passed(signals, Chain()).values[middle, 0]
    np.testing.assert_allclose(passed, gain * signals.values[middle, 0], atol=0.02)


def test_envelope_follows_the_amplitude_without_lag():
    raw = raw_emg(30.0)
    found = envelope(band_passed(raw, Chain()), Chain())
    amplitude = (WEIGHTS @ coefficients(raw.time)).T
    for channel in range(3):
        lags = range(-40, 41)
        agreement = [np.corrcoef(np.roll(found.values[:, channel], lag), amplitude[:, channel])[0, 1] for lag in lags]
        assert max(agreement) > 0.97
        assert abs(lags[int(np.argmax(agreement))]) <= 10  # samples, ms
    assert found.values.min() >= 0.0


def test_offset_of_a_raw_signal_does_not_matter():
    raw = raw_emg(2.0)
    shifted = raw.changed(raw.values + 7.0)
    np.testing.assert_allclose(
        band_passed(shifted, Chain(band=None)).values, band_passed(raw, Chain(band=None)).values, atol=1e-12
    )


def test_resampling_keeps_a_straight_line_and_its_times():
    signals = Signals(("a",), 1000.0, np.linspace(0.0, 1.0, 1001)[:, None], start=2.0)
    found = resampled(signals, 40.0)
    assert (found.rate, found.start, len(found.values)) == (40.0, 2.0, 41)
    np.testing.assert_allclose(found.values[:, 0], found.time - 2.0, atol=1e-12)


def test_normalisation_divides_by_maxima_and_takes_the_minimum_off():
    signals = Signals(("a", "b"), 1.0, np.array([[1.0, 2.0], [3.0, 4.0], [2.0, 10.0]]))
    np.testing.assert_allclose(normalised(signals.values, np.array([3.0, 20.0]), signals)[:, 1], [0.1, 0.2, 0.5])
    found = normalised(signals.values, signals.values.max(axis=0), signals, subtract_minimum=True)
    np.testing.assert_allclose(found, [[0.0, 0.0], [1.0, 0.25], [0.5, 1.0]])


def test_sampling_rate_too_low_for_a_filter_is_said():
    slow = Signals(("a",), 500.0, raw_emg(2.0).values[:, :1], "slow.csv")
    with pytest.raises(SignalError, match=r"slow.csv: a band up to 450 Hz needs a sampling rate above 900 1/s, this "):
        band_passed(slow, Chain())
    slower = Signals(("a",), 10.0, slow.values, "slow.csv")
    with pytest.raises(SignalError, match=r"a low-pass of 6 Hz needs a sampling rate above 12 1/s, this one is 10 1/s"):
        envelope(slower, Chain())


def test_recording_too_short_for_a_filter_is_said():
    """Of 30 samples the envelope of a channel is 0 throughout, which is the filter's fault and not the channel's."""
    short = Signals(("a",), RATE, raw_emg().values[:30, :1])
    with pytest.raises(SignalError, match=r"30 samples last 0\.03 s, too short for a band from 10 Hz on"):
        band_passed(short, Chain())
    with pytest.raises(SignalError, match=r"a low-pass of 6 Hz, which takes at least one period, 0\.167 s"):
        envelope(short, Chain())
    with pytest.raises(SignalError, match="holds 3 samples, too few for the filter"):
        band_passed(Signals(("a",), 20.0, raw_emg().values[:3, :1]), Chain((8.0, 9.0)))


def test_negative_value_of_an_envelope_is_said_with_its_channel_and_line():
    signals = Signals(("a", "b"), 100.0, np.array([[0.1, 0.2], [0.1, -0.3]]), "e.csv", lines=np.array([2, 3]))
    with pytest.raises(SignalError, match=r"e.csv:3: channel 'b': is -0.3, but an envelope is never negative"):
        given_envelope(signals)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"band": (450.0, 10.0)}, "a band must lie above 0 Hz and end above its start, not 450 to 10 Hz"),
        ({"band": (0.0, 10.0)}, "a band must lie above 0 Hz"),
        ({"low_pass": 0.0}, "a low-pass must lie above 0 Hz, not at 0 Hz"),
        ({"low_pass": np.nan}, "a low-pass must lie above 0 Hz"),
        ({"order": 0}, "the order of a filter must be from 1 to 10, not 0"),
    ],
)
def test_frequencies_that_make_no_filter_are_refused(options, says):
    with pytest.raises(SignalError, match=says):
        Chain(**options)


def test_rate_that_leaves_no_samples_is_said():
    with pytest.raises(SignalError, match=r"lasts 0\.2 s, too short for samples at 2 1/s"):
        resampled(Signals(("a",), 10.0, np.ones((3, 1))), 2.0)
    with pytest.raises(SignalError, match="a rate must be greater than 0, not nan 1/s"):
        resampled(Signals(("a",), 10.0, np.ones((3, 1))), np.nan)
