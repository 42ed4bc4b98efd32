"""Motions and candidates as tables of pandas and xarray, and files as xarray opens them."""

import dataclasses
from pathlib import Path

import h5py
import numpy as np
import pytest

from biped import random_recording
from small_result import search_result, walk_result
from warpmuscle.core.errors import Error, ResultError
from warpmuscle.results.recorded_quantities import QUANTITIES
from warpmuscle.results.recording import Recording
from warpmuscle.results.result import write

pandas = pytest.importorskip("pandas", reason="no pandas: pip install 'warpmuscle[data]'")
xarray = pytest.importorskip("xarray", reason="no xarray: pip install 'warpmuscle[data]'")

WITHOUT_WIDTH = {"controller_value", "recorded"}  # in a motion whose scene has nothing of its own


def motion(frames: int = 5) -> Recording:
    """Random numbers, two of its three coordinates with names."""
    values = np.random.default_rng(1).random((frames, 3))
    return dataclasses.replace(
        random_recording(frames, muscles=2), coordinate=values, coordinate_names=("root.y", "knee", "hip.qx"),
        speed=values[:, :1], speed_names=("knee",), joint_angle=values[:, :2], joint_angle_names=("knee", "hip_x"),
    )  # fmt: skip


def test_every_quantity_is_in_the_set_with_names_along_its_axes_and_its_unit():
    recording = motion()
    found = recording.to_xarray()
    assert {*found.data_vars, "time"} == set(QUANTITIES) - WITHOUT_WIDTH
    for name, quantity in ((n, q) for n, q in QUANTITIES.items() if n not in WITHOUT_WIDTH):
        np.testing.assert_array_equal(found[name].values, recording[name])
        assert found[name].attrs["units"] == quantity.units
    one = found.muscle_force.sel(muscle_names="muscle1").sel(time=recording.time[3])
    assert float(one) == recording.muscle_force[3, 1]
    assert float(found.com.sel(xyz="y")[2]) == recording.com[2, 1]
    assert found.body_position.dims == ("time", "body_names", "xyz")


def test_what_a_motion_has_none_of_is_left_out():
    found = random_recording(4).to_xarray()
    assert "muscle_force" not in found
    assert "coordinate" not in found
    assert not [name for name in random_recording(4).to_dataframe() if name.startswith(("muscle", "joint_angle"))]


def test_columns_are_the_quantities_by_name_and_rows_the_frames():
    recording = motion()
    table = recording.to_dataframe()
    assert (table.index.name, table.index.tolist()) == ("time", recording.time.tolist())
    np.testing.assert_array_equal(table["muscle_force.muscle1"], recording.muscle_force[:, 1])
    np.testing.assert_array_equal(table["body_position.part2.z"], recording.body_position[:, 2, 2])
    np.testing.assert_array_equal(table["coordinate.knee"], recording.coordinate[:, 1])
    np.testing.assert_array_equal(table["phase"], recording.phase)
    assert table.shape[1] == sum(recording[name][0].size for name in QUANTITIES) - 1
    assert motion(0).to_dataframe().shape == (0, table.shape[1])


def test_a_table_of_some_quantities_has_only_these():
    table = motion().to_dataframe(["joint_angle", "stance"])
    assert list(table) == ["joint_angle.knee", "joint_angle.hip_x", "stance"]
    with pytest.raises(Error, match="no quantity is called 'angels'"):
        motion().to_dataframe(["angels"])


def test_xarray_opens_a_motion_of_a_file_as_the_recording_gives_it(tmp_path: Path):
    pytest.importorskip("h5netcdf", reason="no h5netcdf: pip install 'warpmuscle[data]'")
    write(tmp_path / "a.h5", dataclasses.replace(walk_result(), replays=(motion(), random_recording(3))))
    for number, recording in enumerate([motion(), random_recording(3)]):
        with xarray.open_dataset(tmp_path / "a.h5", group=f"replay/{number}", engine="h5netcdf") as found:
            xarray.testing.assert_equal(found.load(), recording.to_xarray())


def test_axes_of_a_file_have_their_names_as_dimension_scales(tmp_path: Path):
    write(tmp_path / "a.h5", dataclasses.replace(walk_result(), replays=(motion(),)))
    with h5py.File(tmp_path / "a.h5") as file:
        force = file["replay/0/muscle_force"]
        assert [axis.keys() for axis in force.dims] == [["time"], ["muscle_names"]]
        assert force.dims[1][0].asstr()[:].tolist() == ["muscle0", "muscle1"]
        assert file["replay/0/joint_angle"].dims[1][0].asstr()[:].tolist() == ["knee", "hip_x"]
        for name, quantity in QUANTITIES.items():
            if name not in ("time", *WITHOUT_WIDTH):
                assert [len(axis) for axis in file[f"replay/0/{name}"].dims] == [1] * len(quantity.axes), name


def test_candidates_are_rows_with_outcome_terms_and_parameters():
    result = search_result()
    table = result.to_dataframe()
    found = result.evaluations
    assert len(table) == len(found)
    assert table.index.name == "candidate"
    assert tuple(table["status"]) == found.status_names()
    np.testing.assert_array_equal(table["cost"], found.cost)
    np.testing.assert_array_equal(table["term.speed"], found.terms[:, 1])
    np.testing.assert_array_equal(table[result.parameters.name[0]], found.params[:, 0])
    assert table["cost"].idxmin() == np.argmin(found.cost)


def test_a_result_without_candidates_says_where_its_numbers_are():
    with pytest.raises(ResultError, match=r"no candidates.*replays\[0\]\.to_dataframe"):
        walk_result().to_dataframe()


@pytest.mark.parametrize("package", ["xarray", "pandas"])
def test_what_is_not_installed_is_named_with_its_extra(package: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(__import__("sys").modules, package, None)
    with pytest.raises(Error, match=rf"needs {package}: pip install 'warpmuscle\[data\]'"):
        motion().to_xarray() if package == "xarray" else motion().to_dataframe()
