"""The file of a sweep as one labelled table: a row a run, or a row a candidate of any run."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core import hdf5
from warpmuscle.core.arguments import as_path, as_text, as_truth, obtained_by
from warpmuscle.core.errors import ResultError
from warpmuscle.core.extras import imported
from warpmuscle.core.html_table import html_table
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.status import words
from warpmuscle.results.records import Result
from warpmuscle.results.result import SWEEP_FORMAT, opened_file
from warpmuscle.results.result import read as read_result
from warpmuscle.results.sweep_columns import (
    BEST,
    SweepColumn,
    candidates_of,
    check_shape,
    column_of,
    datasets,
    opened_sweep,
    texts,
    with_best,
)

if TYPE_CHECKING:
    import pandas
    import xarray

CANDIDATES = {"params": "parameter", "terms": "term"}
ENTRY = "entry"  # what the axis of entries of `[[run]]` is called, since `run` is the name of a run
SHOWN = 10  # runs in a notebook


@obtained_by('wm.read("sweep.h5") reads one, and wm.sweep makes one')
@dataclass(frozen=True, repr=False)
class Sweep:
    """Table of the results of a sweep of R runs.

    Attributes:
        path: of its file, which runs and candidates are read from when they are asked for.
        name: of the sweep. text: the sweep file, TOML. command: what made it.
        origin: versions of what produced it, and `began`, `host`, `commit`; empty in older files.
        runs: names of the runs.
        axes: by name, what sets runs apart, (R,); not a number, or empty, where a run has no value of an axis.
        columns: by name, what became of each run, (R,): `seed`, `evaluated`, `best_cost`, `ended`, and `best_params`
            (R, P) and `best_terms` (R, T), if all runs have the same; of trainings `iterations`, `gain` and others.
        labels: names along `parameter` and `term`.
        parameter_units: (P,).
    """

    path: Path
    name: str
    text: str
    command: str
    origin: Mapping[str, str]
    runs: tuple[str, ...]
    axes: Mapping[str, SweepColumn]
    columns: Mapping[str, SweepColumn]
    labels: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    parameter_units: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Number of runs."""
        return len(self.runs)

    def run(self, name: str) -> Result:
        """One run with its candidates and its motion; raises ResultError if there is none of this name."""
        return read_result(self.path, as_text(name, "name", error=ResultError))

    @property
    def best(self) -> str | None:
        """Name of the run with the lowest cost, or of the training with the highest return; None if there is none."""
        sign, name = (-1.0, "gain") if "gain" in self.columns else (1.0, "best_cost")
        costs = sign * self.columns[name].values
        costs = np.where(np.isnan(costs), np.inf, costs)
        return self.runs[int(np.argmin(costs))] if len(costs) and np.isfinite(costs.min()) else None

    def to_dataframe(self, candidates: bool = False) -> pandas.DataFrame:
        """A `pandas.DataFrame` with one row per run: its name, axes, outcome and best candidate.

        Parameters are columns by their path in the scene, terms `term.` and their name.

        Args:
            candidates: a row a candidate instead, of all runs, with the name of its run and the axes.

        Raises:
            Error: pandas is not installed. ResultError: the runs are trainings, which have no candidates.
        """
        package = imported("pandas")
        if not as_truth(candidates, "candidates"):
            table = {name: axis.values for name, axis in self._named_axes().items()}
            return package.DataFrame(table | self._flat(self.columns), index=package.Index(self.runs, name="run"))
        columns = self.candidates()
        row = columns.pop("run").values
        table = {"run": np.array(self.runs, dtype=object)[row]}
        table |= {name: axis.values[row] for name, axis in self._named_axes().items()}
        index = package.RangeIndex(len(row), name="candidate")
        return package.DataFrame(table | self._flat(columns), index=index)

    def to_xarray(self, candidates: bool = False) -> xarray.Dataset:
        """An `xarray.Dataset` whose dimensions are the axes, if the runs are all combinations of their values.

        Otherwise its dimension is `run`, and axes are coordinates along it. Best candidates have `parameter` and
        `term` besides. Numbers have their units as attributes.

        Args:
            candidates: over `candidate` instead, those of all runs, with runs and axes as coordinates.

        Raises:
            Error: xarray is not installed. ResultError: the runs are trainings, which have no candidates.
        """
        package = imported("xarray")
        axes = self._named_axes()
        if as_truth(candidates, "candidates"):
            columns = self.candidates()
            row = columns.pop("run").values
            coords: dict[str, Any] = {"candidate": np.arange(len(row)), "run": ("candidate", np.array(self.runs)[row])}
            coords |= {name: ("candidate", axis.values[row], axis.attributes) for name, axis in axes.items()}
            return self._dataset(package, columns, ("candidate",), (len(row),), coords, np.arange(len(row)))
        columns = {name: column for name, column in self.columns.items() if name not in axes}
        places = self._places(axes)
        if places is None:
            coords = {"run": ("run", np.array(self.runs, dtype=str))}
            coords |= {name: ("run", axis.values, axis.attributes) for name, axis in axes.items()}
            return self._dataset(package, columns, ("run",), (len(self),), coords, np.arange(len(self)))
        steps, order = places
        coords = {name: (name, values, axes[name].attributes) for name, values in steps.items()}
        columns["run"] = SweepColumn(np.array(self.runs, dtype=str), "", "name of the run")
        shape = tuple(map(len, steps.values()))
        return self._dataset(package, columns, tuple(steps), shape, coords, order)

    def candidates(self) -> dict[str, SweepColumn]:
        """The candidates of all runs, read now: `run` (N,), row of the run, `status` in words, `cost` and so on.

        Raises:
            ResultError: the file cannot be read, or the runs are trainings.
        """
        with opened_sweep(self.path) as file:
            found = candidates_of(file, self.runs)
        if not found:
            raise ResultError(f"{self.path}: no candidates; each run has a policy, as `run(NAME).learned`")
        status = found["status"]
        found["status"] = SweepColumn(np.array(words(status.values), dtype=str), "", status.description)
        return found

    def __repr__(self) -> str:
        described = "".join(f", {name} {text}" for name, text in self._facts() if name not in ("sweep", "runs"))
        return f"Sweep({self.name!r}, {number_of(len(self), 'run')}{described})"

    def _repr_html_(self) -> str:
        names = [name for name in self.columns if self.columns[name].values.ndim == 1]
        axes = self._named_axes()
        shown = [*axes.values(), *(self.columns[name] for name in names)]
        rows = [[run, *(_shown(column.values[row]) for column in shown)] for row, run in enumerate(self.runs[:SHOWN])]
        more = "" if len(self) <= SHOWN else f"<p>and {len(self) - SHOWN} more: to_dataframe(), to_xarray()</p>"
        return html_table(("", ""), self._facts()) + html_table(["run", *axes, *names], rows) + more

    def _facts(self) -> list[tuple[str, str]]:
        """What is said of the sweep, by name."""
        facts = [("sweep", self.name), ("runs", str(len(self)))]
        steps = {name: len(dict.fromkeys(map(str, axis.values.tolist()))) for name, axis in self._named_axes().items()}
        if steps:
            facts.append(("over", ", ".join(f"{name} ({number})" for name, number in steps.items())))
        if "evaluated" in self.columns:
            facts.append(("candidates", str(int(self.columns["evaluated"].values.sum()))))
        if (best := self.best) is not None:
            name, word = ("gain", "best return") if "gain" in self.columns else ("best_cost", "best cost")
            facts.append((word, f"{self.columns[name].values[self.runs.index(best)]:.6g} of {best}"))
        return facts

    def _named_axes(self) -> dict[str, SweepColumn]:
        """The axes by names that no column of a table has."""
        taken = {"run", "candidate", "parameter", "term", "parameter_unit", *self.columns} - {"seed"}
        return {f"{ENTRY if name == 'run' else f'axis_{name}'}" if name in taken else name: axis
                for name, axis in self.axes.items()}  # fmt: skip

    def _flat(self, columns: Mapping[str, SweepColumn]) -> dict[str, NDArray[Any]]:
        """Columns as those of a data frame, one for each parameter and term."""
        axes, found = self._named_axes(), {}
        for name, column in columns.items():
            axis = (BEST | CANDIDATES).get(name)
            if axis is None:
                if name not in axes:
                    found[name] = column.values
                continue
            names = self.labels[axis] if axis == "parameter" else [f"term.{term}" for term in self.labels[axis]]
            found |= dict(zip(names, column.values.T, strict=True))
        return found

    def _places(self, axes: Mapping[str, SweepColumn]) -> tuple[dict[str, NDArray[Any]], NDArray[np.intp]] | None:
        """Values of each axis and the row of each combination, if every combination of them has one run."""
        steps = {name: list(dict.fromkeys(axis.values.tolist())) for name, axis in axes.items()}
        if not axes or math.prod(map(len, steps.values())) != len(self):
            return None
        rows = {key: row for row, key in enumerate(zip(*(axis.values.tolist() for axis in axes.values()), strict=True))}
        if len(rows) != len(self):
            return None
        if any(isinstance(value, float) and math.isnan(value) for values in steps.values() for value in values):
            return None
        order = np.array([rows[key] for key in itertools.product(*steps.values())], dtype=np.intp)
        return {name: np.array(values) for name, values in steps.items()}, order

    def _dataset(
        self, package: Any, columns: Mapping[str, SweepColumn], dims: tuple[str, ...], shape: tuple[int, ...],
        coords: dict[str, Any], order: NDArray[Any],
    ) -> xarray.Dataset:  # fmt: skip
        """Columns over these dimensions, whose rows stand in this order."""
        variables = {}
        for name, column in columns.items():
            values = column.values.astype(str) if column.values.dtype.kind == "O" else column.values
            axis = (BEST | CANDIDATES).get(name)
            more = () if axis is None else (axis,)
            variables[name] = ((*dims, *more), values[order].reshape(*shape, *values.shape[1:]), column.attributes)
            if axis is not None:
                coords[axis] = (axis, np.array(self.labels[axis], dtype=str))
                if axis == "parameter":
                    coords["parameter_unit"] = (axis, np.array(self.parameter_units, dtype=str))
        attributes = {"name": self.name, "command": self.command, **self.origin}
        return package.Dataset(variables, coords, attributes)


@overload
def read(path: str | Path, run: str, *, replay: int | None = None) -> Result: ...
@overload
def read(path: str | Path, run: None = None, *, replay: int | None = None) -> Result | Any: ...
def read(path: str | Path, run: str | None = None, *, replay: int | None = None) -> Result | Any:
    """Read a result file: a `Result`, or a `Sweep` where it is that of a sweep.

    Args:
        run: its name, for one run of a sweep, which is a `Result`.
        replay: number of the one motion whose frames are read, the others have none then; all are read by default.

    Raises:
        ResultError: no such file, not a result file, damaged, written by a newer version of the format, or without such
            a run.
    """
    file = as_path(path, "path", error=ResultError)
    if run is None and replay is None and is_sweep(file):
        return read_sweep(file)
    return read_result(file, run, replay=replay)


def is_sweep(path: Path) -> bool:
    """Whether a file is that of a sweep; raises ResultError if it cannot be read."""
    with opened_file(path) as file:
        return bool(file.attrs.get("format") == SWEEP_FORMAT)


def sweep_name(path: Path) -> str:
    """Name of the sweep that a file is of; raises ResultError if it is none, or cannot be read."""
    with opened_sweep(path) as file:
        return str(hdf5.attribute(file, "name"))


def read_sweep(path: Path) -> Sweep:
    """The table of a sweep, whose runs and candidates are read when they are asked for.

    Raises:
        ResultError: the file cannot be read, or is not that of a sweep.
    """
    with opened_sweep(path) as file:
        table = hdf5.member(file, "table")
        runs = texts(table, "run")
        beside = ("run", "parameter", "parameter_unit", "term")
        kept = {name: column_of(table, name) for name in datasets(table) if name not in beside}
        axes = hdf5.member(table, "axes")
        labels = {axis: texts(table, axis) for axis in BEST.values() if axis in table}
        units = texts(table, "parameter_unit") if "parameter_unit" in table else ()
        if "parameter" not in labels:
            kept, labels, units = with_best(file, runs, kept)
        for name, column in kept.items():
            check_shape(name, column, runs, labels.get(BEST.get(name, "")))
        known = ("format", "format_version", "name", "command", "ended")
        origin = {name: str(value) for name, value in sorted(file.attrs.items()) if name not in known}
        sets_apart = {name: column_of(axes, name) for name in datasets(axes)}
        return Sweep(
            path, str(hdf5.attribute(file, "name")), hdf5.text(hdf5.member(file, "sweep")),
            str(hdf5.attribute(file, "command")), origin, runs, sets_apart, kept, labels, units,
        )  # fmt: skip


def _shown(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
