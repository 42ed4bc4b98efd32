"""Result files: HDF5 that says what it holds, written whole or not at all.

The layout is a contract with readers in other languages; README of the project tells it to users:

- attributes of `/`: `format`, `format_version`, versions of what produced it, `device`, `command`, `seed`
- `/scene`: TOML text
- `/parameters/{name, unit, min, max, step, value, scale}`: (P,)
- `/evaluations/{params, cost, status, end_time, search, generation, stage}`: (N, P) and (N,); `terms` (N, T),
  `term_names`
- `/best/{params, cost, index}`, and `stage` if the scene has stages: best of the last stage that has any candidates
- `/history/{generation, search, best, median, spread, sigma, asks_crc32, stage}`: (H,), a row for each generation of a
  search
- `/searches`: the options of the optimisation as attributes, `strategy`, `searches`, `restarts`, `candidates`, `ended`,
  and `population`, `sigma`, `until`, `target` where given; `/searches/<k>/...`: what search k knows, such as its mean
- `/stages/<k>` if the scene has stages: the options of stage k as attributes, `name` and `ended` besides, `free`, the
  names of the parameters that it changes, and `best/{params, cost, index}`; the attribute `stage` of `/searches` is the
  number of the last stage begun, whose searches these are
- `/replay/<k>/...`: motion, see `warpmuscle.recording.QUANTITIES`

There are no time stamps, so that the same result gives the same bytes.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from warpmuscle.checks import near
from warpmuscle.errors import ResultError, SceneError
from warpmuscle.formats.files import replace_file
from warpmuscle.recording import INTEGER_QUANTITIES, MUSCLE_QUANTITIES, QUANTITIES, Recording
from warpmuscle.records import (
    COLUMNS,
    PACKAGES,
    Best,
    Evaluations,
    History,
    Options,
    ParameterTable,
    Result,
    Searched,
    Staged,
    installed_versions,
)
from warpmuscle.status import Status

__all__ = [
    "Best", "Evaluations", "History", "Options", "ParameterTable", "Result", "Searched", "Staged", "installed_versions",
    "read", "write",
]  # fmt: skip

FORMAT = "warpmuscle"
SWEEP_FORMAT = "warpmuscle sweep"  # see `warpmuscle.sweep.gather`
FORMAT_VERSION = 1
_COMPRESS_FROM = 4096  # bytes; smaller arrays are stored as they are
_HISTORY = {
    "generation": "number of the generation",
    "search": "number of the search",
    "best": "least cost of that search in that generation",
    "median": "median cost of that search in that generation",
    "spread": "standard deviation of its candidates in the unit cube, root mean square over parameters",
    "sigma": "step size of the search after the generation, in the unit cube; not a number if it has none",
    "asks_crc32": "CRC-32 of its candidates in the unit cube, float64 by rows, to tell a resumed search by",
    "stage": "number of the stage",
}


def write(path: str | Path, result: Result) -> None:
    """Write a result file, replacing a file of that name only once the new one is complete.

    Raises:
        ResultError: the file cannot be written, or a value is not finite; nothing is left behind then.
    """
    try:
        replace_file(Path(path), _image(result))
    except SceneError as error:
        raise ResultError(f"{path}: {error.message}") from None


def read(path: str | Path, run: str | None = None) -> Result:
    """Read a result file, or one run of the file of a sweep.

    Args:
        run: its name, for the file of a sweep only.

    Raises:
        ResultError: no such file, not a result file, damaged, written by a newer version of the format, or without such
            a run.
    """
    with opened(Path(path), run) as group:
        return _load(group)


@contextlib.contextmanager
def opened(path: Path, run: str | None = None) -> Iterator[Any]:
    """The HDF5 group of a result in its open file; see `read`."""
    with _opened_file(path) as file:
        yield _of_run(path, file, run)


def run_names(path: str | Path) -> tuple[str, ...]:
    """Names of the runs in the file of a sweep; none in that of an optimisation. For errors see `read`."""
    with _opened_file(Path(path)) as file:
        _check_format(Path(path), file)
        return tuple(file.get("runs", ()))


@contextlib.contextmanager
def _opened_file(path: Path) -> Iterator[Any]:
    try:
        with h5py.File(path, "r") as file:
            yield file
    except FileNotFoundError:
        raise ResultError(f"{path}: no such file") from None
    except (PermissionError, IsADirectoryError) as error:
        raise ResultError(f"{path}: cannot be read: {error.strerror}") from None
    except OSError:
        raise ResultError(f"{path}: not an HDF5 file, or damaged") from None
    except (KeyError, ValueError, TypeError, AttributeError, RuntimeError) as error:
        raise ResultError(f"{path}: damaged result file: {' '.join(str(error).split())}") from None


def _image(result: Result) -> bytes:
    """The bytes of a result file; made in memory, so that failures of the disk are plain OSErrors of one write."""
    memory = io.BytesIO()
    with h5py.File(memory, "w", track_order=True) as file:  # h5py keeps no times unless asked to
        file.attrs["format"] = FORMAT
        file.attrs["format_version"] = FORMAT_VERSION
        for name in sorted(result.versions):
            file.attrs[f"{name}_version"] = result.versions[name]
        file.attrs["device"], file.attrs["command"], file.attrs["seed"] = result.device, result.command, result.seed
        _put(file, "scene", result.scene, description="the experiment, as TOML")
        _put_parameters(file, result.parameters)
        if result.evaluations is not None:
            _put_evaluations(file, result.evaluations, len(result.parameters.name))
        if result.best is not None:
            _put_best(file, result.best)
            if result.searched is not None and result.searched.stages and result.evaluations is not None:
                stage = np.int64(result.evaluations.stage[result.best.index])
                _put(file["best"], "stage", stage, description="stage that the cost is of; others have other costs")
        if result.searched is not None:
            _put_searched(file, result.searched)
        for number, recording in enumerate(result.replays):
            _put_recording(file.create_group(f"replay/{number}", track_order=True), recording)
    return memory.getvalue()


def _put_parameters(file: Any, parameters: ParameterTable) -> None:
    count = len(parameters.name)
    group = file.create_group("parameters", track_order=True)
    _put(group, "name", parameters.name, axes="parameter", description="path in the scene")
    _put(group, "unit", parameters.unit, axes="parameter", description="unit of value, min, max and step")
    for name, description in {
        "min": "lower bound of the search",
        "max": "upper bound of the search",
        "step": "precision of the search, 0 if continuous",
        "value": "value in the scene of this file",
    }.items():
        array = _shaped(f"parameters/{name}", getattr(parameters, name), (count,))
        _put(group, name, array, axes="parameter", description=description)
    _put(group, "scale", parameters.scale, axes="parameter", description="of the unit interval from min to max")


def _put_evaluations(file: Any, evaluations: Evaluations, parameter_count: int) -> None:
    count = len(evaluations.cost)
    group = file.create_group("evaluations", track_order=True)
    params = _shaped("evaluations/params", evaluations.params, (count, parameter_count))
    _put(group, "params", params, axes="evaluation, parameter", description="candidates, in units of /parameters/unit")
    _put(group, "cost", _shaped("evaluations/cost", evaluations.cost, (count,)), axes="evaluation",
         description="value of the objective")  # fmt: skip
    status = np.asarray(_shaped("evaluations/status", evaluations.status, (count,)), dtype=np.int32)
    _put(group, "status", status, axes="evaluation", description="outcome; see the attributes named after outcomes")
    for member in Status:
        group["status"].attrs[member.name] = int(member)
    _put(group, "end_time", _shaped("evaluations/end_time", evaluations.end_time, (count,)), units="s",
         axes="evaluation", description="simulated time at which the instance ended")  # fmt: skip
    for name, description in {
        "search": "number of the search that asked for it, -1 for the scene as given",
        "generation": "generation in which it was asked for",
        "stage": "stage in which it was asked for; costs of different stages cannot be compared",
    }.items():
        numbers = np.asarray(_shaped(f"evaluations/{name}", getattr(evaluations, name), (count,)), dtype=np.int32)
        _put(group, name, numbers, axes="evaluation", description=description)
    if evaluations.term_names:
        terms = _shaped("evaluations/terms", evaluations.terms, (count, len(evaluations.term_names)))
        _put(group, "terms", terms, axes="evaluation, term", finite=False,
             description="terms of the objective, unweighted; not a number where an instance diverged")  # fmt: skip
        _put(group, "term_names", evaluations.term_names, axes="term", description="terms of the objective")


def _put_best(file: Any, best: Best) -> None:
    group = file.create_group("best", track_order=True)
    _put(group, "params", np.asarray(best.params), axes="parameter", description="in units of /parameters/unit")
    _put(group, "cost", np.float64(best.cost), description="least value of the objective")
    _put(group, "index", np.int64(best.index), description="row of /evaluations")


def _put_searched(file: Any, searched: Searched) -> None:
    count = len(searched.history.generation)
    group = file.create_group("history", track_order=True)
    for name, description in _HISTORY.items():
        array = _shaped(f"history/{name}", getattr(searched.history, name), (count,))
        _put(group, name, array, axes="generation of a search", description=description, finite=name != "sigma")
    group = file.create_group("searches", track_order=True)
    _put_options(group, searched.options)
    group.attrs["ended"] = searched.ended
    if searched.stages:
        group.attrs["stage"] = searched.stage
    for number, state in enumerate(searched.states):
        inner = group.create_group(str(number), track_order=True)
        for name in sorted(state):
            _put(inner, name, state[name], description="state of the search, in the unit cube", finite=False)
    for number, stage in enumerate(searched.stages):
        inner = file.create_group(f"stages/{number}", track_order=True)
        inner.attrs["name"] = stage.name
        _put_options(inner, stage.options)
        inner.attrs["ended"] = stage.ended
        _put(inner, "free", stage.free, axes="dimension of a search", description="parameters that the stage changes")
        if stage.best is not None:
            _put_best(inner, stage.best)


def _put_options(group: Any, options: Options) -> None:
    for field in fields(Options):
        if (value := getattr(options, field.name)) is not None:
            group.attrs[field.name] = value


def _put_recording(group: Any, recording: Recording) -> None:
    _put(group, "joint_names", recording.joint_names, axes="joint", description="joints, breadth first from the root")
    _put(group, "body_names", recording.body_names, axes="body", description="the root, then the joints' children")
    if recording.muscle_names:
        _put(group, "muscle_names", recording.muscle_names, axes="muscle", description="muscles that were simulated")
    for name, quantity in QUANTITIES.items():
        if name in MUSCLE_QUANTITIES and not recording.muscle_names:
            continue
        array = recording[name].astype(np.int32) if name in INTEGER_QUANTITIES else recording[name]
        _put(group, name, array, quantity.units, ", ".join(quantity.axes), quantity.description)


def _put(
    group: Any, name: str, data: Any, units: str = "", axes: str = "", description: str = "", finite: bool = True
) -> None:
    """Store a string, strings, a number or an array, with its attributes.

    Raises:
        ResultError: a number is not finite, though all are to be.
    """
    if isinstance(data, (str, tuple)):
        array: NDArray[Any] = np.asarray(data, dtype=h5py.string_dtype())
    else:
        array = np.asarray(data)
        if finite and not np.isfinite(array).all():
            raise ResultError(f"{group.name.rstrip('/')}/{name} holds a value that is not finite; nothing was written")
    packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True} if array.nbytes >= _COMPRESS_FROM else {}
    dataset = group.create_dataset(name, data=array, **(packed if array.dtype.kind in "fi" else {}))
    for key, text in {"units": units, "axes": axes, "description": description}.items():
        if text:
            dataset.attrs[key] = text


def _shaped(name: str, array: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """The array, if it has this shape; raises ResultError otherwise."""
    if np.shape(array) != shape:
        raise ResultError(f"{name} has shape {np.shape(array)}, not {shape}; nothing was written")
    return array


def _of_run(path: Path, file: Any, run: str | None) -> Any:
    """The group that holds the one result wanted: the file itself, or a run of a sweep."""
    _check_format(path, file)
    if file.attrs["format"] == FORMAT:
        if run is not None:
            raise ResultError(f"{path}: the file of one optimisation, not of a sweep; it has no run {run!r}")
        return file
    names = list(file["runs"])
    if run is None:
        raise ResultError(f"{path}: the file of a sweep of {len(names)} runs; name one of them, such as {names[0]!r}")
    if run not in names:
        raise ResultError(f"{path}: no run is called {run!r}{near(run, names)}; there are {', '.join(names)}")
    return file["runs"][run]


def _check_format(path: Path, file: Any) -> None:
    """Raise ResultError for a file of another kind or of a newer format."""
    if file.attrs.get("format") not in (FORMAT, SWEEP_FORMAT):
        raise ResultError(f"{path}: an HDF5 file, but not one written by warpmuscle")
    found = int(file.attrs["format_version"])
    if found > FORMAT_VERSION:
        raise ResultError(
            f"{path}: format version {found} is newer than {FORMAT_VERSION}, which this warpmuscle reads; update it"
        )


def _load(file: Any) -> Result:
    """The content of an open file; raises KeyError or ValueError where it is incomplete."""
    groups = file.get("replay", {})
    return Result(
        scene=file["scene"].asstr()[()],
        device=str(file.attrs["device"]),
        command=str(file.attrs["command"]),
        seed=int(file.attrs["seed"]),
        parameters=_load_parameters(file["parameters"]),
        evaluations=_load_evaluations(file["evaluations"]) if "evaluations" in file else None,
        best=_load_best(file["best"]) if "best" in file else None,
        replays=tuple(_load_recording(groups[str(number)]) for number in range(len(groups))),
        searched=_load_searched(file) if "searches" in file else None,
        versions={name: str(file.attrs[f"{name}_version"]) for name in ("python", *PACKAGES)},
    )


def _load_parameters(group: Any) -> ParameterTable:
    numbers = {name: group[name][()] for name in ("min", "max", "step", "value")}
    names, units = _strings(group["name"]), _strings(group["unit"])
    scale = _strings(group["scale"]) if "scale" in group else ("linear",) * len(names)  # files of before there was one
    return ParameterTable(names, units, **numbers, scale=scale)


def _load_evaluations(group: Any) -> Evaluations:
    count = len(group["cost"])
    none = np.zeros(count, dtype=np.int32)  # files of before there were searches, generations and stages
    columns: dict[str, Any] = {name: group[name][()] if name in group else none for name in COLUMNS}
    terms = group["terms"][()] if "terms" in group else np.zeros((count, 0))
    names = _strings(group["term_names"]) if "term_names" in group else ()
    return Evaluations(**columns, terms=terms, term_names=names)


def _load_searched(file: Any) -> Searched:
    group, attributes = file["searches"], file["searches"].attrs
    columns: dict[str, Any] = {name: array[()] for name, array in file["history"].items() if name in _HISTORY}
    columns.setdefault("stage", np.zeros(len(columns["generation"]), dtype=np.int64))  # files of before there were any
    states = ({name: array[()] for name, array in group[str(number)].items()} for number in range(len(group)))
    inner = file.get("stages", {})
    stages = tuple(_load_staged(inner[str(number)]) for number in range(len(inner)))
    stage = int(attributes.get("stage", 0))
    ended = str(attributes["ended"])
    return Searched(_load_options(attributes), ended, History(**columns), tuple(states), stages, stage)


def _load_options(attributes: Any) -> Options:
    given = {field.name: attributes[field.name] for field in fields(Options) if field.name in attributes}
    return Options(**{name: value.item() if hasattr(value, "item") else value for name, value in given.items()})


def _load_staged(group: Any) -> Staged:
    best = _load_best(group["best"]) if "best" in group else None
    ended = str(group.attrs["ended"])
    return Staged(str(group.attrs["name"]), _strings(group["free"]), _load_options(group.attrs), ended, best)


def _load_best(group: Any) -> Best:
    return Best(group["params"][()], float(group["cost"][()]), int(group["index"][()]))


def _load_recording(group: Any) -> Recording:
    arrays = {name: group[name][()] for name in QUANTITIES if name in group}
    muscles = _strings(group["muscle_names"]) if "muscle_names" in group else ()
    return Recording.of(arrays, _strings(group["joint_names"]), _strings(group["body_names"]), muscles)


def _strings(dataset: Any) -> tuple[str, ...]:
    return tuple(dataset.asstr()[()])
