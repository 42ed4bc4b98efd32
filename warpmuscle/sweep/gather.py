"""The results of a sweep in one HDF5 file, written whole or not at all, run by run.

- attributes of `/`: `format` ("warpmuscle sweep"), `format_version`, `name`, `command`, versions, `began`, `host`,
  `commit`, `ended`: whether all runs have
- `/sweep`: the sweep file, TOML text
- `/runs/<name>`: the result file of each run, byte by byte (see `warpmuscle.results.result`)
- `/table/{run, seed, evaluated, best_cost, ended}`: (R,), a row a run; `/table/axes/<axis>`: (R,), what sets it apart;
  not a number, or empty, where a run has no value of an axis
- `/table/{best_params, best_terms}`: (R, P) and (R, T), the best candidate, if all runs have the same ones
- `/all/{cost, status, end_time, search, generation, stage}`: (N,), the candidates of all runs one behind the other;
  `params` (N, P) and `terms` (N, T) if all runs have the same; only the first and the best of a run that keeps no more
- `/all/run`: (N,), row of `/table`
- `candidate`, `run`, `parameter` and `term` in both are attached to the axes as dimension scales; `parameter_unit`

Up to version 3 of the format runs were groups, and the datasets of `/all` virtual ones, which showed what stood there.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from warpmuscle.core import hdf5
from warpmuscle.core.errors import ResultError, SceneError
from warpmuscle.core.files import read_file, unreadable
from warpmuscle.core.hdf5_writing import Column, store, streamed
from warpmuscle.core.plain_text import readable
from warpmuscle.core.status import Status
from warpmuscle.results.records import COLUMNS, installed_versions
from warpmuscle.results.result import SWEEP_FORMAT, SWEEP_VERSION
from warpmuscle.sweep.finished import FinishedRuns, RunTable
from warpmuscle.sweep.folder import Folder, Manifest, RunEntry, RunState

TABLE = {
    "run": "name of the run",
    "seed": "its seed",
    "evaluated": "candidates that it has evaluated",
    "best_cost": "least value of its objective, infinite if there is none yet",
    "ended": "why its search has ended",
}
ALL = {
    "params": "candidates of all runs",
    "cost": "value of the objective",
    "status": "outcome; see the attributes named after outcomes",
    "end_time": "simulated time at which the instance ended",
    "search": "number of the search that asked for it, -1 for the scene as given",
    "generation": "generation in which it was asked for",
    "stage": "stage in which it was asked for; costs of different stages cannot be compared",
    "terms": "terms of the objective, unweighted",
}
LABELS = {"params": ("parameter",), "terms": ("term",)}  # what stands along the second axis


def gather(
    folder: Folder, manifest: Manifest, states: Sequence[RunState], output: Path, command: str,
    tell: Callable[[int], None] | None = None,
) -> int:  # fmt: skip
    """Write what all runs of a sweep have come to into one file.

    Args:
        states: of all runs. tell: gets how many runs have been written.

    Returns:
        How many runs it has: those that have evaluated anything.

    Raises:
        ResultError: a file cannot be read or written; nothing is left behind then.
    """
    has_begun = {state.name: state.kept and state.evaluated > 0 for state in states}
    entries = [entry for entry in manifest.runs if has_begun[entry.name]]
    whole = len(entries) == len(states) and all(state.ended for state in states)
    with writing(folder, manifest, output, command, whole) as file:
        runs = file.create_group("runs", track_order=True)
        table, candidates, finished = _Table(file), _All(file), FinishedRuns(folder.path)
        for number, entry in enumerate(entries):
            run = put_run(folder, runs, entry, finished)
            table.add(run)
            candidates.add(number, run)
            if tell is not None:
                tell(number + 1)
        table.finish(entries)
        candidates.finish()
    return len(entries)


@contextmanager
def writing(folder: Folder, manifest: Manifest, output: Path, command: str, whole: bool) -> Iterator[Any]:
    """The open file with what all gathered files have; raises ResultError if it cannot be written."""
    try:
        with streamed(output) as file:
            file.attrs["format"], file.attrs["format_version"] = SWEEP_FORMAT, SWEEP_VERSION
            file.attrs["name"], file.attrs["command"], file.attrs["ended"] = manifest.name, readable(command), whole
            for name, version in sorted(installed_versions().items()):
                file.attrs[f"{name}_version"] = version
            for name, value in sorted(manifest.origin.items()):
                file.attrs[name] = value
            store(file, "sweep", manifest.text, description="the sweep, as TOML")
            yield file
    except SceneError as error:
        raise ResultError(f"{error}; the runs are in {folder.path}, and the same command goes on") from None


def put_run(folder: Folder, runs: Any, entry: RunEntry, finished: FinishedRuns) -> RunTable:
    """Put the file of a run into a group, and read what tables have of it; raises ResultError if it cannot be read."""
    path = folder.result(entry.name)
    with contextlib.suppress(OSError):
        stamp = path.stat()
        known = finished.table(entry.name, stamp.st_size, stamp.st_mtime_ns)
        if known is not None:
            put_bytes(path, runs, entry.name)
            return known

    def wrong(message: str) -> ResultError:
        return ResultError(f"{path}: {message}; remove it, and it is computed anew")

    content = put_bytes(path, runs, entry.name)
    with hdf5.opened_bytes(content, wrong, "damaged result file") as file:
        group, parameters = hdf5.member(file, "evaluations"), hdf5.member(file, "parameters")
        there = set(group)
        columns = {name: hdf5.checked_array(group, name) for name in (*COLUMNS, "terms") if name in there}
        best = hdf5.member(file, "best") if "best" in file else None
        found = None
        if best is not None:
            found = int(hdf5.checked_array(best, "index")), float(hdf5.checked_array(best, "cost"))
        labels = {"params": _texts(parameters, "name")}
        if "terms" in columns:
            labels["terms"] = _texts(group, "term_names")
        searches = hdf5.member(file, "searches")
        ended, evaluated = str(hdf5.attribute(searches, "ended")), hdf5.integer(searches, "evaluated", 0)
        units = _texts(parameters, "unit")
        return RunTable(columns, found, ended, labels, units, evaluated or len(columns["cost"]))


def put_bytes(path: Path, runs: Any, name: str) -> bytes:
    """Put the bytes of a result file into a group; raises ResultError if it cannot be read."""
    try:
        content = read_file(path, "unpacked")
    except OSError as error:
        raise ResultError(f"{path}: {unreadable(error)}") from None
    store(runs, name, np.frombuffer(content, np.uint8), axes="byte", description="result file of the run (HDF5)")
    return content


def _texts(group: Any, name: str) -> tuple[str, ...]:
    return tuple(text.decode() for text in np.atleast_1d(hdf5.checked_array(group, name)).tolist())


class _Table:
    """The table of runs as it grows."""

    def __init__(self, file: Any) -> None:
        self._group = file.create_group("table", track_order=True)
        self._rows: dict[str, list[Any]] = {name: [] for name in ("evaluated", "best_cost", "ended")}
        self._best = {
            "params": _Common(self._group, "best_params", "parameters of the best candidate", ("run", "parameter")),
            "terms": _Common(self._group, "best_terms", "terms of the best candidate, unweighted", ("run", "term")),
        }

    def add(self, run: RunTable) -> None:
        """Put a row behind those that are there."""
        self._rows["evaluated"].append(run.evaluated)
        self._rows["best_cost"].append(run.best[1] if run.best is not None else np.inf)
        self._rows["ended"].append(run.ended)
        for name, column in self._best.items():
            rows = run.columns.get(name)
            row = None
            if rows is not None:
                best = run.best is not None and 0 <= run.best[0] < len(rows)
                row = rows[run.best[0]][None] if best and run.best else np.full((1, rows.shape[1]), np.nan)
            column.add(row, run)

    def finish(self, entries: Sequence[RunEntry]) -> None:
        """Put what is known of all rows."""
        columns: dict[str, Any] = {
            "run": [entry.name for entry in entries],
            "seed": np.array([entry.seed for entry in entries], dtype=np.int64),
            "evaluated": np.array(self._rows["evaluated"], dtype=np.int64),
            "best_cost": np.array(self._rows["best_cost"], dtype=np.float64),
            "ended": self._rows["ended"],
        }
        for name, values in columns.items():
            put_column(self._group, name, values, TABLE[name])
        put_axes(self._group, entries)
        for column in self._best.values():
            column.finish(self._group["run"])
        attach_runs(self._group)


def attach_runs(table: Any) -> None:
    """Attach the names of runs to the first axes of all columns of a table."""
    scale = table["run"]
    scale.make_scale("run")
    for group in (table, table["axes"]):
        for name in group:
            if isinstance(group[name], h5py.Dataset) and group[name].attrs["axes"] == "run" and group[name] != scale:
                group[name].dims[0].attach_scale(scale)


def put_axes(table: Any, entries: Sequence[RunEntry]) -> None:
    """Put what sets runs apart."""
    axes = table.create_group("axes", track_order=True)
    for name in dict.fromkeys(name for entry in entries for name in entry.axes):
        numeric = all(isinstance(entry.axes.get(name, 0.0), int | float) for entry in entries)
        values = [entry.axes.get(name, np.nan if numeric else "") for entry in entries]
        unit = next((entry.units[name] for entry in entries if name in entry.units), "")
        put_column(axes, _dataset_name(name), np.array(values, dtype=float) if numeric else list(map(str, values)),
                   f"value of the axis {name}; not a number, or empty, where a run has none",
                   unit if numeric else "")  # fmt: skip


def _dataset_name(axis: str) -> str:
    """The name of an axis as HDF5 may have it."""
    return re.sub(r"[/\0]|^\.+$", "_", axis)


def put_column(group: Any, name: str, values: Any, description: str, units: str = "") -> None:
    """Put a column of the table, (R,) numbers or texts."""
    values = tuple(values) if isinstance(values, list) else values
    store(group, name, values, units, "run", description=description, finite=False)


class _All:
    """The candidates of all runs as they come."""

    def __init__(self, file: Any) -> None:
        self._group = file.create_group("all", track_order=True)
        self._count = 0
        self._columns: dict[str, _Common] = {}

    def add(self, number: int, run: RunTable) -> None:
        """Put the candidates of a run behind those that are there; `number` is its row of the table."""
        if not self._columns:
            self._columns = {
                name: _Common(self._group, name, ALL[name], ("candidate", *LABELS.get(name, ())))
                for name in run.columns
            }
            self._columns["run"] = _Common(self._group, "run", "row of /table", ("candidate",))
        count = len(run.columns["cost"])
        for name, column in self._columns.items():
            whose = np.full(count, number, dtype=np.int32)
            column.add(whose if name == "run" else run.columns.get(name), run)
        self._count += count

    def finish(self) -> None:
        """Write what is left, and attach scales."""
        count = np.arange(self._count, dtype=np.int64)
        store(self._group, "candidate", count, axes="candidate", description="number of the candidate")
        self._group["candidate"].make_scale("candidate")
        for column in self._columns.values():
            column.finish(self._group["candidate"])
        if "status" in self._group:
            for member in Status:
                self._group["status"].attrs[member.name] = int(member)


class _Common:
    """A column over runs, which is left out if it does not mean the same in all of them."""

    def __init__(self, group: Any, name: str, description: str, axes: tuple[str, ...]) -> None:
        self._group, self._name, self._description, self._axes = group, name, description, axes
        self._column: Column | None = None
        self._first: RunTable | None = None
        self._same = True

    def add(self, rows: Any, run: RunTable) -> None:
        """Put the rows of a run behind those that are there."""
        first = self._first = self._first or run
        self._same = self._same and rows is not None and self._along(first) == self._along(run)
        if not self._same:
            self._column = None
            return
        if self._column is None:
            unit = {"end_time": "s", "params": "see parameter_unit", "best_params": "see parameter_unit"}
            self._column = Column(
                self._group, self._name, rows.dtype, rows.shape[1:], unit.get(self._name, ""), ", ".join(self._axes),
                self._description,
            )  # fmt: skip
        self._column.add(rows)

    def _along(self, run: RunTable) -> tuple[str, ...]:
        """What stands along the second axis."""
        return run.labels.get(self._name.removeprefix("best_"), ()) if len(self._axes) > 1 else ()

    def finish(self, scale: Any) -> None:
        """Write what is left, and attach the scales; the first one is given."""
        if self._column is None:
            if self._name in self._group:
                del self._group[self._name]
            return
        dataset = self._column.finish()
        dataset.dims[0].attach_scale(scale)
        if len(self._axes) > 1 and self._first is not None:
            axis = self._axes[1]
            if axis not in self._group:
                names = self._along(self._first)
                store(self._group, axis, names, axes=axis, description=f"names along the axis {axis}")
                self._group[axis].make_scale(axis)
                if axis == "parameter":
                    store(self._group, "parameter_unit", self._first.units, axes=axis, description="of each parameter")
                    self._group["parameter_unit"].dims[0].attach_scale(self._group[axis])
            dataset.dims[1].attach_scale(self._group[axis])
