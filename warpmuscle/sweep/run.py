"""Runs a sweep, here or on a cluster, from wherever an earlier process has left it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.core.files import check_writable
from warpmuscle.learning.progress import TrainingProgress
from warpmuscle.optimization.progress import Progress
from warpmuscle.results.checkpoint import remove_leftovers
from warpmuscle.simulation.devices import devices_name, find_devices
from warpmuscle.sweep.folder import Folder, Manifest
from warpmuscle.sweep.gather import gather
from warpmuscle.sweep.local import Task, run_here
from warpmuscle.sweep.named_code import named_by
from warpmuscle.sweep.plan import Plan, read
from warpmuscle.sweep.trainings import gather_trainings, run_trainings

TELL_EVERY = 0.2  # s


@dataclass(frozen=True)
class SweepProgress:
    """How far a sweep has come."""

    runs: int
    ended: int  # of them
    candidates: int  # in all runs
    evaluated: int  # of them
    best: float  # least cost of all runs; infinite before there is one
    best_run: str
    alive: int  # still walking in the batch that runs now; 0 where that is not known
    training: TrainingProgress | None = None  # of the run `best_run`, where runs are trainings


@dataclass(frozen=True)
class SweepResult:
    """What became of a sweep."""

    manifest: Manifest
    folder: Folder
    gathered: int  # runs in the output
    failed: dict[str, str]  # why, by name of the run


Tell = Callable[[SweepProgress], None]


def sweep(
    plan: Plan | str | Path,
    output: str | Path | None = None,
    *,
    cluster: str | None = None,
    device: str | None = None,
    threads: int | None = None,
    share: int | None = None,
    command: str = "",
    progress: Tell | None = None,
    trust: bool = False,
) -> SweepResult:
    """Run all optimisations or trainings of a sweep file, or what is left of them, and gather their results.

    Each run is the same to the last bit as the optimisation alone, with whatever others it shares batches, here or on
    a cluster, interrupted or not, on the same kind of device and an equal machine.

    Args:
        plan: or the sweep file with it, see `plan.py`.
        output: HDF5 file for all results (see `gather.py`); by default the sweep file's name and .h5, here;
            the runs' own files are in a folder beside it, see `folder.py`.
        cluster: address of a Ray cluster; `auto` for one that runs on this machine, which is started if need be.
        device: see `make_rollout`; on a cluster a GPU a task if it has any.
        threads: CPU threads, of each task of a cluster 1 by default.
        share: how many runs share the batches of a task of a cluster; by default one on CPUs, and as many as there are
            for each GPU.
        command: put into the results as what made them.
        progress: called several times a second of work.
        trust: let code run that the scenes name, here and on a cluster.

    Raises:
        Error: the sweep cannot be used, names code that is not trusted, has changed since it began, or cannot be
            written.
        KeyboardInterrupt: it was interrupted; all that was evaluated is kept, and the same call goes on.
    """
    plan = plan if isinstance(plan, Plan) else read(plan, trust)
    if trust:
        plan.trust()
    code = named_by([run.scene for run in plan.runs])
    output = Path(output) if output is not None else Path(f"{plan.file.stem}.h5")
    check_writable(output)
    folder = Folder.of(output)
    if plan.trains:
        if cluster is not None:
            raise Error("trainings run on one machine, one after the other; leave the cluster out")
        return _train(plan, folder, output, device, threads, command, progress)
    tasks = [Task(run.name, run.scene, run.seed, run.options, command) for run in plan.runs]
    if cluster is not None:
        from warpmuscle.sweep.cluster import Cluster

        with Cluster(cluster, device, threads) as on, folder.at_work():
            manifest = folder.begin(plan, on.device_kind)
            board = _Board(plan, folder, manifest, progress)
            failed = on.run(tasks, folder, manifest, share, board.look, code)
            gathered = _finish(folder, manifest, output, command)
    else:
        found = find_devices(device)[0]
        with folder.at_work():
            manifest = folder.begin(plan, "cpu" if found.is_cpu else "cuda")
            board = _Board(plan, folder, manifest, progress)
            failed = run_here(tasks, folder.path, devices_name(device), threads, board.report)
            gathered = _finish(folder, manifest, output, command)
    board.look()
    return SweepResult(manifest, folder, gathered, failed)


def _train(
    plan: Plan, folder: Folder, output: Path, device: str | None, threads: int | None, command: str, tell: Tell | None
) -> SweepResult:
    """Run all trainings; see `sweep`."""

    def report(name: str, progress: TrainingProgress) -> None:
        if tell is not None:
            ended = names.index(name)
            tell(SweepProgress(len(names), ended, 0, progress.iterations, np.inf, name, 0, progress))

    names = [run.name for run in plan.runs]
    with folder.at_work():
        manifest = folder.begin(plan, "cpu" if find_devices(device)[0].is_cpu else "cuda")
        try:
            failed = run_trainings(plan, folder, device, threads, command, report)
        finally:
            gathered = gather_trainings(folder, manifest, output, command)
        remove_leftovers(output)
    return SweepResult(manifest, folder, gathered, failed)


def _finish(folder: Folder, manifest: Manifest, output: Path, command: str) -> int:
    gathered = gather(folder, manifest, output, command)
    remove_leftovers(output)
    return gathered


class _Board:
    """Keeps count of all runs of a sweep, and tells its user."""

    def __init__(self, plan: Plan, folder: Folder, manifest: Manifest, tell: Tell | None) -> None:
        self._folder, self._manifest, self._tell = folder, manifest, tell
        self._candidates = {run.name: run.candidates for run in plan.runs}
        self._done = dict.fromkeys(self._candidates, 0)
        self._best = dict.fromkeys(self._candidates, np.inf)
        self._ended: set[str] = set()
        self._alive = 0
        self._last = 0.0
        self.look()

    def report(self, name: str, progress: Progress) -> None:
        """One run has come so far; or, without a name, the batch that several of them share."""
        if name:
            self._done[name], self._best[name] = progress.done, progress.best
            if progress.done >= self._candidates[name]:
                self._ended.add(name)
        self._alive = progress.alive
        if time.monotonic() >= self._last + TELL_EVERY:
            self._report()

    def look(self) -> None:
        """Look into the files of the runs that have not finished."""
        for entry in self._manifest.runs:
            if entry.name not in self._ended:
                state = self._folder.state(entry)
                self._done[entry.name], self._best[entry.name] = state.evaluated, state.best
                if state.ended:
                    self._ended.add(entry.name)
        self._report()

    def _report(self) -> None:
        self._last = time.monotonic()
        if self._tell is None:
            return
        best = min(self._best, key=lambda name: self._best[name])
        candidates = sum(self._done[name] if name in self._ended else n for name, n in self._candidates.items())
        self._tell(
            SweepProgress(
                len(self._done),
                len(self._ended),
                candidates,
                sum(self._done.values()),
                self._best[best],
                best,
                self._alive,
            )
        )
