"""Measured markers and forces are kept in a file of trials, and read as they were."""

import io
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from warpmuscle.core.errors import ResultError
from warpmuscle.core.hdf5_writing import store
from warpmuscle.formats.external_loads import TO_OPENSIM
from warpmuscle.inverse.recordings.measured import Measured, put, read_measured
from warpmuscle.inverse.tracking.output import tracked_arrays
from warpmuscle.results.result import INVERSE_FORMAT

FRAMES = 4


def some_measured() -> Measured:
    """Two markers, one of which is not seen at first, and a force on a foot."""
    numbers = np.random.default_rng(1)
    position = numbers.normal(size=(FRAMES, 2, 3))
    position[0, 1] = np.nan
    force, point = numbers.normal(size=(2, FRAMES, 1, 3))
    times = 0.1 * np.arange(FRAMES) + 0.5
    return Measured(times, ("heel", "toe"), position, position + 0.01, ("calcn_r",), force, point)


def write(path, measured: Measured, trial: str = "walk") -> None:
    with h5py.File(path, "w") as file:
        file.attrs["format"], file.attrs["format_version"] = INVERSE_FORMAT, 3
        group = file.create_group(f"trials/{trial}")
        store(group, "time", measured.times, "s", "time", description="of the frames")
        group["time"].make_scale("time")
        put(group, measured)


def test_what_was_measured_comes_back_in_axes_of_scenes_and_lies_in_those_of_opensim(tmp_path):
    measured = some_measured()
    write(tmp_path / "a.h5", measured)
    found = read_measured(tmp_path / "a.h5")
    assert (found.markers, found.bodies) == (measured.markers, measured.bodies)
    for name in ("times", "position", "modelled", "force", "point"):
        np.testing.assert_allclose(getattr(found, name), getattr(measured, name), atol=1e-15)
    with h5py.File(tmp_path / "a.h5") as file:
        stored = file["trials/walk/plate_force"]
        x, y, z = measured.force[:, 0].T  # to the left, upwards, ahead
        np.testing.assert_allclose(stored[:, 0], np.stack([z, y, -x], axis=1))
        assert dict(stored.attrs)["units"] == "N"
        assert stored.dims[0][0].name == "/trials/walk/time"
        assert np.isnan(file["trials/walk/marker_measured"][0, 1]).all()
    assert np.allclose(TO_OPENSIM @ TO_OPENSIM.T, np.eye(3))


def test_a_trial_is_named_where_there_are_several_and_other_files_have_none(tmp_path):
    write(tmp_path / "a.h5", some_measured(), "one")
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        file.copy("trials/one", "trials/two")
        file.create_group("trials/bare")
    assert read_measured(tmp_path / "a.h5") is None
    assert read_measured(tmp_path / "a.h5", "two").markers == ("heel", "toe")
    assert read_measured(tmp_path / "a.h5", "bare") is None
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file.attrs["format"] = "warpmuscle result"
    assert read_measured(tmp_path / "b.h5") is None


@pytest.mark.parametrize("damage", ["shape", "text", "infinite", "names", "gone"])
def test_a_damaged_file_is_one_line(tmp_path, damage: str):
    write(tmp_path / "a.h5", some_measured())
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        group = file["trials/walk"]
        wrong = {
            "shape": np.zeros((FRAMES, 2, 2)),
            "text": np.array([b"a"]),
            "infinite": np.full((FRAMES, 2, 3), np.inf),
        }
        if damage in wrong:
            del group["marker_measured"]
            group["marker_measured"] = wrong[damage]
        elif damage == "names":
            del group["marker"]
            group["marker"] = np.zeros(2)
        else:
            del group["marker"]
    with pytest.raises(ResultError) as caught:
        read_measured(tmp_path / "a.h5")
    assert "a.h5" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_run_on_the_ground_and_its_plates_stand_in_one_file():
    """What was measured and what tracking found are stored in one group, where a name stands once."""
    forces = np.ones((3, 1, 3))
    measured = Measured(np.arange(3.0), (), np.zeros((3, 0, 3)), np.zeros((3, 0, 3)), ("foot",), forces, forces)
    ground = SimpleNamespace(force=forces, plates=forces, lift=np.zeros(4))
    fields = ("values", "error", "activation", "excitation", "force", "effort", "lacking", "iterations")
    followed = SimpleNamespace(ground=ground, **dict.fromkeys(fields, np.zeros((3, 1))))
    with h5py.File(io.BytesIO(), "w") as file:
        store(file, "time", measured.times, "s", "time", description="of the frames")
        file["time"].make_scale("time")
        put(file, measured)
        for one in tracked_arrays(followed):
            store(file, one.name, one.values, one.units, "", description=one.description)
        assert file["plate_force"].shape == file["ground_force_of_plates"].shape
