"""Datasets with what they are, as they come back."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from warpmuscle.core.errors import ResultError
from warpmuscle.core.hdf5_writing import COMPRESS_FROM, store


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
