"""What the file of a sweep holds, column by column, of this version of the format and of those before."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from warpmuscle.core import hdf5
from warpmuscle.core.errors import ResultError
from warpmuscle.results.result import SWEEP_FORMAT, check_format, opened_file

BEST = {"best_params": "parameter", "best_terms": "term"}  # columns with a second axis, and its name


@dataclass(frozen=True)
class SweepColumn:
    """A column of a table: one number or text a row, or several."""

    values: NDArray[Any]  # (R,), or (R, n)
    units: str = ""
    description: str = ""

    @property
    def attributes(self) -> dict[str, str]:
        """What an `xarray.DataArray` says of it."""
        return {name: text for name, text in (("units", self.units), ("description", self.description)) if text}


@contextlib.contextmanager
def opened_sweep(path: Path) -> Iterator[Any]:
    """The open file of a sweep; raises ResultError for any other."""
    with opened_file(path) as file:
        check_format(path, file)
        if file.attrs["format"] != SWEEP_FORMAT:
            raise ResultError(f"{path}: the file of one optimisation, not of a sweep")
        yield file


def check_shape(name: str, column: SweepColumn, runs: Sequence[str], along: Sequence[str] | None) -> None:
    """Raise ValueError if a column has not a row a run, or not a number for each name."""
    shape = (len(runs),) if name not in BEST else (len(runs), len(along or ()))
    if column.values.shape != shape:
        raise ValueError(f"table/{name} has shape {column.values.shape}, and should have {shape}")


def datasets(group: Any) -> list[str]:
    """Names of the datasets of a group, in order."""
    return [name for name in group if isinstance(hdf5.member(group, name), h5py.Dataset)]


def texts(group: Any, name: str) -> tuple[str, ...]:
    """The texts of a dataset."""
    return hdf5.strings(hdf5.checked(group, name))


def column_of(group: Any, name: str) -> SweepColumn:
    """A dataset with its unit and description."""
    dataset = hdf5.checked(group, name)
    units, description = (str(dataset.attrs.get(key, "")) for key in ("units", "description"))
    values = np.array(hdf5.strings(dataset), dtype=object) if dataset.dtype.kind == "O" else dataset[()]
    return SweepColumn(values, units, description)


def with_best(
    file: Any, runs: Sequence[str], columns: Mapping[str, SweepColumn]
) -> tuple[dict[str, SweepColumn], dict[str, tuple[str, ...]], tuple[str, ...]]:
    """The columns of a table of version 3 and before, with best candidates from the groups of its runs, if alike."""
    groups = [_group(file, run) for run in runs]
    if not groups or any(group is None or "best" not in group or "evaluations" not in group for group in groups):
        return dict(columns), {}, ()
    names = [texts(hdf5.member(group, "parameters"), "name") for group in groups]
    if len(set(names)) > 1:
        return dict(columns), {}, ()
    rows = [hdf5.checked_array(hdf5.member(group, "best"), "params") for group in groups]
    best = SweepColumn(np.array(rows), "see parameter_unit", "parameters of the best candidate")
    units = texts(hdf5.member(groups[0], "parameters"), "unit")
    return {**columns, "best_params": best}, {"parameter": names[0]}, units


def _group(file: Any, run: str) -> Any:
    """A run of a file of version 3 and before; None where it is none."""
    found = hdf5.member(hdf5.member(file, "runs"), run)
    return found if isinstance(found, h5py.Group) else None


def candidates_of(file: Any, runs: Sequence[str]) -> dict[str, SweepColumn]:
    """Columns of `/all`; those of older files are put together from the groups of the runs."""
    if "all" not in file:
        return {}
    whole = hdf5.member(file, "all")
    names = [name for name in datasets(whole) if name not in ("candidate", "parameter", "parameter_unit", "term")]
    if "candidate" in whole:
        return {name: column_of(whole, name) for name in names}
    groups = [hdf5.member(_group(file, run) or {}, "evaluations") for run in runs]
    found = {"run": column_of(whole, "run")} if "run" in names else {}
    for name in names:
        if name != "run" and name != "terms":
            parts = [hdf5.checked_array(group, name) for group in groups]
            attributes = {key: str(whole[name].attrs.get(key, "")) for key in ("units", "description")}
            found[name] = SweepColumn(np.concatenate(parts), **attributes)
    return found
