"""Puts numbers and texts, with what they are, into HDF5 files; `hdf5` reads them."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.errors import ResultError
from warpmuscle.core.files import replacing

COMPRESS_FROM = 4096  # bytes; smaller arrays are stored as they are
_TEXT = h5py.string_dtype()
PIECE = 2**18  # bytes of a column that are packed together
ALONG = 2**31 - 1  # rows of a column at most: readers look through all datasets for the length of an unlimited one


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
    if not layout and "/" not in name and (array.nbytes < COMPRESS_FROM or array.dtype.kind not in "fi"):
        dataset = _plain(group, name, array)
    else:
        packed = (
            {"compression": "gzip", "compression_opts": 1, "shuffle": True} if array.nbytes >= COMPRESS_FROM else {}
        )
        dataset = group.create_dataset(name, data=array, **(packed if array.dtype.kind in "fi" else {}), **layout).id
    _describe(dataset, "units", units or ("" if array.dtype.kind == "O" else "1"))
    _describe(dataset, "axes", axes)
    _describe(dataset, "description", description)
    if at:
        _describe(dataset, "at", at)


def _plain(group: Any, name: str, array: NDArray[Any]) -> Any:
    """A dataset as `create_dataset` makes it, in a fifth of its time, which files of many small ones consist of."""
    made = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    made.set_obj_track_times(False)
    kind = h5py.h5t.py_create(array.dtype, logical=True)
    dataset = h5py.h5d.create(group.id, name.encode(), kind, h5py.h5s.create_simple(array.shape), made)
    if array.size:
        whole = h5py.h5s.ALL
        dataset.write(whole, whole, np.ascontiguousarray(array), mtype=h5py.h5t.py_create(array.dtype))
    return dataset


def _describe(dataset: Any, name: str, text: str) -> None:
    """Put a text as an attribute of a dataset that has none of this name."""
    kind = h5py.h5t.py_create(_TEXT, logical=True)
    attribute = h5py.h5a.create(dataset, name.encode(), kind, h5py.h5s.create(h5py.h5s.SCALAR))
    attribute.write(np.array(text, dtype=_TEXT), mtype=h5py.h5t.py_create(_TEXT))


@contextlib.contextmanager
def streamed(path: Path) -> Iterator[Any]:
    """A new HDF5 file that is written to the disk as it is filled, and takes the place of `path` once it is whole.

    Raises:
        SceneError: it cannot be written; `path` is as it was then, and nothing is left behind.
    """
    with replacing(path) as temporary, open(temporary, "x+b", buffering=0) as raw:
        place = _Place(raw)
        try:
            with h5py.File(place, "w", track_order=True) as file:
                yield file
        except Exception:
            if place.failure is None:
                raise
        if place.failure is not None:
            raise place.failure


class _Place(io.RawIOBase):
    """Where HDF5 writes: an OSError is kept rather than raised, which the library does not survive at any moment."""

    def __init__(self, raw: io.FileIO) -> None:
        self._raw = raw
        self.failure: OSError | None = None

    def seek(self, offset: int, whence: int = 0) -> int:
        """See `io.RawIOBase`."""
        return self._raw.seek(offset, whence)

    def tell(self) -> int:
        """See `io.RawIOBase`."""
        return self._raw.tell()

    def readinto(self, buffer: Any) -> int | None:
        """See `io.RawIOBase`."""
        return self._raw.readinto(buffer)

    def write(self, data: Any) -> int:
        """See `io.RawIOBase`; what is left after a failure is dropped."""
        rest = memoryview(data)
        try:
            while rest and self.failure is None:
                rest = rest[self._raw.write(rest) :]
        except OSError as error:
            self.failure = error
        return len(data)

    def truncate(self, size: int | None = None) -> int:
        """See `io.RawIOBase`."""
        try:
            return self._raw.truncate(size)
        except OSError as error:
            self.failure = self.failure or error
            return size or 0


class Column:
    """A dataset that grows along its first axis, written piece by piece."""

    def __init__(
        self, group: Any, name: str, kind: Any, shape: Sequence[int], units: str, axes: str, description: str
    ) -> None:
        """Begin one without rows; `shape` is that of a row."""
        kind = h5py.string_dtype() if kind is str else np.dtype(kind)
        width = max(int(np.prod(shape)), 1) * kind.itemsize
        rows = max(PIECE // width, 1)
        packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True} if kind.kind in "fi" else {}
        self._rows: list[NDArray[Any]] = []
        self._waiting, self._least = 0, rows
        self._dataset = group.create_dataset(
            name, (0, *shape), kind, maxshape=(ALONG, *shape), chunks=(rows, *(max(n, 1) for n in shape)), **packed
        )
        self._dataset.attrs["units"] = units or ("" if kind.kind == "O" else "1")
        self._dataset.attrs["axes"], self._dataset.attrs["description"] = axes, description

    def add(self, rows: Any) -> None:
        """Put rows behind those that are there; they are written once there are enough for a piece."""
        kind = object if self._dataset.dtype.kind == "O" else None
        self._rows.append(np.array(rows, dtype=kind))  # a view would keep all that it is of until it is written
        self._waiting += len(self._rows[-1])
        while self._waiting >= self._least:
            every = np.concatenate(self._rows)
            self._write(every[: self._least])
            self._rows, self._waiting = [every[self._least :]], self._waiting - self._least

    def finish(self) -> Any:
        """Write what is left; the dataset."""
        if self._waiting:
            self._write(np.concatenate(self._rows))
            self._rows, self._waiting = [], 0
        return self._dataset

    def _write(self, rows: NDArray[Any]) -> None:
        begin = len(self._dataset)
        self._dataset.resize(begin + len(rows), axis=0)
        self._dataset[begin:] = rows
