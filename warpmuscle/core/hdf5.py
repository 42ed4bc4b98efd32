"""Opens HDF5 files that may come from anyone: nothing outside of a file is read, and no more than fits.

HDF5 can show what is in other files: by external and soft links, by datasets whose numbers are stored elsewhere, and by
virtual datasets. None of these is followed. A small file can also claim arrays of any size, which are not read.
"""

from __future__ import annotations

import contextlib
import math
import struct
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.core.files import NOT_REGULAR, check_regular, unreadable
from warpmuscle.core.limits import LIMITS, check_size

FREE_BYTES = 2**28  # that any file may have, unpacked
MOST_GROWTH = 100  # times its own size that a larger one may unpack to
_FILTERS = {h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32, h5py.h5z.FILTER_LZF,
            h5py.h5z.FILTER_SZIP, h5py.h5z.FILTER_NBIT, h5py.h5z.FILTER_SCALEOFFSET}  # fmt: skip
DAMAGES = (
    KeyError, IndexError, ValueError, TypeError, AttributeError, RuntimeError, ArithmeticError, MemoryError,
    StopIteration, struct.error, zlib.error,
)  # fmt: skip
Says = Callable[[str], Error]


@contextlib.contextmanager
def opened(path: str | Path, error: Says, damaged: str = "damaged HDF5 file") -> Iterator[h5py.File]:
    """An HDF5 file to read.

    Args:
        error: makes the error that is raised of what is wrong.
        damaged: what such an error begins with where the content is not as it should be.

    Raises:
        Error: the file cannot be read, is none of HDF5, or the work within fails by what it holds.
    """
    with _as_errors(error, damaged):
        check_regular(path)
        if Path(path).is_dir():
            raise error("cannot be read: this is a folder")
        with h5py.File(path, "r") as file:
            yield file


@contextlib.contextmanager
def opened_bytes(content: bytes, error: Says, damaged: str = "damaged HDF5 file") -> Iterator[h5py.File]:
    """An HDF5 file whose bytes are in the memory, to read; see `opened`."""
    with _as_errors(error, damaged):
        access = h5py.h5p.create(h5py.h5p.FILE_ACCESS)
        access.set_fapl_core(backing_store=False)
        access.set_file_image(content)
        file = h5py.h5f.open(b"bytes", h5py.h5f.ACC_RDONLY, access)
        try:
            yield h5py.File(file)
        finally:
            file.close()  # the memory is free once nothing of the file is in use


@contextlib.contextmanager
def _as_errors(error: Says, damaged: str) -> Iterator[None]:
    """Say in one line why a file cannot be read, or what is wrong with it."""
    try:
        yield
    except FileNotFoundError:
        raise error("no such file") from None
    except PermissionError as found:
        raise error(unreadable(found)) from None
    except OSError as found:
        pipe = found.strerror == NOT_REGULAR
        raise error(NOT_REGULAR if pipe else "not an HDF5 file, or damaged") from None
    except MemoryError:
        raise error("does not fit into the memory") from None
    except DAMAGES as found:
        text = found.args[0] if isinstance(found, KeyError) and found.args else found
        raise error(f"{damaged}: {' '.join(str(text).split())}") from None


def member(group: Any, name: str) -> Any:
    """What a group holds under a name, not through a link to elsewhere.

    Raises:
        KeyError: nothing. ValueError: it is a link.
    """
    found = _opened_within(group, name.encode())
    return h5py.Group(found) if isinstance(found, h5py.h5g.GroupID) else group[name]


def _opened_within(group: Any, key: bytes) -> Any:
    """See `member`; as an object of the library below h5py."""
    if key not in group.id:
        raise KeyError(f"{_path(group.id, key)} is missing")
    _check_link(group.id, key)
    return h5py.h5o.open(group.id, key)


def check_contents(group: Any) -> None:
    """Check all that is in a group, before any of it is read.

    Raises:
        ValueError: something is stored in or linked from elsewhere, is too large, or is in a group twice.
    """
    most = max(FREE_BYTES, MOST_GROWTH * group.file.id.get_filesize())
    waiting, seen, count, size = [group.id], {_address(group.id)}, 0, 0
    while waiting:
        inner = waiting.pop()
        for key in inner:
            count += 1
            check_size("objects", count, ValueError)
            _check_link(inner, key)
            found = h5py.h5o.open(inner, key)
            if isinstance(found, h5py.h5g.GroupID):
                if _address(found) in seen:
                    raise ValueError(f"{_path(inner, key)} is a group that is also elsewhere in the file")
                seen.add(_address(found))
                waiting.append(found)
            elif isinstance(found, h5py.h5d.DatasetID):
                size += _checked_size(found, _path(inner, key))
                check_size("unpacked", size, _said_of(_path(inner, key)))
                if size > most:
                    raise ValueError(f"{_path(inner, key)} and what comes before it would take {size:.3g} bytes, more "
                                     f"than the {most:.3g} that are read of this file")  # fmt: skip


def array(group: Any, name: str) -> Any:
    """All that a dataset of a group holds; raises KeyError or ValueError if there is none of this name."""
    found = member(group, name)
    if not isinstance(found, h5py.Dataset):
        raise ValueError(f"{found.name} is not a dataset")
    return found[()]


def checked_array(group: Any, name: str) -> Any:
    """All that a dataset holds, of a group whose contents were not checked as a whole (see `check_contents`).

    Raises:
        KeyError or ValueError: there is none of this name, it is stored or linked elsewhere, or it is too large.
    """
    key = name.encode()
    found = _opened_within(group, key)
    if not isinstance(found, h5py.h5d.DatasetID):
        raise ValueError(f"{_path(group.id, key)} is not a dataset")
    _check_dataset(found, _path(group.id, key))
    kind = found.dtype
    if kind.kind not in "fiuO":
        return h5py.Dataset(found)[()]
    values = np.empty(found.shape, kind)
    if values.size:
        memory = h5py.h5t.py_create(kind) if kind.kind == "O" else None
        found.read(h5py.h5s.ALL, h5py.h5s.ALL, values, mtype=memory)
    return values if values.ndim else values[()]


def checked(group: Any, name: str) -> Any:
    """Such a dataset, of which nothing has been read; see `checked_array`."""
    found = member(group, name)
    if not isinstance(found, h5py.Dataset):
        raise ValueError(f"{found.name} is not a dataset")
    _check_dataset(found.id, found.name)
    return found


def _check_dataset(dataset: Any, name: str) -> None:
    """Raise ValueError if not all of a dataset is here, or if it is too large."""
    size = _checked_size(dataset, name)
    check_size("unpacked", size, _said_of(name))
    if size > FREE_BYTES and size > (most := MOST_GROWTH * h5py.h5i.get_file_id(dataset).get_filesize()):
        raise ValueError(f"{name} would take {size:.3g} bytes, more than the {most:.3g} that are read of this file")


def arrays(group: Any) -> dict[str, Any]:
    """All that the datasets of a group hold, by name; raises ValueError if it has other members.

    `group.items()` would hold the lock of h5py for as long as an error on the way is kept, and stop all other threads.
    """
    return {name: array(group, name) for name in list(group)}


def attribute(owner: Any, name: str) -> Any:
    """An attribute; raises KeyError if there is none of this name."""
    if name not in owner.attrs:
        raise KeyError(f"attribute {name!r} of {owner.name} is missing")
    return owner.attrs[name]


def number(owner: Any, name: str) -> float:
    """An attribute that is one number.

    Raises:
        KeyError: there is none of this name. ValueError: it is something else, or not finite.
    """
    value = attribute(owner, name)
    if isinstance(value, np.ndarray | h5py.Empty) or not isinstance(value, int | float | np.number):
        raise ValueError(f"{_attribute_of(owner, name)} is {_shown(value)}, and should be a number")
    if not math.isfinite(value):
        raise ValueError(f"{_attribute_of(owner, name)} is {value}, and should be a finite number")
    return float(value)


def integer(owner: Any, name: str, default: int | None = None) -> int:
    """An attribute that is one whole number, or a default where there is none of this name; for errors see `number`."""
    if default is not None and name not in owner.attrs:
        return default
    value = attribute(owner, name)
    if not isinstance(value, int | np.integer):
        raise ValueError(f"{_attribute_of(owner, name)} is {_shown(value)}, and should be a whole number")
    return int(value)


def members(group: Any, name: str) -> Any:
    """The group under a name in a group; raises KeyError or ValueError if there is none."""
    found = member(group, name)
    if not isinstance(found, h5py.Group):
        raise ValueError(f"{found.name} is not a group")
    return found


def _attribute_of(owner: Any, name: str) -> str:
    return f"the attribute {name} of {owner.name}"


def _shown(value: Any) -> str:
    """Some of a value that is wrong."""
    return f"an array of shape {np.shape(value)}" if np.ndim(value) else repr(value)[:40]


def strings(dataset: Any) -> tuple[str, ...]:
    """The strings of a dataset (n,).

    Raises:
        ValueError or TypeError: it holds something else, or more than fits.
    """
    if not isinstance(dataset, h5py.Dataset):
        raise ValueError(f"{dataset.name} is not a dataset")
    if dataset.ndim != 1:
        raise ValueError(f"{dataset.name} has shape {dataset.shape}; a list of names has one axis")
    says = _said_of(dataset.name)
    check_size("names", len(dataset), says)
    found: list[str] = []
    characters = 0
    rows = max(LIMITS["unpacked"].most // max(dataset.file.id.get_filesize(), 1), 1)  # all may show the same long text
    for first in range(0, len(dataset), rows):
        found.extend(dataset.asstr()[first : first + rows])
        characters += sum(map(len, found[first:]))
        check_size("characters", characters, says)
    return tuple(found)


def text(dataset: Any) -> str:
    """The one string of a dataset; raises ValueError or TypeError if it holds something else."""
    if not isinstance(dataset, h5py.Dataset):
        raise ValueError(f"{dataset.name} is not a dataset")
    if dataset.shape != ():
        raise ValueError(f"{dataset.name} has shape {dataset.shape}, and should be one text")
    try:
        return str(dataset.asstr()[()])
    except UnicodeDecodeError:
        raise ValueError(f"{dataset.name} holds bytes that are no text") from None


def _said_of(name: str) -> Callable[[str], ValueError]:
    """Makes the error of what is wrong with a dataset."""
    return lambda text: ValueError(f"{name}: {text}")


def _check_link(group: Any, key: bytes) -> None:
    kind = group.links.get_info(key).type
    if kind != h5py.h5l.TYPE_HARD:
        what = {h5py.h5l.TYPE_EXTERNAL: "another file", h5py.h5l.TYPE_SOFT: "elsewhere"}.get(kind, "something unknown")
        raise ValueError(f"{_path(group, key)} is a link to {what}, which is not followed")


def _checked_size(dataset: Any, name: str) -> int:
    """Bytes of a dataset in the memory, or of the pieces that it is unpacked by; ValueError if it is not all here."""
    made = dataset.get_create_plist()
    layout = made.get_layout()
    if layout == h5py.h5d.CONTIGUOUS and made.get_external_count():
        raise ValueError(f"{name} is stored in another file, which is not read")
    if layout == h5py.h5d.VIRTUAL:
        raise ValueError(f"{name} shows what is in other datasets, which is not followed")
    kind, shape = dataset.get_type(), dataset.shape
    if shape is None:
        raise ValueError(f"{name} holds nothing")
    pieces = [shape]
    if layout == h5py.h5d.CHUNKED:
        pieces.append(made.get_chunk())
        for number in range(made.get_nfilters()):
            if made.get_filter(number)[0] not in _FILTERS:
                raise ValueError(f"{name} is packed in a way that is not known here")
    return max(_product(piece) for piece in pieces) * int(kind.get_size())


def _product(shape: tuple[int, ...]) -> int:
    result: int = math.prod(shape)
    return result


def _address(identifier: Any) -> int:
    return int(h5py.h5o.get_info(identifier).addr)


def _path(group: Any, key: bytes) -> str:
    place = (h5py.h5i.get_name(group) or b"").rstrip(b"/") + b"/" + key
    return place.decode(errors="replace")
