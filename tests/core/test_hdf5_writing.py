"""Datasets with what they are, as they come back."""

import tracemalloc
from pathlib import Path

import h5py
import numpy as np
import pytest

from small_disk import disk_of
from warpmuscle.core.errors import ResultError, SceneError
from warpmuscle.core.hdf5_writing import COMPRESS_FROM, Column, store, streamed


def test_numbers_and_texts_come_back_with_the_attributes_that_were_given(tmp_path: Path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        store(file, "place", np.arange(3.0), units="m", axes="axis", description="of it", at="start", maxshape=(None,))
        store(file, "names", ("one", "two"), axes="name", description="names")
        store(file, "scene", "text", description="as TOML")
    with h5py.File(tmp_path / "a.h5") as file:
        np.testing.assert_array_equal(file["place"], [0.0, 1.0, 2.0])
        assert dict(file["place"].attrs) == {"units": "m", "axes": "axis", "description": "of it", "at": "start"}
        assert file["place"].maxshape == (None,)
        assert dict(file["names"].attrs) == {"units": "", "axes": "name", "description": "names"}
        assert list(file["names"].asstr()) == ["one", "two"]
        assert file["scene"].asstr()[()] == "text"


def test_large_arrays_alone_are_packed_and_hold_the_same(tmp_path: Path):
    zeros = np.zeros(COMPRESS_FROM)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        store(file, "large", zeros, description="zeros")
        store(file, "small", zeros[:8], description="zeros")
        assert (file["large"].compression, file["small"].compression) == ("gzip", None)
        np.testing.assert_array_equal(file["large"], zeros)


def test_what_is_not_finite_is_refused_unless_it_may_be(tmp_path: Path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        with pytest.raises(ResultError, match="/group/x holds a value that is not finite; nothing was written"):
            store(file.create_group("group"), "x", [1.0, np.nan], description="x")
        store(file, "x", [1.0, np.nan], description="x", finite=False)


def test_a_column_comes_back_with_all_rows_in_order_however_they_were_added(tmp_path: Path, monkeypatch):
    monkeypatch.setattr("warpmuscle.core.hdf5_writing.PIECE", 80)  # bytes: ten numbers, or five pairs
    numbers, pairs = np.arange(57.0), np.arange(64, dtype=np.int32).reshape(-1, 2)
    with streamed(tmp_path / "a.h5") as file:
        one = Column(file, "one", float, (), "m", "row", "numbers")
        two = Column(file, "two", np.int32, (2,), "", "row, pair", "pairs")
        none = Column(file, "none", float, (), "", "row", "nothing")
        for size in (1, 30, 0, 9, 10, 7):
            one.add(numbers[:size])
            numbers = numbers[size:]
        for part in np.array_split(pairs, 5):
            two.add(part)
        assert [len(column.finish()) for column in (one, two, none)] == [57, 32, 0]
    with h5py.File(tmp_path / "a.h5") as file:
        np.testing.assert_array_equal(file["one"], np.arange(57.0))
        np.testing.assert_array_equal(file["two"], pairs)
        assert dict(file["one"].attrs) == {"units": "m", "axes": "row", "description": "numbers"}


@pytest.mark.parametrize("size", [100, 3_000, 60_000])
def test_a_disk_that_is_full_at_any_moment_leaves_the_earlier_file(size: int, tmp_path: Path):
    path = tmp_path / "a.h5"
    path.write_text("earlier")
    numbers = np.random.default_rng(1).random((40, 300))

    def fill() -> None:
        with disk_of(size), streamed(path) as file:
            for number, row in enumerate(numbers):
                store(file, str(number), row, axes="row", description="numbers")

    with pytest.raises(SceneError, match=r"a\.h5: cannot be written: file too large"):
        fill()
    assert path.read_text() == "earlier"
    assert list(tmp_path.iterdir()) == [path]


def test_an_error_of_the_work_leaves_the_earlier_file(tmp_path: Path):
    path = tmp_path / "a.h5"
    path.write_text("earlier")
    with pytest.raises(ResultError, match="not finite"), streamed(path) as file:
        store(file, "a", np.array([np.nan]), axes="row", description="numbers")
    assert path.read_text() == "earlier"
    assert list(tmp_path.iterdir()) == [path]


def test_rows_that_wait_keep_nothing_else_in_memory(tmp_path: Path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        column = Column(file, "best", float, (36,), "", "run, parameter", "the best of each run")
        tracemalloc.start()
        for number in range(200):
            every = np.full((1000, 36), float(number))  # 288 kB, of which a row is kept
            column.add(every[5][None])
        del every
        kept, _ = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert kept < 2e6
        np.testing.assert_array_equal(column.finish()[:, 0], np.arange(200.0))
