"""Result files: HDF5 that says what it holds, written whole or not at all.

The layout is a contract with readers in other languages; `docs/reference/files.md.in` tells it to users:

- attributes of `/`: `format`, `format_version`, versions of what produced it, `processor`, `blas`, `device`, `command`,
  `seed`
- `/scene`: TOML text
- `/parameters/{name, unit, min, max, step, value, scale}`: (P,)
- `/evaluations/{params, cost, status, end_time, search, generation, stage}`: (N, P) and (N,); `terms` (N, T),
  `term_names`
- `/best/{params, cost, index}`, and `stage` if the scene has stages: best of the last stage that has any candidates;
  `/best/parts/<term>/{name, value}`: what joints and muscles add to a term in its motion
- `/history/{generation, search, best, median, spread, sigma, asks_crc32, stage}`: (H,), a row for each generation of a
  search
- `/searches`: the options of the optimisation as attributes, `strategy`, `searches`, `restarts`, `candidates`, `ended`,
  and `population`, `sigma`, `until`, `target` where given, `elsewhere` of one that went on on another machine,
  `evaluated`, candidates in all, where `/evaluations` has only the first and the best;
  `/searches/<k>/...`: what search k knows, such as its mean
- `/stages/<k>` if the scene has stages: the options of stage k as attributes, `name` and `ended` besides, `free`, the
  names of the parameters that it changes, and `best/{params, cost, index}`; the attribute `stage` of `/searches` is the
  number of the last stage begun, whose searches these are
- `/policy/{task, observation, action, mean, deviation}`, `/policy/layers/<k>/{weight, bias}`, and the attributes
  `widest` and `activation` of `/policy`, if a policy drives the scene: see `learned.PolicyTable`
- `/gait/{coordinate, up, landings}`, and the attributes `scene`, `right` and `cycle_time` of `/gait`, if the policy
  imitates the gait of the scene's own controller: see `learned.KeptGait`
- `/critic/...`: the critic, laid out as the policy
- `/curve/{iteration, wall_time, decisions, ...}`: (R,), how the policy was learnt, see `learned.CURVE`
- `/training`: the options of the training as attributes, `ended`
- `/training/ancestors/{file, seed, decisions, command}`: (A,), what the policy was learnt from, nearest first
- `/replay/<k>/...`: motion, see `recorded_quantities.QUANTITIES`; `name` is an attribute if there are several
- `/replay/...` of several motions of one body: arrays (instance, time, ...), see `warpmuscle.results.motion_layout`;
  its attribute `quantities` names those that were kept, if not all were

Files of `warpmuscle throw` and `warpmuscle inverse` have `/scene`, `/parameters` and `/replay` as well, besides groups
of their own.

There are no time stamps, so that the same result gives the same bytes.
"""

from __future__ import annotations

import contextlib
import io
import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np

from warpmuscle.core import hdf5
from warpmuscle.core.arguments import as_integer, as_kind, as_path, as_text, as_truth
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ResultError
from warpmuscle.core.files import replace_result
from warpmuscle.core.machine import MACHINE
from warpmuscle.core.plain_text import number_of
from warpmuscle.results.checks import check_column, check_result
from warpmuscle.results.layout import FORMAT, FORMAT_VERSION, HISTORY, put
from warpmuscle.results.learned import Learned, check_learned, load_learned
from warpmuscle.results.motion_layout import load_names, load_recordings
from warpmuscle.results.partial_motion import with_less
from warpmuscle.results.records import (
    COLUMNS,
    PACKAGES,
    Best,
    Evaluations,
    Fit,
    History,
    ParameterTable,
    Result,
    Searched,
    SearchOptions,
    Staged,
)
from warpmuscle.scene.validation.checks import near

SWEEP_FORMAT = "warpmuscle sweep"  # see `warpmuscle.sweep.gather`
SWEEP_VERSION = 4  # of that format
THROW_FORMAT = "warpmuscle throw"  # see `warpmuscle.throw.report`
INVERSE_FORMAT = "warpmuscle inverse"  # see `warpmuscle.inverse.output`


def write(path: str | Path, result: Result, *, quantities: Sequence[str] | None = None, single: bool = False) -> None:
    """Write a result file, replacing a file of that name only once the new one is complete.

    Args:
        quantities: names of those of the motions to keep besides the time, all by default. `read` gives the others as
            arrays without frames.
        single: motions in single precision, which takes half the room; their times stay as they are.

    Raises:
        ArgumentError: an unknown quantity, or one that the motions lack already.
        ResultError: the file cannot be written, or a value is not finite; nothing is left behind then.
    """
    path = as_path(path, "path", error=ResultError)
    as_kind(Result, result, "result", error=ResultError)
    single = as_truth(single, "single")
    if quantities is not None or single:
        result = with_less(result, quantities, single)
    replace_result(path, image(result))


def write_extended(
    path: str | Path,
    result: Result,
    add: Callable[[Any], None],
    *,
    kind: str = FORMAT,
    quantities: Sequence[str] | None = None,
    single: bool = False,
) -> None:
    """Write a result file, as `write` does, with groups of one's own besides.

    Args:
        add: gets the open h5py.File, with the result in it, and adds to it.
        kind: the attribute `format`; `read` reads the kinds that this package writes, and leaves out what was added.

    Raises:
        ResultError: the file cannot be written; nothing is left behind then.
    """
    memory = io.BytesIO()
    with h5py.File(memory, "w", track_order=True) as file:
        put(file, with_less(result, quantities, single), kind)
        add(file)
    replace_result(path, memory.getvalue())


def read(path: str | Path, run: str | None = None, *, replay: int | None = None) -> Result:
    """Read a result file, or one run of the file of a sweep.

    Args:
        run: its name, for the file of a sweep only.
        replay: number of the one motion whose frames are read, the others have none then; all are read by default.

    Raises:
        ResultError: no such file, not a result file, damaged, written by a newer version of the format, or without such
            a run.
    """
    file = as_path(path, "path", error=ResultError)
    if run is not None:
        as_text(run, "run", error=ResultError)
    with opened(file, run) as group:
        result = load(group, None if replay is None else as_integer(replay, "replay", 0))
        check_result(result)
    learned = None if result.learned is None else replace(result.learned, file=str(file))
    return replace(result, file=str(file), learned=learned)


class Glance(NamedTuple):
    """What a result file says of its search at a glance."""

    ended: str  # why
    cost: Floats  # (N,), of the candidates that it holds
    generation: Integers  # (N,)
    stage: Integers  # (N,)
    evaluated: int  # candidates in all


def glance(path: str | Path) -> Glance:
    """How a search has ended, and the costs of its candidates; nothing else is read.

    Raises:
        ResultError: as `read`, or the file holds no search.
    """
    with opened_file(Path(path)) as whole:
        file = _of_run(Path(path), whole, None)
        group = hdf5.member(file, "evaluations")
        columns = [hdf5.checked_array(group, name) for name in ("cost", "generation", "stage")]
        for name, column in zip(("cost", "generation", "stage"), columns, strict=True):
            check_column(name, column, np.size(columns[0]))
        searches = hdf5.member(file, "searches")
        evaluated = hdf5.integer(searches, "evaluated", 0) or np.size(columns[0])
        return Glance(str(hdf5.attribute(searches, "ended")), columns[0], columns[1], columns[2], evaluated)


def read_learned(path: str | Path) -> Learned | None:
    """The policy of a result file and how it was learnt, None if it holds none; no motion is read.

    Raises:
        ResultError: as `read`.
    """
    with opened(as_path(path, "path", error=ResultError)) as file:
        if "policy" not in file:
            return None
        learned = load_learned(file)
        check_learned(learned)
        return replace(learned, file=str(path))


def image(result: Result) -> bytes:
    """The bytes of a result file; made in memory, so that failures of the disk are plain OSErrors of one write."""
    with h5py.File("image", "w", driver="core", backing_store=False, track_order=True) as file:  # without any times
        put(file, result)
        file.flush()
        return bytes(file.id.get_file_image())


@contextlib.contextmanager
def opened(path: Path, run: str | None = None) -> Iterator[Any]:
    """The HDF5 group of a result in its open file, all of which is stored there; see `read`."""
    with opened_file(path) as file:
        group = _of_run(path, file, run)
        if isinstance(group, h5py.Group):
            hdf5.check_contents(group)
            yield group
            return
        content = hdf5.checked_array(group.parent, group.name.rpartition("/")[2])
    with _opened_bytes(path, run, content) as inner:
        own = _of_run(path, inner, None)
        hdf5.check_contents(own)
        yield own


def run_names(path: str | Path) -> tuple[str, ...]:
    """Names of the runs in the file of a sweep; none in that of an optimisation. For errors see `read`."""
    with opened_file(Path(path)) as file:
        check_format(Path(path), file)
        return tuple(hdf5.member(file, "runs")) if "runs" in file else ()


def opened_file(path: Path) -> contextlib.AbstractContextManager[Any]:
    """An open HDF5 file, of which nothing has been checked; raises ResultError."""
    return hdf5.opened(path, lambda message: ResultError(f"{path}: {message}"), "damaged result file")


def _opened_bytes(path: Path, run: str | None, content: Any) -> contextlib.AbstractContextManager[Any]:
    """The result file of a run, whose bytes a file of a sweep holds."""
    if not isinstance(content, np.ndarray) or content.dtype != np.uint8 or content.ndim != 1:
        raise ResultError(f"{path}: damaged result file: the run {run!r} is not a file")
    return hdf5.opened_bytes(content.tobytes(), lambda message: ResultError(f"{path}: run {run!r}: {message}"),
                             "damaged result file")  # fmt: skip


def _of_run(path: Path, file: Any, run: str | None) -> Any:
    """What holds the one result wanted: the file itself, or a run of a sweep, a group or the bytes of its file."""
    check_format(path, file)
    if file.attrs["format"] != SWEEP_FORMAT:
        if run is not None:
            raise ResultError(f"{path}: the file of one optimisation, not of a sweep; it has no run {run!r}")
        if "scene" not in file and file.attrs["format"] == INVERSE_FORMAT:
            raise ResultError(f"{path}: trials without their motions; `warpmuscle inverse -o` writes both")
        if "scene" not in file:
            raise ResultError(f"{path}: a fit without its scene and motions; `warpmuscle throw fit -o` writes both")
        return file
    runs = hdf5.member(file, "runs")
    names = list(runs)
    if run is None:
        such = f"; name one of them (--run, or run= in Python), such as {names[0]!r}" if names else ""
        raise ResultError(f"{path}: the file of a sweep of {number_of(len(names), 'run')}{such}")
    if run not in names:
        raise ResultError(f"{path}: no run is called {run!r}{near(run, names)}; there are {', '.join(names)}")
    return hdf5.member(runs, run)


def holds_trials(path: str | Path) -> bool:
    """Whether a file is one of `warpmuscle inverse`, whose motions were recorded rather than simulated.

    Raises:
        ResultError: it cannot be read.
    """
    with opened_file(Path(path)) as file:
        return bool(file.attrs.get("format") == INVERSE_FORMAT)


def check_format(path: Path, file: Any) -> None:
    """Raise ResultError for a file of another kind or of a newer format."""
    if file.attrs.get("format") not in (FORMAT, SWEEP_FORMAT, THROW_FORMAT, INVERSE_FORMAT):
        raise ResultError(f"{path}: an HDF5 file, but not one written by warpmuscle")
    found = hdf5.integer(file, "format_version")
    newest = SWEEP_VERSION if file.attrs["format"] == SWEEP_FORMAT else FORMAT_VERSION
    if found > newest:
        raise ResultError(
            f"{path}: format version {found} is newer than {newest}, which this warpmuscle reads; update it"
        )


def _scene_of(text: str, version: int) -> str:
    """The text of a scene; before version 2 the feedback torque weighed 1 where nothing was said of it."""
    if version >= 2 or not text or "torque" in tomllib.loads(text).get("objective", {}):
        return text
    head = "\n[objective]\n"
    return text.replace(head, f"{head}torque = 1\n", 1) if head in text else f"{text}{head}torque = 1\n"


def load(file: Any, replay: int | None = None) -> Result:
    """The content of an open file, see `read`; raises KeyError or ValueError where it is incomplete."""
    motions = file.get("replay")
    return Result(
        scene=_scene_of(hdf5.text(file["scene"]), hdf5.integer(file.file, "format_version", FORMAT_VERSION)),
        device=str(hdf5.attribute(file, "device")),
        command=str(hdf5.attribute(file, "command")),
        seed=hdf5.integer(file, "seed"),
        parameters=_load_parameters(hdf5.members(file, "parameters")),
        evaluations=_load_evaluations(hdf5.members(file, "evaluations")) if "evaluations" in file else None,
        best=_load_best(hdf5.members(file, "best")) if "best" in file else None,
        parts=_load_parts(file["best/parts"]) if "best/parts" in file else {},
        replays=() if motions is None else load_recordings(motions, replay),
        replay_names=() if motions is None else load_names(motions),
        fit=next((_load_fit(file, name) for name in ("fit", "published") if name in file), None),
        searched=_load_searched(file) if "searches" in file else None,
        learned=load_learned(file) if "policy" in file else None,
        versions={name: str(hdf5.attribute(file, f"{name}_version")) for name in ("python", *PACKAGES)},
        machine={name: str(file.attrs[name]) for name in MACHINE if name in file.attrs},
    )


def _load_parameters(group: Any) -> ParameterTable:
    numbers = {name: hdf5.array(group, name) for name in ("min", "max", "step", "value")}
    names, units = hdf5.strings(group["name"]), hdf5.strings(group["unit"])
    scale = (
        hdf5.strings(group["scale"]) if "scale" in group else ("linear",) * len(names)
    )  # files of before there was one
    return ParameterTable(names, units, **numbers, scale=scale)


def _load_evaluations(group: Any) -> Evaluations:
    count = np.size(hdf5.array(group, "cost"))
    none = np.zeros(count, dtype=np.int32)  # files of before there were searches, generations and stages
    columns: dict[str, Any] = {name: hdf5.array(group, name) if name in group else none for name in COLUMNS}
    terms = hdf5.array(group, "terms") if "terms" in group else np.zeros((count, 0))
    names = hdf5.strings(group["term_names"]) if "term_names" in group else ()
    return Evaluations(**columns, terms=terms, term_names=names)


def _load_searched(file: Any) -> Searched:
    group = hdf5.members(file, "searches")
    attributes, past = group.attrs, hdf5.members(file, "history")
    columns: dict[str, Any] = {name: hdf5.array(past, name) for name in HISTORY if name in past}
    columns.setdefault("stage", np.zeros(len(columns["generation"]), dtype=np.int64))  # files of before there were any
    states = [hdf5.arrays(group[str(number)]) for number in range(len(group))]
    inner = file.get("stages", {})
    stages = tuple(_load_staged(inner[str(number)]) for number in range(len(inner)))
    stage = hdf5.integer(group, "stage", 0)
    ended = str(hdf5.attribute(group, "ended"))
    elsewhere = hdf5.integer(group, "elsewhere", 0)
    evaluated = hdf5.integer(group, "evaluated", 0)
    history = History(**columns)
    return Searched(_load_options(attributes), ended, history, tuple(states), stages, stage, elsewhere, evaluated)


def _load_options(attributes: Any) -> SearchOptions:
    given = {field.name: attributes[field.name] for field in fields(SearchOptions) if field.name in attributes}
    return SearchOptions(**{name: value.item() if hasattr(value, "item") else value for name, value in given.items()})


def _load_staged(group: Any) -> Staged:
    best = _load_best(group["best"]) if "best" in group else None
    ended = str(hdf5.attribute(group, "ended"))
    name, free = str(hdf5.attribute(group, "name")), hdf5.strings(group["free"])
    return Staged(name, free, _load_options(group.attrs), ended, best)


def _load_best(group: Any) -> Best:
    return Best(hdf5.array(group, "params"), float(hdf5.array(group, "cost")), int(hdf5.array(group, "index")))


def _load_parts(group: Any) -> dict[str, dict[str, float]]:
    return {
        str(term): dict(zip(hdf5.strings(inner["name"]), hdf5.array(inner, "value").tolist(), strict=True))
        for term, inner in group.items()
    }


def _load_fit(file: Any, name: str) -> Fit:
    group = file[name]
    r2, seconds = hdf5.array(group, "r2"), hdf5.array(group, "seconds")
    return Fit(hdf5.strings(file["motions/driven"]), hdf5.strings(group["stages"]), r2, seconds)
