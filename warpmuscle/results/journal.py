"""A journal beside a result file: what was computed since the file was last written, safe from a kill at any moment.

The file `NAME.h5.journal` begins with a magic line and then has records, each a length (8 bytes), a CRC-32 (4 bytes),
both little-endian, and so many bytes of NumPy arrays (.npz, no pickled objects). The first record holds the identity of
the run, every other one the candidates of one generation. A record is on the disk before the next generation starts;
what follows the last whole record was being written when the process died, and is dropped.
"""

from __future__ import annotations

import contextlib
import io
import os
import stat
import struct
import sys
import zlib
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from warpmuscle.core.archive import Arrays, DamagedArchive, read_arrays
from warpmuscle.core.errors import OccupiedError, ResultError
from warpmuscle.core.files import NOT_REGULAR, check_regular, unwritable
from warpmuscle.results.checks import check_evaluations
from warpmuscle.results.records import TABLE, Evaluations

if sys.platform != "win32":
    import fcntl

SUFFIX = ".journal"
MAGIC = b"warpmuscle journal 1\n"
_HEAD = struct.Struct("<QI")  # length and CRC-32 of what follows


def journal_path(path: Path) -> Path:
    """Where the journal of a result file lies."""
    return path.with_name(path.name + SUFFIX)


class Journal:
    """The open journal of one run; while it is open no other process can open it.

    Use it as a context manager: leaving closes the file, and keeps it.
    """

    def __init__(self, path: Path, identity: str) -> None:
        """Open the journal at a path, or begin one.

        Args:
            path: of the journal itself.
            identity: of the run, such as a digest of its scene and options.

        Raises:
            ResultError: it cannot be written, is open elsewhere, or belongs to another run.
        """
        self._path, self._identity = path, identity
        found = path.exists()
        try:
            self._file = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o666)
        except OSError as error:
            raise ResultError(f"{path}: {unwritable(error)}") from None
        try:
            if not stat.S_ISREG(os.fstat(self._file).st_mode):
                raise ResultError(f"{path}: {NOT_REGULAR}")
            self._lock()
            content = self._read()
            self._records, self._end = unpacked(content)
            if not content.startswith(MAGIC) and not MAGIC.startswith(content):
                raise ResultError(f"{path}: not a journal of warpmuscle; move it out of the way")
            if self._records and str(self._records[0].get("identity")) != identity:
                raise ResultError(f"{path}: the journal of another search; move it out of the way")
            if not self._records:
                self.clear()
        except BaseException as error:
            if not found and isinstance(error, Exception | KeyboardInterrupt):
                self.remove()
            os.close(self._file)
            raise

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @staticmethod
    def occupied(path: Path) -> bool:
        """Whether another process has the journal open."""
        if sys.platform == "win32" or not path.is_file():
            return False
        try:
            file = os.open(path, os.O_RDWR)
        except OSError:
            return False
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        except OSError:  # a file system without locks
            return False
        finally:
            os.close(file)
        return False

    @staticmethod
    def look(path: Path) -> list[Evaluations]:
        """The generations in a journal that another process may be writing just now; none if it cannot be read."""
        try:
            check_regular(path)
            return [_evaluations(record) for record in unpacked(path.read_bytes())[0][1:]]
        except (OSError, ValueError):
            return []

    def close(self) -> None:
        """Close the file, and keep it; other processes may open it then."""
        os.close(self._file)

    def generations(self) -> list[Evaluations]:
        """The generations that were found when the journal was opened, in order.

        Raises:
            ResultError: a record is whole, but no generation of a search.
        """
        try:
            return [_evaluations(record) for record in self._records[1:]]
        except ValueError as error:
            raise ResultError(f"{self._path}: damaged journal: {error}; move it out of the way") from None

    def append(self, generation: Evaluations) -> None:
        """Put down the candidates of one generation; they are on the disk when this returns.

        Raises:
            ResultError: it cannot be written; the generations before it stay.
        """
        columns = {name: getattr(generation, name) for name in TABLE}
        self._write(packed({**columns, "term_names": np.array(generation.term_names, dtype=np.str_)}))

    def clear(self) -> None:
        """Forget all generations, once the result file has them.

        Raises:
            ResultError: it cannot be written.
        """
        self._end = 0
        self._write(MAGIC + packed({"identity": np.array(self._identity)}))

    def remove(self) -> None:
        """Remove the file, once the result file is complete; the lock lasts until the journal is closed."""
        with contextlib.suppress(OSError):
            self._path.unlink()

    def _write(self, content: bytes) -> None:
        """Write behind what there is, over a torn record; a failure leaves what there is."""
        try:
            os.ftruncate(self._file, self._end)
            os.lseek(self._file, self._end, os.SEEK_SET)
            rest = memoryview(content)
            while rest:
                rest = rest[os.write(self._file, rest) :]
            os.fsync(self._file)
        except OSError as error:
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, self._end)
            raise ResultError(f"{self._path}: {unwritable(error)}") from None
        self._end += len(content)

    def _lock(self) -> None:
        if sys.platform == "win32":
            return
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OccupiedError(f"{self._path}: another process is at work on this search") from None
        except OSError:
            pass  # a file system without locks

    def _read(self) -> bytes:
        os.lseek(self._file, 0, os.SEEK_SET)
        with os.fdopen(os.dup(self._file), "rb") as file:
            return file.read()


def packed(arrays: Arrays) -> bytes:
    """A record of these arrays."""
    payload = io.BytesIO()
    np.savez(payload, **arrays)  # type: ignore[arg-type]  # no array is called allow_pickle
    content = payload.getvalue()
    return _HEAD.pack(len(content), zlib.crc32(content)) + content


def unpacked(content: bytes) -> tuple[list[Arrays], int]:
    """The whole records of a journal, and where the last of them ends."""
    found: list[Arrays] = []
    end = len(MAGIC)
    while len(content) >= end + _HEAD.size:
        length, checksum = _HEAD.unpack_from(content, end)
        payload = content[end + _HEAD.size : end + _HEAD.size + length]
        if len(payload) < length or zlib.crc32(payload) != checksum:
            break
        try:
            found.append(read_arrays(io.BytesIO(payload)))
        except DamagedArchive:
            break
        end += _HEAD.size + length
    return found, end


def _evaluations(record: Arrays) -> Evaluations:
    """The generation in a record; ValueError if it holds none."""
    if missing := [name for name in (*TABLE, "term_names") if name not in record and name != "stage"]:
        raise ValueError(f"{missing[0]} is missing")
    first = np.zeros(record["cost"].shape, dtype=np.int32)  # journals of before there were stages have no such column
    columns: dict[str, Any] = {name: ({"stage": first} | record)[name] for name in TABLE}
    found = Evaluations(**columns, term_names=tuple(map(str, np.atleast_1d(record["term_names"]))))
    check_evaluations(found, np.shape(found.params)[-1] if np.ndim(found.params) else 0)
    if len(np.unique(found.generation)) != 1:
        raise ValueError("a record holds candidates of no generation, or of several")
    return found
