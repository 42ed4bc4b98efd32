"""Reads arrays of NumPy archives (`.npz`) that may come from anyone: no Python objects, and no more than fits."""

from __future__ import annotations

import io
import math
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from warpmuscle.core.files import check_regular, unreadable
from warpmuscle.core.limits import check_size

_LENGTHS, _LENGTHS_AT = struct.Struct("<HH"), 26  # of name and extra field, in the header before a member of a ZIP file
Arrays = dict[str, NDArray[Any]]
DAMAGES = (
    ValueError, OSError, EOFError, KeyError, TypeError, IndexError, NotImplementedError, RuntimeError, MemoryError,
    OverflowError, SyntaxError, struct.error, tokenize.TokenError, zipfile.BadZipFile, zipfile.LargeZipFile, zlib.error,
)  # fmt: skip


@dataclass(frozen=True)
class ArrayPlace:
    """Where an array lies in the bytes of an archive that is not compressed."""

    offset: int
    kind: np.dtype[Any]
    shape: tuple[int, ...]


class DamagedArchive(ValueError):
    """No archive of arrays, or one of whose arrays cannot be read."""


def arrays_of(path: str | Path, wanted: Collection[str] | None = None) -> Arrays:
    """The arrays of an archive on disk, see `read_arrays`.

    Raises:
        DamagedArchive: with what is wrong, in words; also where the file cannot be read.
    """
    try:
        check_regular(path)
        with open(path, "rb") as file:
            return read_arrays(file, wanted)
    except OSError as error:
        raise DamagedArchive(unreadable(error)) from None


def read_arrays(file: IO[bytes], wanted: Collection[str] | None = None) -> Arrays:
    """The arrays of an archive by name; only the wanted ones, if any are named.

    Raises:
        DamagedArchive: with what is wrong, in words.
    """
    what, size, found = "not an .npz file, or damaged", 0, {}
    try:
        with zipfile.ZipFile(file) as archive:
            for info in archive.infolist():
                name = info.filename.removesuffix(".npy")
                if wanted is not None and name not in wanted:
                    continue
                size += info.file_size
                check_size("archive", size, DamagedArchive)
                what = f"array {name!r} cannot be read: damaged, or of Python objects instead of numbers"
                with archive.open(info) as member:
                    found[name] = _array(member.read(info.file_size + 1))
        return found
    except DamagedArchive:
        raise
    except DAMAGES:
        raise DamagedArchive(what) from None


def array_places(content: bytes) -> dict[str, ArrayPlace]:
    """Where the arrays of an archive lie in its bytes, by name, so that rows of them can be read by themselves.

    Raises:
        DamagedArchive: it cannot be read, or is compressed.
    """
    found = {}
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            for info in archive.infolist():
                name, extra = _LENGTHS.unpack_from(content, info.header_offset + _LENGTHS_AT)
                begin = info.header_offset + _LENGTHS_AT + _LENGTHS.size + name + extra
                stream = io.BytesIO(content)
                stream.seek(begin)
                shape, fortran, kind = _header(stream)
                end = stream.tell() + math.prod(shape) * kind.itemsize
                if (
                    info.compress_type
                    or fortran
                    or kind.hasobject
                    or end != begin + info.file_size
                    or end > len(content)
                ):
                    raise ValueError
                found[info.filename.removesuffix(".npy")] = ArrayPlace(stream.tell(), kind, shape)
        return found
    except DAMAGES:
        raise DamagedArchive("not an .npz file, compressed, or damaged") from None


def _header(stream: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Shape, whether columns come first, and kind of the array whose `.npy` file begins here."""
    version = npy.read_magic(stream)
    read_header = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}[version]
    shape, fortran, kind = read_header(stream)
    return shape, fortran, kind


def _array(content: bytes) -> NDArray[Any]:
    """The array in the bytes of a `.npy` file, whose size must be what its header says; ValueError otherwise."""
    stream = io.BytesIO(content)
    shape, fortran, kind = _header(stream)
    size = math.prod(shape) * kind.itemsize
    if kind.hasobject or len(content) - stream.tell() != size:
        raise ValueError
    flat = np.frombuffer(content, kind, count=math.prod(shape), offset=stream.tell()).copy()
    return flat.reshape(shape[::-1]).T if fortran else flat.reshape(shape)
