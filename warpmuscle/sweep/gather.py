"""The results of a sweep in one HDF5 file, written whole or not at all.

- attributes of `/`: `format` ("warpmuscle sweep"), `format_version`, `name`, `command`
- `/sweep`: the sweep file, TOML text
- `/runs/<name>/...`: each run, all that its result file has (see `warpmuscle.results.result`)
- `/table/{run, seed, evaluated, best_cost, ended}`: (R,), a row a run; `/table/axes/<axis>`: (R,), what sets it apart;
  not a number, or empty, where a run has no value of an axis
- `/all/{cost, status, end_time, search, generation, stage}`: (N,), the candidates of all runs one behind the other;
  `params` and `terms` (N, ...) if all runs have the same. Virtual datasets: they show what stands in `/runs`, and take
  no room.
- `/all/run`: (N,), row of `/table`
"""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from warpmuscle.core.errors import ResultError, SceneError
from warpmuscle.core.files import replace_file
from warpmuscle.core.hdf5_writing import store
from warpmuscle.results.layout import FORMAT_VERSION
from warpmuscle.results.records import COLUMNS
from warpmuscle.results.result import SWEEP_FORMAT, opened
from warpmuscle.sweep.folder import Folder, Manifest, RunEntry

TABLE = {
    "run": "name of the run",
    "seed": "its seed",
    "evaluated": "candidates that it has evaluated",
    "best_cost": "least value of its objective, infinite if there is none yet",
    "ended": "why its search has ended",
}
DESCRIPTIONS = {
    "params": "candidates of all runs",
    "cost": "value of the objective",
    "status": "outcome; see the attributes named after outcomes",
    "end_time": "simulated time at which the instance ended",
    "search": "number of the search that asked for it, -1 for the scene as given",
    "generation": "generation in which it was asked for",
    "stage": "stage in which it was asked for; costs of different stages cannot be compared",
    "terms": "terms of the objective, unweighted",
}


def gather(folder: Folder, manifest: Manifest, output: Path, command: str) -> int:
    """Write what all runs of a sweep have come to into one file.

    Returns:
        How many runs it has: those that have evaluated anything.

    Raises:
        ResultError: a file cannot be read or written; nothing is left behind then.
    """
    states = {state.name: state for state in folder.states(manifest)}
    entries = [entry for entry in manifest.runs if states[entry.name].evaluated > 0]
    try:
        replace_file(output, _image(folder, manifest, entries, command))
    except SceneError as error:
        raise ResultError(f"{error}; the runs are in {folder.path}, and the same command goes on") from None
    return len(entries)


def _image(folder: Folder, manifest: Manifest, entries: Sequence[RunEntry], command: str) -> bytes:
    """The bytes of the file; made in memory, so that failures of the disk are plain errors of one write."""
    memory = io.BytesIO()
    with h5py.File(memory, "w", track_order=True) as file:
        runs = put_runs(file, folder, manifest, entries, command)
        _put_table(file, entries, [runs[entry.name] for entry in entries])
        _put_all(file, [runs[entry.name] for entry in entries])
    return memory.getvalue()


def put_runs(file: Any, folder: Folder, manifest: Manifest, entries: Sequence[RunEntry], command: str) -> Any:
    """Put what all gathered files have, and copies of the runs' own files; the group of these.

    Raises:
        ResultError: one of them cannot be read.
    """
    file.attrs["format"], file.attrs["format_version"] = SWEEP_FORMAT, FORMAT_VERSION
    file.attrs["name"], file.attrs["command"] = manifest.name, command
    store(file, "sweep", manifest.text, description="the sweep, as TOML")
    runs = file.create_group("runs", track_order=True)
    for entry in entries:
        try:
            with opened(folder.result(entry.name)) as source:
                source.copy(source["/"], runs, name=entry.name)
        except ResultError as error:
            raise ResultError(f"{error}; remove it, and it is computed anew") from None
    return runs


def _put_table(file: Any, entries: Sequence[RunEntry], runs: Sequence[Any]) -> None:
    costs = [run["evaluations/cost"][()] for run in runs]
    table = file.create_group("table", track_order=True)
    columns: dict[str, Any] = {
        "run": [entry.name for entry in entries],
        "seed": np.array([entry.seed for entry in entries], dtype=np.int64),
        "evaluated": np.array([len(cost) for cost in costs], dtype=np.int64),
        "best_cost": np.array([run["best/cost"][()] if "best" in run else np.inf for run in runs]),
        "ended": [str(run["searches"].attrs["ended"]) for run in runs],
    }
    for name, values in columns.items():
        put_column(table, name, values, TABLE[name])
    put_axes(table, entries)


def put_axes(table: Any, entries: Sequence[RunEntry]) -> None:
    """Put what sets runs apart."""
    axes = table.create_group("axes", track_order=True)
    for name in dict.fromkeys(name for entry in entries for name in entry.axes):
        numeric = all(isinstance(entry.axes.get(name, 0.0), int | float) for entry in entries)
        values = [entry.axes.get(name, np.nan if numeric else "") for entry in entries]
        put_column(axes, _dataset_name(name), np.array(values, dtype=float) if numeric else list(map(str, values)),
                   f"value of the axis {name}; not a number, or empty, where a run has none")  # fmt: skip


def _dataset_name(axis: str) -> str:
    """The name of an axis as HDF5 may have it."""
    return re.sub(r"[/\0]|^\.+$", "_", axis)


def put_column(group: Any, name: str, values: Any, description: str, units: str = "") -> None:
    """Put a column of the table, (R,) numbers or texts."""
    values = tuple(values) if isinstance(values, list) else values
    store(group, name, values, units, "run", description=description, finite=False)


def _put_all(file: Any, runs: Sequence[Any]) -> None:
    """The candidates of all runs as virtual datasets."""
    group = file.create_group("all", track_order=True)
    if not runs:
        return
    names = [name for name in (*COLUMNS, "terms") if _is_common(runs, name)]
    counts = [len(run["evaluations/cost"]) for run in runs]
    for name in names:
        dataset = _joined(group, name, [run[f"evaluations/{name}"] for run in runs])
        first = runs[0][f"evaluations/{name}"].attrs
        dataset.attrs["units"], dataset.attrs["axes"] = first.get("units", "1"), first.get("axes", "evaluation")
        dataset.attrs["description"] = DESCRIPTIONS[name]
        if name == "status":
            outcomes = runs[0]["evaluations/status"].attrs
            for outcome in list(outcomes):
                dataset.attrs[outcome] = dataset.attrs.get(outcome, outcomes[outcome])
    number = np.repeat(np.arange(len(runs), dtype=np.int32), counts)
    store(group, "run", number, axes="evaluation", description="row of /table")


def _joined(group: Any, name: str, sources: Sequence[Any]) -> Any:
    """A virtual dataset that shows datasets of the same file one behind the other.

    Made by the functions below `create_virtual_dataset`, which puts a time stamp into the file.
    """
    shape = (sum(map(len, sources)), *sources[0].shape[1:])
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_obj_track_times(False)
    begin = 0
    for source in sources:
        if len(source) > 0:
            space = h5py.h5s.create_simple(shape)
            space.select_hyperslab((begin, *(0 for _ in shape[1:])), source.shape)
            properties.set_virtual(space, b".", source.name.encode(), source.id.get_space())
            begin += len(source)
    space, kind = h5py.h5s.create_simple(shape), sources[0].id.get_type()
    return h5py.Dataset(h5py.h5d.create(group.id, name.encode(), kind, space, properties))


def _is_common(runs: Sequence[Any], name: str) -> bool:
    """Whether a column means the same in all runs."""
    labels = {"params": "parameters/name", "terms": "evaluations/term_names"}.get(name)
    if any(name not in run["evaluations"] for run in runs):
        return False
    return labels is None or len({tuple(run[labels].asstr()[()]) for run in runs}) == 1
