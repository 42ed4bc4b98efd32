"""Files and figures of synergies."""

import dataclasses

import h5py
import numpy as np
import pytest
from synthetic_emg import NAMES, WEIGHTS, coefficients

from described import assert_described
from warpmuscle.core.errors import Error, ResultError
from warpmuscle.plots.synergies import draw_synergies
from warpmuscle.synergy.extraction import Rule, extract
from warpmuscle.synergy.files import SynergyResult, described, in_order_of, read, write
from warpmuscle.synergy.preparation import Activations, Preparation

TIME = np.arange(150) / 50.0


@pytest.fixture(scope="module")
def result():
    values = (WEIGHTS @ coefficients(TIME)).T + 0.02 * np.random.default_rng(0).random((150, 7))
    trial = np.repeat([0, 1], 75)
    activations = Activations(NAMES, values, TIME, "s", trial, np.ones(7), ("a.csv", "b.csv"), ("a note",))
    found, accounts = extract(values, Rule(3), restarts=2)
    return SynergyResult(activations, found, tuple(accounts), None, {"seed": 0, **described(Preparation())})


def test_what_is_written_is_read_again(tmp_path, result):
    write(tmp_path / "syn.h5", result)
    assert_described(tmp_path / "syn.h5")
    found = read(tmp_path / "syn.h5")
    for field in dataclasses.fields(Activations):
        np.testing.assert_array_equal(getattr(found.activations, field.name), getattr(result.activations, field.name))
    np.testing.assert_array_equal(found.synergies.weights, result.synergies.weights)
    np.testing.assert_array_equal(found.synergies.coefficients, result.synergies.coefficients)
    assert found.synergies.account.vaf == result.synergies.account.vaf
    assert [a.count for a in found.counts] == [a.count for a in result.counts]
    assert found.attributes["low_pass"] == 6.0
    assert found.attributes["band"].tolist() == [10.0, 450.0]


def test_file_says_what_it_holds_and_is_the_same_every_time(tmp_path, result):
    write(tmp_path / "a.h5", result)
    write(tmp_path / "b.h5", result)
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()
    with h5py.File(tmp_path / "a.h5") as file:
        assert file.attrs["format"] == "warpmuscle synergies"
        assert file["W"].attrs["axes"] == "muscle, synergy"
        assert file["W"].shape == (7, 3)
        assert file["C"].shape == (3, 150)
        assert file["time"].attrs["units"] == "s"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.h5", "b.h5"]


def test_synergies_are_put_in_the_order_of_another_file(result):
    reference = dataclasses.replace(result, synergies=result.synergies.ordered([2, 0, 1]))
    found, cosines = in_order_of(reference, NAMES, result.synergies)
    np.testing.assert_array_equal(found.weights, result.synergies.weights[:, [2, 0, 1]])
    np.testing.assert_array_equal(found.coefficients, result.synergies.coefficients[[2, 0, 1]])
    np.testing.assert_allclose(cosines, 1.0)
    with pytest.raises(ResultError, match="the synergies to compare with are of DA, DP"):
        in_order_of(reference, NAMES[:3], result.synergies)


def test_files_of_another_kind_are_refused(tmp_path, result):
    path = tmp_path / "x.h5"
    with pytest.raises(ResultError, match="no such file"):
        read(path)
    path.write_bytes(b"garbage")
    with pytest.raises(ResultError, match="not an HDF5 file, or damaged"):
        read(path)
    with h5py.File(path, "w") as file:
        file.attrs["format"] = "warpmuscle"
    with pytest.raises(ResultError, match="an HDF5 file, but not one of synergies"):
        read(path)
    write(path, result)
    with h5py.File(path, "a") as file:
        del file["W"]
    with pytest.raises(ResultError, match="damaged file of synergies"):
        read(path)


def test_nothing_is_left_behind_by_a_file_that_cannot_be_written(tmp_path, result):
    folder = tmp_path / "syn.h5"
    folder.mkdir()
    with pytest.raises(ResultError, match="this is a folder"):
        write(folder, result)
    broken = dataclasses.replace(result.synergies, weights=np.full((7, 3), np.nan))
    with pytest.raises(ResultError, match="W holds a value that is not finite; nothing was written"):
        write(tmp_path / "nan.h5", dataclasses.replace(result, synergies=broken))
    assert [path.name for path in tmp_path.iterdir()] == ["syn.h5"]


@pytest.mark.parametrize("unit", ["s", "cycle"])
def test_figure_is_drawn_for_trials_and_for_cycles(tmp_path, result, unit):
    activations = dataclasses.replace(result.activations, time_unit=unit)
    draw_synergies(tmp_path / "syn.png", activations, result.synergies, result.counts)
    assert (tmp_path / "syn.png").stat().st_size > 20_000


def test_figure_that_cannot_be_written_is_said(tmp_path, result):
    with pytest.raises(Error, match=r"a figure is written as \.png, \.svg, \.pdf"):
        draw_synergies(tmp_path / "syn.xyz", result.activations, result.synergies)
    with pytest.raises(Error, match=r"syn\.png"):
        draw_synergies(tmp_path / "missing" / "syn.png", result.activations, result.synergies)
    assert not list(tmp_path.iterdir())
