"""Measured walking (Santuz et al. 2019) and a measured arm trial (pyomeca): as many synergies as published, as good."""

import h5py
import numpy as np
import pytest
from sklearn.decomposition import NMF

from warpmuscle.synergy.ecg import remove_ecg
from warpmuscle.synergy.emg import Chain, band_passed
from warpmuscle.synergy.extraction import AUTO, Rule, extract, sufficient
from warpmuscle.synergy.preparation import Preparation, prepare
from warpmuscle.synergy.recordings import read_signals


@pytest.fixture(scope="module")
def walking(reference_data):
    folder = reference_data / "santuz_walking_synergies"
    if not folder.is_dir():
        pytest.skip("no walking EMG among the reference data")
    return folder


def published(folder):
    """The publication's own filter settings, cycles and points; its first and last cycle are left out."""
    return Preparation(
        chain=Chain((50.0, 450.0), 20.0), cycles=(folder / "cycles_ID0012_TW_01.csv",), cycle_range=(2, 4),
        subtract_minimum=True,
    )  # fmt: skip


def test_chain_gives_the_published_envelopes(walking):
    found = prepare([walking / "raw_emg_ID0012_TW_01.csv"], published(walking))
    filtered = read_signals(walking / "filt_emg_ID0012_TW_01.csv", rate=200.0)
    assert found.muscles == filtered.names
    for mine, theirs in zip(found.values.T, filtered.values.T, strict=True):
        assert np.corrcoef(mine, theirs)[0, 1] > 0.99


def test_five_synergies_account_for_as_much_as_scikit_learn_finds_in_the_published_envelopes(walking):
    found, accounts = extract(
        prepare([walking / "raw_emg_ID0012_TW_01.csv"], published(walking)).values, Rule.of("knee", 0.95, 0.75)
    )
    assert found.account.count == 5
    assert sufficient(accounts, Rule(method=AUTO)).count == 5
    assert extract_count(accounts, 0.9, 0.7) == 5
    filtered = read_signals(walking / "filt_emg_ID0012_TW_01.csv", rate=200.0).values
    model = NMF(5, init="nndsvda", random_state=0, max_iter=2000)
    rest = filtered - model.fit_transform(filtered) @ model.components_
    assert found.account.vaf == pytest.approx(1.0 - np.sum(rest**2) / np.sum(filtered**2), abs=0.02)


def extract_count(accounts, vaf, muscle_vaf):
    """The fewest synergies that reach both."""
    return next(a.count for a in accounts if a.vaf >= vaf and a.muscle_vaf.min() >= muscle_vaf)


def test_five_synergies_suffice_by_all_criteria_and_no_more_by_default_whether_in_cycles_or_in_time(walking):
    path, cycles = walking / "raw_emg_ID0012_TW_01.csv", walking / "cycles_ID0012_TW_01.csv"
    for preparation in (Preparation(), Preparation(cycles=(cycles,))):
        found, accounts = extract(prepare([path], preparation).values, Rule(method=AUTO), restarts=5)
        assert found.account.count == 5
        assert found.account.vaf == pytest.approx(0.964, abs=0.005)
        assert sufficient(accounts, Rule()).count in (4, 5)


@pytest.fixture(scope="module")
def arm(reference_data, tmp_path_factory):
    """The raw EMG of the arm trial as an HDF5 file."""
    source = reference_data / "pyomeca_arm_emg" / "box_lift_emg_kinematics.npz"
    if not source.is_file():
        pytest.skip("no arm EMG among the reference data")
    path = tmp_path_factory.mktemp("arm") / "arm.h5"
    with np.load(source) as arrays, h5py.File(path, "w") as file:
        file["values"], file["rate"] = arrays["emg_raw_V"].T, float(arrays["emg_rate"])
        file["names"] = [str(name) for name in arrays["emg_names"]]
        file["envelopes"] = arrays["envelope_100hz_V"].T
    return path


def test_five_synergies_account_for_the_thirteen_channels_of_an_arm(arm):
    found = prepare([arm], Preparation())
    with h5py.File(arm) as file:
        for mine, theirs in zip(found.values.T, file["envelopes"][()].T, strict=True):
            assert np.corrcoef(mine[: len(theirs)], theirs)[0, 1] > 0.99
    account = extract(found.values, Rule(5))[0].account
    assert len(account.muscle_vaf) == 13
    assert account.vaf >= 0.95


def test_no_heart_is_found_in_an_arm(arm):
    assert remove_ecg(band_passed(read_signals(arm), Chain())).rates == ()
