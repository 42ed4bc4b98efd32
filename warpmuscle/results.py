"""Result files: HDF5 that says what it holds, written whole or not at all.

The layout is a contract with readers in other languages; README of the project tells it to users:
`/scene` (TOML text), `/parameters`, `/evaluations`, `/best`, `/replay/<k>`, and what produced it as attributes of the
root. There are no time stamps, so that the same result gives the same bytes.
"""

from __future__ import annotations

import io
import platform
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from warpmuscle.errors import ResultError, SceneError
from warpmuscle.formats.files import replace_file
from warpmuscle.recording import INTEGER_QUANTITIES, MUSCLE_QUANTITIES, QUANTITIES, Floats, Integers, Recording
from warpmuscle.status import Status

FORMAT = "warpmuscle"
FORMAT_VERSION = 1
_COMPRESS_FROM = 4096  # bytes; smaller arrays are stored as they are
_PACKAGES = {"warpmuscle": "warpmuscle", "warp": "warp-lang", "numpy": "numpy", "h5py": "h5py"}


def installed_versions() -> dict[str, str]:
    """Versions of what produces a result here, by name; "unknown" for a package without metadata."""
    found = {"python": platform.python_version()}
    for name, package in _PACKAGES.items():
        try:
            found[name] = version(package)
        except PackageNotFoundError:
            found[name] = "unknown"
    return found


@dataclass(frozen=True)
class ParameterTable:
    """The free parameters of a scene: P dimensions of a search."""

    name: tuple[str, ...]  # path in the scene
    unit: tuple[str, ...]
    min: Floats  # (P,)
    max: Floats  # (P,)
    step: Floats  # (P,), 0 means continuous
    value: Floats  # (P,), of the scene as stored in the same file


@dataclass(frozen=True)
class Evaluations:
    """N candidates in the order in which they were evaluated."""

    params: Floats  # (N, P)
    cost: Floats  # (N,)
    status: Integers  # (N,), numbers of `Status`
    end_time: Floats  # (N,), s, simulated time at which the instance ended


@dataclass(frozen=True)
class Best:
    """The candidate of least cost."""

    params: Floats  # (P,)
    cost: float
    index: int  # row of the evaluations


@dataclass(frozen=True)
class Result:
    """All that a run leaves behind; evaluations and best are None for a run that searched nothing."""

    scene: str  # TOML text
    device: str
    command: str
    seed: int
    parameters: ParameterTable
    evaluations: Evaluations | None = None
    best: Best | None = None
    replays: tuple[Recording, ...] = ()
    versions: Mapping[str, str] = field(default_factory=installed_versions)


def write(path: str | Path, result: Result) -> None:
    """Write a result file, replacing a file of that name only once the new one is complete.

    Raises:
        ResultError: the file cannot be written, or a value is not finite; nothing is left behind then.
    """
    try:
        replace_file(Path(path), _image(result))
    except SceneError as error:
        raise ResultError(f"{path}: {error.message}") from None


def read(path: str | Path) -> Result:
    """Read a result file.

    Raises:
        ResultError: no such file, not a result file, damaged, or written by a newer version of the format.
    """
    path = Path(path)
    try:
        with h5py.File(path, "r") as file:
            _check_format(path, file)
            return _load(file)
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


def _put_best(file: Any, best: Best) -> None:
    group = file.create_group("best", track_order=True)
    _put(group, "params", np.asarray(best.params), axes="parameter", description="in units of /parameters/unit")
    _put(group, "cost", np.float64(best.cost), description="least value of the objective")
    _put(group, "index", np.int64(best.index), description="row of /evaluations")


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


def _put(group: Any, name: str, data: Any, units: str = "", axes: str = "", description: str = "") -> None:
    """Store a string, strings, a number or an array, with its attributes.

    Raises:
        ResultError: a number is not finite.
    """
    if isinstance(data, (str, tuple)):
        array: NDArray[Any] = np.asarray(data, dtype=h5py.string_dtype())
    else:
        array = np.asarray(data)
        if not np.isfinite(array).all():
            raise ResultError(f"{group.name.rstrip('/')}/{name} holds a value that is not finite; nothing was written")
    packed = {"compression": "gzip", "compression_opts": 4, "shuffle": True} if array.nbytes >= _COMPRESS_FROM else {}
    dataset = group.create_dataset(name, data=array, **(packed if array.dtype.kind in "fi" else {}))
    for key, text in {"units": units, "axes": axes, "description": description}.items():
        if text:
            dataset.attrs[key] = text


def _shaped(name: str, array: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """The array, if it has this shape; raises ResultError otherwise."""
    if np.shape(array) != shape:
        raise ResultError(f"{name} has shape {np.shape(array)}, not {shape}; nothing was written")
    return array


def _check_format(path: Path, file: Any) -> None:
    """Raise ResultError for a file of another kind or of a newer format."""
    if file.attrs.get("format") != FORMAT:
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
        versions={name: str(file.attrs[f"{name}_version"]) for name in ("python", *_PACKAGES)},
    )


def _load_parameters(group: Any) -> ParameterTable:
    numbers = {name: group[name][()] for name in ("min", "max", "step", "value")}
    return ParameterTable(_strings(group["name"]), _strings(group["unit"]), **numbers)


def _load_evaluations(group: Any) -> Evaluations:
    return Evaluations(group["params"][()], group["cost"][()], group["status"][()], group["end_time"][()])


def _load_best(group: Any) -> Best:
    return Best(group["params"][()], float(group["cost"][()]), int(group["index"][()]))


def _load_recording(group: Any) -> Recording:
    arrays = {name: group[name][()] for name in QUANTITIES if name in group}
    muscles = _strings(group["muscle_names"]) if "muscle_names" in group else ()
    return Recording.of(arrays, _strings(group["joint_names"]), _strings(group["body_names"]), muscles)


def _strings(dataset: Any) -> tuple[str, ...]:
    return tuple(dataset.asstr()[()])
