"""Trainings of a sweep, one after the other: each goes on from where its files say. They need PyTorch.

The file that gathers them has

- attributes of `/`, `/sweep` and `/runs/<name>` as other sweeps, see `gather.py`
- `/table/{run, seed, iterations, decisions, wall_time, gain, completed, speed, ended}`: (R,), a row a run, of its last
  iteration; `/table/axes/<axis>`: (R,), what sets it apart
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warpmuscle.core.errors import Error, ResultError
from warpmuscle.learning.options import options_of
from warpmuscle.optimization.search_loop import INTERRUPTED
from warpmuscle.results.learned import CURVE, Learned
from warpmuscle.results.result import read_learned
from warpmuscle.results.training_file import training_path
from warpmuscle.sweep.folder import Folder, Manifest, RunEntry, RunState
from warpmuscle.sweep.gather import attach_runs, put_axes, put_bytes, put_column, writing
from warpmuscle.sweep.plan import Plan
from warpmuscle.sweep.plan.runs import SweepRun

if TYPE_CHECKING:
    from warpmuscle.learning.progress import TrainingProgress

COLUMNS = ("decisions", "wall_time", "gain", "completed", "speed")  # of the table, from learning curves

Tell = Callable[[str, "TrainingProgress"], None]  # name of the run, and how far it has come


def run_trainings(
    plan: Plan, folder: Folder, device: str | None, threads: int | None, command: str, tell: Tell | None
) -> dict[str, str]:
    """Train what has not finished.

    Returns:
        Why those that failed did, by name.

    Raises:
        KeyboardInterrupt: after the one that went on was interrupted and kept. Error: PyTorch is missing.
    """
    failed = {}
    for run in plan.runs:
        path = folder.result(run.name)
        if _ended(path):
            continue
        try:
            ended = _train(run, path, device, threads, command, tell)
        except Error as error:
            failed[run.name] = str(error)
            continue
        if ended == INTERRUPTED:
            raise KeyboardInterrupt
    return failed


def _train(run: SweepRun, path: Path, device: str | None, threads: int | None, command: str, tell: Tell | None) -> str:
    """Begin a training, or go on with it; why it ended."""
    from warpmuscle.learning.training import learn, resume, usual_instances

    def report(progress: TrainingProgress) -> None:
        if tell is not None:
            tell(run.name, progress)

    plan = run.training
    assert plan is not None
    ends: dict[str, Any] = {"iterations": plan.iterations, "until": plan.until, "target": plan.target}
    if training_path(path).exists():
        trained = resume(path, device=device, threads=threads, progress=report, **ends)
    else:
        options = options_of({"instances": usual_instances(device)} | dict(plan.options))
        trained = learn(
            run.scene, path, options=options, seed=run.seed, device=device, threads=threads, command=command,
            progress=report, **ends,
        )  # fmt: skip
    assert trained.result.learned is not None
    return trained.result.learned.ended


def _learned(path: Path) -> Learned | None:
    """What a run has learnt; None if it has not begun, or its file cannot be read."""
    try:
        return read_learned(path) if path.exists() else None
    except ResultError:
        return None


def _ended(path: Path) -> bool:
    learned = _learned(path)
    return learned is not None and _is_over(learned)


def _is_over(learned: Learned) -> bool:
    return learned.ended not in ("", INTERRUPTED)


def training_state(path: Path, entry: RunEntry) -> RunState:
    """What a training has come to: its iterations count as candidates, less its return as cost."""
    learned = _learned(path)
    if learned is None:
        return RunState(entry.name, False, "", 0, entry.candidates, np.inf)
    done = len(learned.curve["iteration"])
    best = -float(learned.curve["gain"][-1]) if done else np.inf
    ended = learned.ended if learned.ended != INTERRUPTED else ""
    return RunState(entry.name, True, ended, done, entry.candidates, best)


def gather_trainings(folder: Folder, manifest: Manifest, output: Path, command: str) -> int:
    """Write what all runs of a sweep have learnt into one file.

    Returns:
        How many runs it has: those that have begun.

    Raises:
        ResultError: a file cannot be read or written; nothing is left behind then.
    """
    every = [(entry, _learned(folder.result(entry.name))) for entry in manifest.runs]
    begun = [(entry, learned) for entry, learned in every if learned is not None]
    entries = [entry for entry, _ in begun]
    whole = len(begun) == len(every) and all(_is_over(learned) for _, learned in begun)
    with writing(folder, manifest, output, command, whole) as file:
        runs = file.create_group("runs", track_order=True)
        for entry in entries:
            put_bytes(folder.result(entry.name), runs, entry.name)
        _put_table(file, entries, [learned for _, learned in begun])
    return len(entries)


def _put_table(file: Any, entries: Sequence[RunEntry], found: Sequence[Learned]) -> None:
    table = file.create_group("table", track_order=True)
    put_column(table, "run", [entry.name for entry in entries], "name of the run")
    put_column(table, "seed", np.array([entry.seed for entry in entries], dtype=np.int64), "its seed")
    iterations = np.array([len(one.curve["iteration"]) for one in found], dtype=np.int64)
    put_column(table, "iterations", iterations, "iterations that it has learnt for")
    for name in COLUMNS:
        last = [float(one.curve[name][-1]) if len(one.curve[name]) else np.nan for one in found]
        put_column(table, name, np.array(last), f"{CURVE[name].description}, at its end", CURVE[name].unit)
    put_column(table, "ended", [one.ended for one in found], "why its training has ended")
    put_axes(table, entries)
    attach_runs(table)
