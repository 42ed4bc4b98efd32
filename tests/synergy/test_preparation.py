"""Recordings become one matrix of activations."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_emg import NAMES, WEIGHTS, coefficients, raw_emg, write_csv

from warpmuscle.core.errors import SignalError
from warpmuscle.synergy.emg import Chain
from warpmuscle.synergy.preparation import Preparation, prepare
from warpmuscle.synergy.signals import Signals


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return write_csv(tmp_path_factory.mktemp("emg") / "throw.csv", raw_emg())


def envelopes(path, factor=1.0, names=NAMES, seconds=3.0):
    """Write what low-passed EMG of known synergies would be."""
    time = np.arange(int(100 * seconds)) / 100.0
    return write_csv(path, Signals(names, 100.0, factor * (WEIGHTS @ coefficients(time)).T))


def test_raw_recording_becomes_activations_of_its_rate_and_unit_maxima(recording):
    found = prepare([recording], Preparation())
    assert found.muscles == NAMES
    assert found.values.shape == (600, 7)
    np.testing.assert_allclose(found.values.max(axis=0), 1.0)
    assert found.values.min() >= 0.0
    np.testing.assert_allclose(found.time, np.arange(600) / 100.0)
    assert found.time_unit == "s"


def test_window_is_cut_after_filtering(recording):
    whole = prepare([recording], Preparation())
    part = prepare([recording], Preparation(window=(1.0, 2.0)))
    assert part.time[[0, -1]] == pytest.approx([1.0, 2.0])
    np.testing.assert_allclose(part.values * part.maxima, (whole.values * whole.maxima)[100:201], atol=1e-9)


def test_recordings_are_joined_and_normalised_together(tmp_path):
    paths = [envelopes(tmp_path / "a.csv"), envelopes(tmp_path / "b.csv", 2.0)]
    found = prepare(paths, Preparation(already_filtered=True, rate=None))
    assert found.trial.tolist() == [0] * 300 + [1] * 300
    np.testing.assert_allclose(found.values[:300], 0.5 * found.values[300:], atol=1e-5)
    assert found.sources == tuple(map(str, paths))


def test_maximum_voluntary_contraction_normalises(tmp_path):
    path, strong = envelopes(tmp_path / "a.csv"), envelopes(tmp_path / "mvc.csv", 4.0)
    found = prepare([path], Preparation(already_filtered=True, rate=None, maxima=strong))
    np.testing.assert_allclose(found.values.max(axis=0), 0.25, atol=1e-5)
    weak = prepare([strong], Preparation(already_filtered=True, rate=None, maxima=path))
    assert "reaches 4.00 of its maximum voluntary contraction" in weak.notes[0]


def test_cycles_are_numbered_and_counted_in_cycles(tmp_path, recording):
    cycles = tmp_path / "cycles.csv"
    cycles.write_text("start\n0.5\n2\n3.5\n5\n")
    found = prepare([recording], Preparation(cycles=(cycles,), cycle_range=(2, 3), points=50))
    assert found.values.shape == (100, 7)
    assert found.time_unit == "cycle"
    assert found.trial.tolist() == [0] * 50 + [1] * 50
    assert found.time[[0, 50]].tolist() == [0.0, 1.0]


def test_reference_of_the_heart_is_no_muscle(tmp_path):
    raw = raw_emg()
    beats = np.exp(-((((raw.time % 0.8) - 0.4) / 0.012) ** 2))
    values = np.column_stack([raw.values + beats[:, None], beats])
    path = write_csv(tmp_path / "ecg.csv", replace(raw, names=(*NAMES, "ECG"), values=values))
    found = prepare([path], Preparation(ecg="ECG"))
    assert found.muscles == NAMES
    assert "ecg.csv: the heart's signal was removed (75 beats a minute)" in found.notes[0]
    chosen = prepare([path], Preparation(ecg="ECG", channels=("BIC", "TRI")))
    assert chosen.muscles == ("BIC", "TRI")
    clean = prepare([write_csv(tmp_path / "clean.csv", raw)], Preparation(ecg="auto"))
    assert "no component holds the heart's signal" in clean.notes[0]


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"rate": 10.0}, "10 activations a second cannot hold a low-pass of 6 Hz; ask for more than 12"),
        ({"chain": Chain(band=(10.0, 600.0))}, "a band up to 600 Hz needs a sampling rate above 1200 1/s"),
        ({"rate": 1e9}, "at most 10000 activations a second are interpolated from 1000 a second"),
        ({"window": (2.0, 9.0)}, "a window from 2 s to 9 s is not within 0 s to 5.999 s"),
        ({"window": (2.0, 1.0)}, "a window must end after it begins"),
        ({"cycle_range": (1, 2)}, "a range of cycles needs files of cycles"),
        ({"cycles": ("a.csv", "b.csv")}, "2 cycle files for 1 recording"),
        ({"cycles": ("a.csv",), "window": (0.0, 1.0)}, "a time window and cycles both cut a recording"),
        ({"already_filtered": True}, "but an envelope is never negative; is this a raw signal?"),
        ({"ecg": "HEART"}, "no channel is called 'HEART'"),
        ({"channels": ("XYZ",)}, "no channel is called 'XYZ'"),
    ],
)
def test_wishes_that_do_not_fit_the_recording_are_refused(recording, options, says):
    with pytest.raises(SignalError) as caught:
        prepare([recording], Preparation(**options))
    assert says in str(caught.value)


def test_recordings_of_other_channels_cannot_be_joined(tmp_path):
    paths = [envelopes(tmp_path / "a.csv"), envelopes(tmp_path / "b.csv", names=tuple("ABCDEFG"))]
    with pytest.raises(SignalError, match=r"b.csv: its channels are A, B, C, D, E, F, G, not DA, DP, BIC"):
        prepare(paths, Preparation(already_filtered=True))
    with pytest.raises(SignalError, match="there are no recordings"):
        prepare([], Preparation())


def test_channels_that_are_silent_are_left_out_with_a_note(tmp_path):
    values = (WEIGHTS @ coefficients(np.arange(300) / 100.0)).T
    values[100:, 3] = 0.2
    path = write_csv(tmp_path / "a.csv", Signals(NAMES, 100.0, values))
    found = prepare([path], Preparation(already_filtered=True, window=(1.5, 2.5)))
    assert found.muscles == tuple(name for name in NAMES if name != "TRI")
    assert "TRI: silent in what is used, and left out" in found.notes
    values[:, 3] = 0.0
    path = write_csv(tmp_path / "a.csv", Signals(NAMES, 100.0, values))
    other = write_csv(tmp_path / "b.csv", Signals(NAMES, 100.0, values + np.linspace(0.0, 0.1, 300)[:, None]))
    found = prepare([path, other], Preparation(already_filtered=True))
    assert found.muscles == tuple(name for name in NAMES if name != "TRI")
    assert found.values.shape[1] == len(NAMES) - 1
    assert "a.csv: TRI is silent and left out" in found.notes
    path = write_csv(tmp_path / "a.csv", Signals(NAMES, 100.0, 0.0 * values))
    with pytest.raises(SignalError, match="all channels are constant"):
        prepare([path], Preparation(already_filtered=True))
