"""What runs that have just ended have come to, in few files, so that gathering need not open the file of each.

`TOKEN.finished` in the folder of a sweep has two records for the runs of a window that have the same parameters:
a head with names, sizes and times of their files and how they ended, and the numbers of all their candidates. It saves
time and no more: what it says counts only for files that have not been touched since, and others are opened.
"""

from __future__ import annotations

import io
import math
import os
import secrets
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.core.archive import ArrayPlace, Arrays, DamagedArchive, array_places, read_arrays
from warpmuscle.core.files import check_regular
from warpmuscle.results.journal import MAGIC, packed
from warpmuscle.results.records import COLUMNS, Evaluations, Result

PATTERN = "*.finished"
INTEGERS = ("status", "search", "generation", "stage")
_HEAD = struct.Struct("<QI")


@dataclass(frozen=True)
class RunTable:
    """What tables take from a run."""

    columns: dict[str, Any]  # of its candidates
    best: tuple[int, float] | None  # row and cost of its best one
    ended: str
    labels: dict[str, tuple[str, ...]]  # names of parameters and terms
    units: tuple[str, ...]  # of parameters
    evaluated: int  # candidates in all, of which the columns may have only some


class FinishedJournal:
    """The journal of this process."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / f"{secrets.token_hex(4)}.finished"

    def keep(self, runs: Sequence[tuple[str, Path, Result]]) -> None:
        """Put down runs by names, files and results; where there is no room for it, nothing is lost but time."""
        alike: dict[Any, list[tuple[str, Path, Result]]] = {}
        for run in runs:
            result = run[2]
            if result.evaluations is not None and result.best is not None and result.searched is not None:
                key = (result.parameters.name, result.parameters.unit, result.evaluations.term_names)
                alike.setdefault(key, []).append(run)
        try:
            with open(self._path, "ab") as file:
                if not file.tell():
                    file.write(MAGIC)
                for key, some in alike.items():
                    file.write(b"".join(map(packed, _records(key, some))))
        except OSError:
            self._path.unlink(missing_ok=True)


def _records(key: Any, runs: Sequence[tuple[str, Path, Result]]) -> tuple[Arrays, Arrays]:
    stamps = [path.stat() for _, path, _ in runs]
    found = [_parts_of(result) for _, _, result in runs]
    head: Arrays = {
        "names": np.array([name for name, _, _ in runs]),
        "size": np.array([stamp.st_size for stamp in stamps], dtype=np.int64),
        "time": np.array([stamp.st_mtime_ns for stamp in stamps], dtype=np.int64),
        "ended": np.array([ended for _, _, _, ended in found]),
        "index": np.array([index for _, index, _, _ in found], dtype=np.int64),
        "best": np.array([cost for _, _, cost, _ in found]),
        "count": np.array([len(evaluations) for evaluations, _, _, _ in found], dtype=np.int64),
        "evaluated": np.array([result.evaluated for _, _, result in runs], dtype=np.int64),
    }
    texts = zip(("params", "units", "terms"), key, strict=True)
    head |= {name: np.array(words, dtype=np.str_) for name, words in texts}
    body: Arrays = {
        name: np.concatenate([getattr(evaluations, name) for evaluations, _, _, _ in found])
        for name in (*COLUMNS, "terms")
    }
    return head, body | {name: body[name].astype(np.int32) for name in INTEGERS}


def _parts_of(result: Result) -> tuple[Evaluations, int, float, str]:
    assert result.evaluations is not None
    assert result.best is not None
    assert result.searched is not None
    return result.evaluations, result.best.index, result.best.cost, result.searched.ended


class FinishedRuns:
    """What the journals of a folder say, read when it is asked for."""

    def __init__(self, folder: Path) -> None:
        self._places: dict[str, tuple[Path, int, int, Arrays]] = {}  # file, place of the numbers, row, head
        self._bodies: dict[tuple[Path, int], dict[str, ArrayPlace]] = {}  # where columns are in records that are whole
        for path in sorted(folder.glob(PATTERN)):
            try:
                check_regular(path)
                self._scan(path)
            except (OSError, DamagedArchive, KeyError, ValueError):
                continue

    def _scan(self, path: Path) -> None:
        """Find the heads of a journal, and where the numbers of each begin."""
        with open(path, "rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                return
            while (head := _record(file)) is not None:
                place = file.tell()
                length = file.read(_HEAD.size)
                if len(length) < _HEAD.size:
                    return
                file.seek(_HEAD.unpack(length)[0], os.SEEK_CUR)
                for row, name in enumerate(np.atleast_1d(head["names"]).tolist()):
                    self._places[name] = path, place, row, head

    def state(self, name: str, file: tuple[int, int] | None) -> tuple[str, int, float] | None:
        """Why a run has ended whose file has this size and time, its candidates and least cost; None if not known."""
        if name not in self._places or file is None:
            return None
        _, _, row, head = self._places[name]
        try:
            if (int(head["size"][row]), int(head["time"][row])) != file:
                return None
            return str(head["ended"][row]), _evaluated(head, row), float(head["best"][row])
        except (KeyError, ValueError, IndexError):
            return None

    def table(self, name: str, size: int, time: int) -> RunTable | None:
        """What a run has come to whose file has this size and time; None if that is not known."""
        if name not in self._places:
            return None
        path, place, row, head = self._places[name]
        try:
            if (int(head["size"][row]), int(head["time"][row])) != (size, time):
                return None
            counts = head["count"]
            rows = int(counts[:row].sum()), int(counts[row])
            labels = {"params": _texts(head["params"])}
            if terms := _texts(head["terms"]):
                labels["terms"] = terms
            columns = self._columns(path, place, [*COLUMNS, *(["terms"] if terms else [])], *rows)
            widths = {name: (len(words),) for name, words in labels.items()}
            if any(values.shape != (counts[row], *widths.get(name, ())) for name, values in columns.items()):
                return None
            best = int(head["index"][row]), float(head["best"][row])
            ended, units = str(head["ended"][row]), _texts(head["units"])
            return RunTable(columns, best, ended, labels, units, _evaluated(head, row))
        except (OSError, DamagedArchive, KeyError, ValueError, IndexError):
            return None

    def _columns(self, path: Path, place: int, names: Sequence[str], begin: int, count: int) -> Arrays:
        """So many rows of the columns of a record from one on, and no others: records of many parts take turns."""
        with open(path, "rb") as file:
            if (path, place) not in self._bodies:
                file.seek(place)
                content = _content(file)
                if content is None:
                    raise ValueError("torn")
                self._bodies[path, place] = array_places(content)
            found = {}
            for name in names:
                there = self._bodies[path, place][name]
                if not 0 <= begin <= begin + count <= there.shape[0]:
                    raise ValueError("too short")
                width = math.prod(there.shape[1:])
                file.seek(place + _HEAD.size + there.offset + begin * width * there.kind.itemsize)
                found[name] = np.fromfile(file, there.kind, count * width).reshape(count, *there.shape[1:])
            return found


def _evaluated(head: Arrays, row: int) -> int:
    """Candidates of a run in all; journals of before some were left out have all of them."""
    return int(head.get("evaluated", head["count"])[row])


def _record(file: Any) -> Arrays | None:
    """The record that begins here; None if it is not whole."""
    content = _content(file)
    return None if content is None else read_arrays(io.BytesIO(content))


def _content(file: Any) -> bytes | None:
    """The archive of the record that begins here; None if it is not whole."""
    head = file.read(_HEAD.size)
    if len(head) < _HEAD.size:
        return None
    length, checksum = _HEAD.unpack(head)
    if length > os.fstat(file.fileno()).st_size:
        return None
    payload = file.read(length)
    if len(payload) < length or zlib.crc32(payload) != checksum:
        return None
    return bytes(payload)


def _texts(array: Any) -> tuple[str, ...]:
    return tuple(map(str, np.atleast_1d(array).tolist()))
