"""HDF5 files from anyone: nothing outside of the file is read, no more than fits, and each refusal is one line."""

import io
import os
import threading
from pathlib import Path

import h5py
import numpy as np
import pytest

from patience import PATIENCE
from warpmuscle.core import hdf5
from warpmuscle.core.errors import Error, ResultError
from warpmuscle.core.limits import LIMITS
from warpmuscle.formats import load, npz
from warpmuscle.results.journal import Journal
from warpmuscle.results.records import Result
from warpmuscle.results.result import read, write
from warpmuscle.synergy.recordings import read_signals
from warpmuscle.throw.recordings.motion_files import read as read_motions

SECRET = np.full(50, 0.625)


@pytest.fixture
def other(tmp_path: Path) -> Path:
    """A file that is nobody's business, as HDF5; its bytes besides, as `other.raw`."""
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = SECRET
    (tmp_path / "other.raw").write_bytes(SECRET.tobytes())
    return tmp_path / "other.h5"


def external_storage(file: h5py.File, name: str, other: Path) -> None:
    file.create_dataset(name, (50,), float, external=[(str(other.with_suffix(".raw")), 0, 400)])


def external_link(file: h5py.File, name: str, other: Path) -> None:
    file[name] = h5py.ExternalLink(str(other), "/x")


def soft_link(file: h5py.File, name: str, other: Path) -> None:
    file["hidden"] = h5py.ExternalLink(str(other), "/")
    file[name] = h5py.SoftLink("/hidden/x")


def virtual(file: h5py.File, name: str, other: Path) -> None:
    layout = h5py.VirtualLayout((50,), float)
    layout[:] = h5py.VirtualSource(str(other), "x", shape=(50,))
    file.create_virtual_dataset(name, layout)


WAYS = [external_storage, external_link, soft_link, virtual]


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", ["evaluations/cost", "replay/0/com", "scene"])
def test_result_that_shows_another_file_is_refused(way, name: str, other: Path, small_result_file: Path):
    with h5py.File(small_result_file, "a") as file:
        del file[name]
        way(file, name, other)
    with pytest.raises(ResultError, match=r"not followed|not read") as caught:
        read(small_result_file)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("way", WAYS)
def test_recording_of_signals_that_shows_another_file_is_refused(way, other: Path, tmp_path: Path):
    with h5py.File(tmp_path / "emg.h5", "w") as file:
        file["rate"] = 1000.0
        way(file, "BIC", other)
    with pytest.raises(Error, match=r"not followed|not read"):
        read_signals(tmp_path / "emg.h5")


@pytest.mark.parametrize("place", ["runs", "runs/one", "runs/one/evaluations"])
def test_run_of_a_sweep_behind_a_link_is_refused(place: str, small_result_file: Path, tmp_path: Path):
    with h5py.File(tmp_path / "sweep.h5", "w") as file:
        file.attrs["format"], file.attrs["format_version"] = "warpmuscle sweep", 1
        with h5py.File(small_result_file) as source:
            file.create_group("runs")
            source.copy(source["/"], file["runs"], name="one")
        assert isinstance(_read(tmp_path, file), Result)
        del file[place]
        target = {"runs": "/", "runs/one": "/", "runs/one/evaluations": "/evaluations"}[place]
        file[place] = h5py.ExternalLink(str(small_result_file), target)
        with pytest.raises(ResultError, match=r"link to another file|no run|a sweep of"):
            _read(tmp_path, file)


def _read(folder: Path, file: h5py.File) -> Result:
    file.flush()
    (folder / "copy.h5").write_bytes((folder / "sweep.h5").read_bytes())
    return read(folder / "copy.h5", "one")


def test_arrays_that_no_memory_holds_are_refused_at_once(small_result_file: Path):
    with h5py.File(small_result_file, "a") as file:
        file.create_dataset("evaluations/more", (10**13,), float, chunks=(1000,))
    with pytest.raises(ResultError, match=r"/evaluations/more: 8e\+13 bytes are more than .*`unpacked`"):
        read(small_result_file)


def test_little_that_unpacks_to_much_is_refused(tmp_path: Path):
    path = tmp_path / "emg.h5"
    with h5py.File(path, "w") as file:
        file["rate"] = 1000.0
        bomb = file.create_dataset("BIC", (10**8,), "f8", chunks=(10**7,), compression="gzip")
        bomb[: 10**7] = 0.0
    assert path.stat().st_size < 10**6
    with pytest.raises(Error, match="would take"):
        read_signals(path)


def test_a_piece_larger_than_what_is_in_it_counts_as_a_whole(tmp_path: Path):
    with h5py.File(tmp_path / "emg.h5", "w") as file:
        file["rate"] = 1000.0
        file.create_dataset("BIC", (50,), "f8", maxshape=(None,), chunks=(10**8,), compression="gzip")
    with pytest.raises(Error, match=r"would take 8e\+08 bytes"):
        read_signals(tmp_path / "emg.h5")


def test_group_within_itself_is_refused(small_result_file: Path):
    with h5py.File(small_result_file, "a") as file:
        file["evaluations/again"] = file["evaluations"]
    with pytest.raises(ResultError, match="/evaluations/again is a group that is also elsewhere"):
        read(small_result_file)


def test_many_names_that_are_one_long_text_are_refused(tmp_path: Path, monkeypatch):
    monkeypatch.setitem(LIMITS, "unpacked", LIMITS["unpacked"]._replace(most=1000))
    monkeypatch.setitem(LIMITS, "characters", LIMITS["characters"]._replace(most=500))
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["few"] = ["a" * 100] * 3
        file["many"] = ["a" * 100] * 9
        assert hdf5.strings(file["few"]) == ("a" * 100,) * 3
        with pytest.raises(ValueError, match=r"/many: .* characters are more than 500, the limit `characters`"):
            hdf5.strings(file["many"])


def test_pipe_is_refused_at_once(tmp_path: Path):
    os.mkfifo(tmp_path / "a.h5")
    with pytest.raises(ResultError, match="pipe or a device"):
        read(tmp_path / "a.h5")
    with pytest.raises(Error, match="pipe or a device"):
        read_signals(tmp_path / "a.h5")
    os.mkfifo(tmp_path / "a.npz")
    with pytest.raises(ResultError, match="pipe or a device"):
        npz.read(tmp_path / "a.npz", load("fwalk").character)
    with pytest.raises(Error, match="pipe or a device"):
        read_motions(tmp_path / "a.npz", ["elbow"])
    with pytest.raises(ResultError, match="pipe or a device"):
        Journal(tmp_path / "a.npz", "run")
    assert Journal.look(tmp_path / "a.npz") == []


@pytest.fixture
def small_result_file(tmp_path: Path) -> Path:
    from small_result import search_result

    write(tmp_path / "result.h5", search_result("fwalk"))
    return tmp_path / "result.h5"


def test_an_error_that_is_kept_stops_no_other_thread(small_result_file: Path, tmp_path: Path):
    with h5py.File(small_result_file, "r+") as file:
        file.create_group("searches/0/x/y")
    with pytest.raises(ResultError) as kept:
        read(small_result_file)
    opened = threading.Event()

    def open_another() -> None:
        with h5py.File(io.BytesIO(), "w"):
            opened.set()

    threading.Thread(target=open_another, daemon=True).start()
    assert opened.wait(PATIENCE), f"h5py's lock is held by {kept.value}"
