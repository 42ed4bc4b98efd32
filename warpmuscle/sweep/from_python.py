"""A sweep in one line of Python: of a file, or of a scene with a grid of numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import tomlkit

from warpmuscle.core.arguments import answering, as_path, as_truth, in_words
from warpmuscle.core.errors import ArgumentError, Error
from warpmuscle.core.files import check_output, replace_file
from warpmuscle.core.names import file_name
from warpmuscle.results.sweeps import Sweep
from warpmuscle.results.sweeps import read as read_table
from warpmuscle.simulation.kernel_cache import progress_said
from warpmuscle.sweep.board import SweepProgress, Tell
from warpmuscle.sweep.plan import Plan, read
from warpmuscle.sweep.run import sweep as run


@answering(
    {
        "duration": "set={'duration': 5} changes the scene",
        "candidates": "search={'candidates': 500} is an option of each search",
        "population": "search={'population': 20} is an option of each search",
        "parameters": "grid={'seed': [1, 2]} are numbers by path in the scene, each with its values",
        "values": "grid={'seed': [1, 2]} are numbers by path in the scene, each with its values",
        "seeds": "grid={'seed': [1, 2]} has them",
        "name": "output='sweep.h5' is the file of all results",
    }
)
def sweep(
    file: str | PathLike[str],
    output: str | PathLike[str] | None = None,
    *,
    grid: Mapping[str, Sequence[Any]] | None = None,
    search: Mapping[str, Any] | None = None,
    set: Mapping[str, Any] | None = None,
    device: str | None = None,
    threads: int | None = None,
    progress: Tell | None = None,
    trust: bool = False,
) -> Sweep:
    """Run all optimisations of a sweep, or those not yet finished, and return the table of their results.

    Args:
        file: a sweep file; or, with `grid`, a scene's name or file. output: HDF5 file of all results, by default the
            sweep's name and .h5; with `grid` the sweep file is written beside it.
        grid: numbers by path in the scene, of which every combination is a run, such as `{"seed": [1, 2]}`.
        search: options of each search, such as `{"candidates": 500}`. set: what all runs change in the scene.
        device, threads: as of `Rollout`. progress: is told several times a second. trust: as of `load`.

    Raises:
        Error: the sweep cannot be used or has changed since it began, a file cannot be written, or runs have failed.
    """
    source, trust = as_path(file, "file"), as_truth(trust, "trust")
    if isinstance(output, Mapping):
        raise ArgumentError("numbers to be varied are grid={'seed': [1, 2]}; output is the path of a file")
    target = None if output is None else as_path(output, "output")
    if grid is None:
        if search is not None or set is not None:
            raise ArgumentError(f"{'search' if search is not None else 'set'} needs a grid; a sweep file says its own")
        if not source.suffix and not source.exists():
            raise ArgumentError(f"{source} is not a sweep file; a scene takes a grid, such as grid={{'seed': [1, 2]}}")
        plan = read(source, trust)
    else:
        target = target or Path(f"{file_name(source.stem)}_sweep.h5")
        plan = _written(source, target, {"grid": grid, "search": search or {}, "set": set or {}}, trust)
    target = target or Path(f"{plan.file.stem}.h5")
    with progress_said(progress, "sweeping", SweepProgress.in_words) as tell:
        done = run(plan, target, device=device, threads=threads, progress=tell, trust=trust)
    if done.failed:
        raise Error(f"{target}: {done.failure}")
    table = read_table(target)
    assert isinstance(table, Sweep)
    return table


def _written(scene: Path, output: Path, tables: Mapping[str, Any], trust: bool) -> Plan:
    """The plan of a scene and a grid, whose sweep file lies beside the output; one that says something else stays."""
    name = str(scene.absolute()) if scene.suffix else str(scene)
    for key, table in tables.items():
        if not isinstance(table, Mapping):
            raise ArgumentError(f"{key} takes names with values, not {type(table).__name__}")
    for number, values in tables["grid"].items():
        if isinstance(values, str) or not isinstance(values, Iterable):
            raise ArgumentError(f"grid: {number} must have a list of values, not {in_words(values)}")
    try:
        plain = {key: {name: list(values) if key == "grid" else values for name, values in table.items()}
                 for key, table in tables.items()}  # fmt: skip
        text = tomlkit.dumps({"scene": name, **plain})
    except (TypeError, ValueError, AttributeError) as error:
        raise ArgumentError(f"grid, search and set take numbers, texts and lists of them: {error}") from None
    check_output(output, "a sweep", (".h5", ".hdf5"))
    path = output.with_suffix(".toml")
    there = path.exists()
    if there and path.read_text(encoding="utf-8", errors="replace") != text:
        raise Error(f"{path} is another sweep; give another output, or `wm.sweep({str(path)!r})` runs that one")
    if not there:
        replace_file(path, text)
    try:
        return read(path, trust)
    except Error:
        if not there:
            path.unlink()
        raise
