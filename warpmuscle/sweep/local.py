"""Runs of a sweep on this machine: each goes on from where its files say, and those that can share batches."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, OccupiedError, ResultError
from warpmuscle.optimization.optimize import optimize
from warpmuscle.optimization.options import MakeBatches
from warpmuscle.optimization.progress import Progress
from warpmuscle.optimization.resume import resume
from warpmuscle.optimization.search_loop import INTERRUPTED
from warpmuscle.results.journal import journal_path
from warpmuscle.results.records import Result
from warpmuscle.results.result import glance
from warpmuscle.sweep.folder import has_ended
from warpmuscle.sweep.lockstep import Finished, Pruning, run_in_lockstep
from warpmuscle.sweep.pruning.rule import Rule
from warpmuscle.sweep.pruning.scheduler import PRUNED
from warpmuscle.sweep.rounds import known_of
from warpmuscle.sweep.shared_batches import run_in_one_batch
from warpmuscle.sweep.task import Task
from warpmuscle.sweep.union import groups

PATIENCE = 20.0  # s, for a process that was killed to let go of its files


Tell = Callable[[str, Progress], None]  # name of the run, empty for a batch of several, and how far it has come


def run_here(
    tasks: Sequence[Task], folder: Path, device: str | None, threads: int | None, tell: Tell | None = None,
    finished: Finished | None = None, rule: Rule | None = None,
) -> dict[str, str]:  # fmt: skip
    """Run optimisations, group by group, the runs of a group side by side; those that have ended stay as they are.

    Args:
        folder: where their result files are.
        device, threads: see `make_rollout`.
        tell: called several times a second of work.
        finished: gets what runs have come to that have ended, except of those that went on from files of their own.
        rule: by which runs that are behind are stopped; by default none is.

    Returns:
        Why those that failed did, by name; what they had evaluated is on the disk.

    Raises:
        KeyboardInterrupt: after all have been interrupted and kept.
    """
    left = [task for task in tasks if not has_ended(folder / f"{task.name}.h5")]
    begun = [task for task in left if task.scene.stages or _has_files(folder / f"{task.name}.h5")]
    failed = _one_by_one(begun, folder, device, threads, tell)
    names = {task.name for task in begun}
    fresh = [task for task in left if task.name not in names]
    known = known_of(folder, [task.name for task in fresh])
    pruning = None if rule is None else Pruning(rule, _ended_rivals(tasks, fresh, folder))
    return failed | run_in_lockstep(fresh, folder, known, device, threads, tell, finished, pruning)


def _ended_rivals(tasks: Sequence[Task], fresh: Sequence[Task], folder: Path) -> dict[str, list[Floats]]:
    """Costs of runs that ended earlier and were not pruned, by what they have in common with those that are left."""
    left, names = {task.rivals for task in fresh}, {task.name for task in fresh}
    found: dict[str, list[Floats]] = {}
    for task in tasks:
        if task.rivals in left and task.name not in names:
            with contextlib.suppress(ResultError):
                rival = glance(folder / f"{task.name}.h5")
                if not rival.ended.startswith(PRUNED):
                    found.setdefault(task.rivals, []).append(rival.cost)
    return found


def _has_files(path: Path) -> bool:
    """Whether a run has begun with files of its own."""
    return path.exists() or journal_path(path).exists()


def _one_by_one(
    left: Sequence[Task], folder: Path, device: str | None, threads: int | None, tell: Tell | None
) -> dict[str, str]:
    """Run optimisations that have stages, or files of their own, each as if it were alone but for its batches."""
    failed: dict[str, str] = {}
    for group in groups([task.scene for task in left]):
        chosen = [left[index] for index in group]
        jobs = [partial(_go_on, task, folder / f"{task.name}.h5", tell) for task in chosen]
        try:
            report = None if tell is None else partial(tell, "")
            errors = run_in_one_batch([task.scene for task in chosen], jobs, device, threads, report)
        except Error as error:  # such as of a gait to track that cannot be read
            errors = [error] * len(chosen)
        failed |= {task.name: str(error) for task, error in zip(chosen, errors, strict=True) if error is not None}
    return failed


def _go_on(task: Task, path: Path, tell: Tell | None, batches: MakeBatches) -> None:
    """Begin an optimisation, or go on with it; KeyboardInterrupt if that has ended it."""
    result = _result(task, path, tell, batches)
    if result.searched is not None and result.searched.ended == INTERRUPTED:
        raise KeyboardInterrupt


def _result(task: Task, path: Path, tell: Tell | None, batches: MakeBatches) -> Result:
    progress = None if tell is None else partial(tell, task.name)
    if not path.exists():
        o = task.options
        return optimize(
            task.scene, o.candidates, task.seed, search=o.strategy, searches=o.searches, population=o.population,
            sigma=o.sigma, restarts=o.restarts, until=o.until, target=o.target, output=path, command=task.command,
            progress=progress, batches=batches,
        )  # fmt: skip
    end = time.monotonic() + PATIENCE
    while True:
        try:
            return resume(path, progress=progress, batches=batches)
        except OccupiedError:
            if time.monotonic() >= end:
                raise
            time.sleep(0.2)
