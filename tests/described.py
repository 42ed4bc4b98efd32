"""Whether every dataset of an HDF5 file says what it is."""

from pathlib import Path
from typing import Any

import h5py


def assert_described(path: Path) -> None:
    """Each dataset has a unit, a name for each axis, and a description."""

    def check(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            assert {"units", "axes", "description"} <= set(item.attrs), name
            assert item.attrs["description"], name
            assert item.attrs["units"] or item.dtype.kind == "O", name
            count = len([axis for axis in item.attrs["axes"].split(",") if axis])
            assert count == item.ndim, name

    with h5py.File(path) as file:
        file.visititems(check)
