"""Journals of batches that runs share: what was evaluated of runs that have no file of their own yet.

A process that works on a sweep has a file `TOKEN.rounds` in its folder, laid out as other journals (see
`results.journal`): the first record says by which version and on which machine, every other one holds what a round of
batches has brought to each of the runs in it. It is on the disk before the runs go on, and is emptied once all of them
have files.
"""

from __future__ import annotations

import contextlib
import json
import os
import secrets
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.core.archive import Arrays
from warpmuscle.core.errors import ResultError
from warpmuscle.core.files import check_regular, unwritable
from warpmuscle.core.machine import this_machine
from warpmuscle.results.checks import check_evaluations
from warpmuscle.results.journal import MAGIC, packed, unpacked
from warpmuscle.results.records import Evaluations, joined, version_of
from warpmuscle.sweep.shared_batches import Asked

PATTERN = "*.rounds"


class Rounds:
    """The journal of this process."""

    def __init__(self, folder: Path, names: Sequence[str] = ()) -> None:
        """Nothing is written yet; `names` are those of the runs by their numbers."""
        self._path = folder / f"{secrets.token_hex(4)}.rounds"
        self.names = names
        self._end = 0

    def keep(self, parts: Sequence[Asked]) -> None:
        """Put down what has been evaluated of these rows; it is on the disk when this returns.

        Raises:
            ResultError: it cannot be written; what was there before stays.
        """
        record = _record(self.names, parts)
        if record is None:
            return
        try:
            with open(self._path, "r+b" if self._end else "wb") as file:
                file.seek(self._end)
                file.truncate()
                if not self._end:
                    file.write(MAGIC + packed(_header()))
                file.write(packed(record))
                file.flush()
                os.fsync(file.fileno())
                self._end = file.tell()
        except OSError as error:
            raise ResultError(f"{self._path}: {unwritable(error)}") from None

    def clear(self) -> None:
        """Forget everything, once all runs have files; these are on the disk then."""
        if self._end:
            if hasattr(os, "sync"):
                os.sync()
            with contextlib.suppress(OSError):
                self._path.unlink(missing_ok=True)
            self._end = 0


class Known:
    """What earlier processes have evaluated of a run, by generation."""

    def __init__(self) -> None:
        self._parts: dict[int, list[tuple[Any, Evaluations]]] = {}
        self.elsewhere = False  # whether any of it was evaluated on another machine

    def add(self, generation: int, rows: Any, part: Evaluations) -> None:
        """Put further rows to a generation."""
        self._parts.setdefault(generation, []).append((rows, part))

    @property
    def generations(self) -> dict[int, Evaluations]:
        """All candidates of each generation, in the order in which they were asked for."""
        return {number: _ordered(parts) for number, parts in sorted(self._parts.items())}


def known_of(folder: Path, names: Sequence[str] | None = None) -> dict[str, Known]:
    """What journals in a folder have of runs, by name; by default of all. Those of other versions do not count."""
    wanted = None if names is None else set(names)
    found: dict[str, Known] = {}
    for path in sorted(folder.glob(PATTERN)):
        records = _records(path)
        if not records or "origin" not in records[0]:
            continue
        try:
            origin = json.loads(str(records[0]["origin"]))
            if origin["version"] != version_of("warpmuscle"):
                continue
            for record in records[1:]:
                for name, generation, rows, part in _parts(record):
                    if wanted is None or name in wanted:
                        known = found.setdefault(name, Known())
                        known.add(generation, rows, part)
                        known.elsewhere |= origin["machine"] != dict(this_machine())
        except (ValueError, KeyError, IndexError, TypeError):
            continue  # as if it had not been written: it is computed anew
    return found


def remove_known(folder: Path, going_on: Sequence[str]) -> None:
    """Remove the journals that have nothing of runs that are to go on."""
    left = set(going_on)
    for path in folder.glob(PATTERN):
        names: set[str] = set()
        for record in _records(path)[1:]:
            names |= set(map(str, np.atleast_1d(record.get("names", ()))))
        if not names & left:
            with contextlib.suppress(OSError):
                path.unlink()


def _header() -> Arrays:
    origin = {"version": version_of("warpmuscle"), "machine": dict(this_machine())}
    return {"origin": np.array(json.dumps(origin))}


def _records(path: Path) -> list[Arrays]:
    try:
        check_regular(path)
        content = path.read_bytes()
    except OSError:
        return []
    return unpacked(content)[0] if content.startswith(MAGIC) else []


def _record(names: Sequence[str], parts: Sequence[Asked]) -> Arrays | None:
    """What of these rows has ended, as arrays; None if nothing has."""
    found = [(one, rows[one.generation.ended(rows)]) for one, rows in parts]
    found = [(one, rows) for one, rows in found if len(rows)]
    if not found:
        return None
    generations = [one.generation for one, _ in found]
    columns: dict[str, Any] = {
        "search": [one.generation.search[rows] for one, rows in found],
        "cost": [one.generation.cost[rows] for one, rows in found],
        "status": [one.generation.status[rows] for one, rows in found],
        "end_time": [one.generation.end_time[rows] for one, rows in found],
        "terms": [one.generation.terms[rows] for one, rows in found],
        "row": [rows for _, rows in found],
        "params": [one.generation.values[rows].ravel() for one, rows in found],
    }
    record: Arrays = {name: np.concatenate(arrays) for name, arrays in columns.items()}
    record["names"] = np.array([names[one.job] for one, _ in found])
    record["count"] = np.array([len(rows) for _, rows in found], dtype=np.int64)
    record["width"] = np.array([generation.values.shape[1] for generation in generations], dtype=np.int64)
    record["generation"] = np.array([generation.number for generation in generations], dtype=np.int64)
    record["term_names"] = np.array(generations[0].term_names, dtype=np.str_)
    return record


def _parts(record: Mapping[str, Any]) -> list[tuple[str, int, Any, Evaluations]]:
    """Run, generation, rows of it and what became of them, of all in a record; ValueError if it holds none such."""
    found = []
    term_names = tuple(map(str, np.atleast_1d(record["term_names"])))
    begin = first = 0
    for name, count, width, generation in zip(
        record["names"], record["count"].tolist(), record["width"].tolist(), record["generation"].tolist(), strict=True
    ):
        part = slice(begin, begin + count)
        params = record["params"][first : first + count * width].reshape(count, width)
        number = np.full(count, generation, dtype=np.int32)
        evaluations = Evaluations(
            params, record["cost"][part], record["status"][part], record["end_time"][part], record["search"][part],
            number, np.zeros(count, dtype=np.int32), record["terms"][part], term_names,
        )  # fmt: skip
        check_evaluations(evaluations, width)
        found.append((str(name), generation, record["row"][part], evaluations))
        begin, first = begin + count, first + count * width
    return found


def _ordered(parts: Sequence[tuple[Any, Evaluations]]) -> Evaluations:
    """Parts of a generation as one, each row once and in order."""
    rows = np.concatenate([rows for rows, _ in parts])
    _, order = np.unique(rows, return_index=True)
    return joined([part for _, part in parts]).rows(order)
