"""Raw EMG of a C3D becomes envelopes of muscles, whatever its rate and unit."""

from pathlib import Path

import numpy as np
import pytest
from damaging.c3d_file import write_c3d

from warpmuscle.core.errors import SignalError
from warpmuscle.inverse.emg import read_emg
from warpmuscle.inverse.trial import TrialWarning

MUSCLES = ("soleus_r", "tibant_r", "gasmed_r")


def effort(time: np.ndarray) -> np.ndarray:
    return 0.5 - 0.5 * np.cos(2.0 * np.pi * time)


def written(path: Path, samples: int, values: np.ndarray | None = None) -> Path:
    """Two seconds of noise whose amplitude is an effort, and of a plain envelope."""
    frames = 200
    time = np.arange(frames * samples) / (100.0 * samples)
    noise = np.random.default_rng(3).normal(size=len(time))
    raw = np.column_stack([1e-4 * effort(time) * noise, 3e-5 * effort(time + 0.5) * noise[::-1] + 0.2])
    return write_c3d(path, np.zeros((frames, 1, 3)), ["m"], 100.0, raw if values is None else values,
                     ["EMG1", "tibant_r"], ["V", "V"])  # fmt: skip


@pytest.mark.parametrize("samples", [20, 10, 6])
def test_envelopes_follow_the_effort_from_0_to_1(tmp_path, samples):
    path = written(tmp_path / "walk.c3d", samples)
    with pytest.warns(TrialWarning, match="raw EMG is divided by its greatest value"):
        found = read_emg(path, MUSCLES, {"soleus_r": "EMG1", "gasmed_r": "EMG1", "tibant_r": "tibant_r"})
    assert found.muscles == ("soleus_r", "gasmed_r", "tibant_r")
    assert found.values.max(axis=0).tolist() == [1.0, 1.0, 1.0]
    np.testing.assert_array_equal(found.values[:, 0], found.values[:, 1])
    for column, shift in ((0, 0.0), (2, 0.5)):
        assert np.corrcoef(found.values[:, column], effort(found.times + shift))[0, 1] > 0.9
    np.testing.assert_allclose(found.times[[0, -1]], [0.0, 2.0 - 1.0 / (100.0 * samples)])


def test_rectified_volts_are_no_envelope_yet(tmp_path):
    time = np.arange(4000) / 2000.0
    noise = np.random.default_rng(3).normal(size=len(time))
    values = np.abs(1e-4 * effort(time) * noise)[:, None] * [1.0, 0.5]
    with pytest.warns(TrialWarning, match="raw EMG is divided"):
        found = read_emg(written(tmp_path / "walk.c3d", 20, values), MUSCLES)
    assert np.corrcoef(found.values[:, 0], effort(time))[0, 1] > 0.9


def test_channels_called_as_muscles_are_theirs_and_envelopes_stay(tmp_path):
    values = np.linspace(0.0, 1.0, 400)[:, None] * [0.25, 0.5]
    found = read_emg(written(tmp_path / "walk.c3d", 2, values), MUSCLES)
    assert found.muscles == ("tibant_r",)
    np.testing.assert_allclose(found.values[:, 0], values[:, 1], atol=1e-7)


@pytest.mark.parametrize(
    ("muscles", "channels", "said"),
    [
        (("vasint_r",), None, "no analog channel has the name of a muscle"),
        (MUSCLES, {"soleus_l": "EMG1"}, "the model has no muscle 'soleus_l'"),
        (MUSCLES, {"soleus_r": "EMG9"}, "EMG9"),
    ],
)
def test_what_is_not_there_is_said(tmp_path, muscles, channels, said):
    path = written(tmp_path / "walk.c3d", 2)
    with pytest.raises(SignalError, match=said) as caught:
        read_emg(path, muscles, channels)
    assert str(path) in str(caught.value)


def test_only_a_c3d_has_channels(tmp_path):
    (tmp_path / "emg.csv").write_text("time,soleus_r\n0,0.1\n1,0.2\n")
    with pytest.raises(SignalError, match=r"for a \.c3d only"):
        read_emg(tmp_path / "emg.csv", MUSCLES, {"soleus_r": "soleus_r"})
