"""Puts numbers and texts, with what they are, into HDF5 files; `hdf5` reads them."""

from __future__ import annotations

from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.errors import ResultError

COMPRESS_FROM = 4096  # bytes; smaller arrays are stored as they are


def store(
    group: Any,
    name: str,
    data: Any,
    units: str = "",
    axes: str = "",
    *,
    description: str,
    finite: bool = True,
    at: str = "",
    **layout: Any,
) -> None:
    """Store a text, a tuple of texts, a number or an array, with its unit, axes and description as attributes.

    Args:
        group: of an open file. units: of numbers, "1" if there is none. axes: their names, with commas between them.
        finite: whether all numbers have to be. at: when the numbers of a row are, in a step.
        layout: further options of a dataset, such as `maxshape`.

    Raises:
        ResultError: a number is not finite, though all are to be.
    """
    if isinstance(data, (str, tuple)):
        array: NDArray[Any] = np.asarray(data, dtype=h5py.string_dtype())
    else:
        array = np.asarray(data)
        if finite and not np.isfinite(array).all():
            raise ResultError(f"{group.name.rstrip('/')}/{name} holds a value that is not finite; nothing was written")
    packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True} if array.nbytes >= COMPRESS_FROM else {}
    dataset = group.create_dataset(name, data=array, **(packed if array.dtype.kind in "fi" else {}), **layout)
    dataset.attrs["units"] = units or ("" if array.dtype.kind == "O" else "1")
    dataset.attrs["axes"], dataset.attrs["description"] = axes, description
    if at:
        dataset.attrs["at"] = at
