"""Runs a sweep, here or on a cluster, from wherever an earlier process has left it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warpmuscle.core.errors import Error, ResultError
from warpmuscle.core.files import check_writable
from warpmuscle.core.plain_text import number_of
from warpmuscle.learning.progress import TrainingProgress
from warpmuscle.results.checkpoint import remove_leftovers
from warpmuscle.results.sweeps import is_sweep, sweep_name
from warpmuscle.simulation.devices import devices_name, find_devices
from warpmuscle.sweep.board import Board, SweepProgress, Tell
from warpmuscle.sweep.folder import Folder, Manifest
from warpmuscle.sweep.gather import gather
from warpmuscle.sweep.local import run_here
from warpmuscle.sweep.named_code import NamedCode, named_by
from warpmuscle.sweep.part import part_of
from warpmuscle.sweep.plan import Plan, read
from warpmuscle.sweep.refinement.rounds import in_rounds
from warpmuscle.sweep.rounds import remove_known
from warpmuscle.sweep.task import Task
from warpmuscle.sweep.trainings import gather_trainings, run_trainings


@dataclass(frozen=True)
class SweepResult:
    """What became of a sweep."""

    manifest: Manifest
    folder: Folder
    gathered: int  # runs in the output
    failed: dict[str, str]  # why, by name of the run

    @property
    def failure(self) -> str:
        """How many runs failed, and why the first one did; empty if none did."""
        for name, why in self.failed.items():
            hint = "; remove this file, and the run is computed anew" if why.endswith("or damaged") else ""
            return f"{len(self.failed)} of {number_of(len(self.manifest.runs), 'run')} failed; {name}: {why}{hint}"
        return ""


def sweep(
    plan: Plan | str | Path,
    output: str | Path | None = None,
    *,
    cluster: str | None = None,
    device: str | None = None,
    threads: int | None = None,
    share: int | None = None,
    part: str | None = None,
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
        part: such as 3/40: only these runs, in a folder of their own, see `part.py`; nothing is gathered.
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
    code = named_by(plan.scenes)
    output = Path(output) if output is not None else Path(f"{plan.file.stem}.h5")
    check_writable(output)
    check_same_study(output, plan.name)
    folder = Folder.of(output)
    target: Path | None = output
    if part is not None:
        if cluster is not None:
            raise Error("a part runs on one machine; leave the cluster out")
        chosen = part_of(part)
        plan, folder, target = chosen.of(plan), chosen.folder(output), None
    if plan.trains:
        if cluster is not None:
            raise Error("trainings run on one machine, one after the other; leave the cluster out")
        return _train(plan, folder, target, device, threads, command, progress)
    if plan.prune is not None and (part is not None or cluster is not None):
        raise Error("runs that compete go side by side on one machine; leave the parts, the cluster or [prune] out")

    def once(own: Plan, last: bool) -> SweepResult:
        if trust:
            own.trust()
        where = target if last else None
        if cluster is not None:
            return _on_cluster(own, folder, where, cluster, device, threads, share, command, progress, code)
        return _here(own, folder, where, device, threads, command, progress)

    if plan.refinement is None:
        return once(plan, True)
    if part is not None:
        raise Error("adaptive points follow from the results of all others; leave the parts out")
    return in_rounds(plan, folder, once, lambda done: done.manifest)


def _tasks(plan: Plan, command: str) -> list[Task]:
    """The runs of a plan as tasks."""
    rivals = ["" if plan.prune is None else plan.prune.rivals(run.axes, run.candidates) for run in plan.runs]
    return [Task(run.name, run.scene, run.seed, run.options, command, plan.keep, key)
            for run, key in zip(plan.runs, rivals, strict=True)]  # fmt: skip


def _on_cluster(
    plan: Plan, folder: Folder, output: Path | None, cluster: str, device: str | None, threads: int | None,
    share: int | None, command: str, progress: Tell | None, code: NamedCode,
) -> SweepResult:  # fmt: skip
    """Run all optimisations on a cluster; see `sweep`."""
    from warpmuscle.sweep.cluster import Cluster

    with Cluster(cluster, device, threads) as on, folder.at_work():
        manifest = folder.begin(plan, on.device_kind)
        board = Board(folder, manifest, progress)
        failed = on.run(board.left(_tasks(plan, command)), folder, manifest, share, board.look, code)
        return SweepResult(manifest, folder, _finish(folder, manifest, board, output, command), failed)


def _here(
    plan: Plan, folder: Folder, output: Path | None, device: str | None, threads: int | None, command: str,
    progress: Tell | None,
) -> SweepResult:  # fmt: skip
    """Run all optimisations on this machine; see `sweep`."""
    found, tasks = find_devices(device)[0], _tasks(plan, command)
    with folder.at_work():
        manifest = folder.begin(plan, "cpu" if found.is_cpu else "cuda")
        board = Board(folder, manifest, progress)
        failed = run_here(
            board.left(tasks) if plan.prune is None else tasks, folder.path, devices_name(device), threads,
            board.report, board.finished, plan.prune,
        )  # fmt: skip
        return SweepResult(manifest, folder, _finish(folder, manifest, board, output, command), failed)


def _train(
    plan: Plan, folder: Folder, output: Path | None, device: str | None, threads: int | None, command: str,
    tell: Tell | None,
) -> SweepResult:  # fmt: skip
    """Run all trainings; see `sweep`."""

    def report(name: str, progress: TrainingProgress) -> None:
        if tell is not None:
            ended = names.index(name)
            tell(SweepProgress(len(names), ended, 0, progress.iterations, np.inf, name, 0, training=progress))

    names = [run.name for run in plan.runs]
    with folder.at_work():
        manifest = folder.begin(plan, "cpu" if find_devices(device)[0].is_cpu else "cuda")
        try:
            failed = run_trainings(plan, folder, device, threads, command, report)
        finally:
            gathered = 0 if output is None else gather_trainings(folder, manifest, output, command)
        if output is not None:
            remove_leftovers(output)
    return SweepResult(manifest, folder, gathered, failed)


def gather_all(folder: Folder, manifest: Manifest, output: Path, command: str, tell: Tell | None) -> int:
    """Gather what is in the folder of a sweep; how many runs the file has. Raises ResultError as `gather`."""
    if manifest.trains:
        return gather_trainings(folder, manifest, output, command)
    return _finish(folder, manifest, Board(folder, manifest, tell), output, command)


def _finish(folder: Folder, manifest: Manifest, board: Board, output: Path | None, command: str) -> int:
    """Gather all that the runs have come to, unless the file has it, or there is to be none."""
    board.look()
    remove_known(folder.path, [state.name for state in board.states if not state.ended])
    if output is None:
        return 0
    if folder.is_gathered(manifest, board.states, output, command):
        return len(board.states)
    gathered = gather(folder, manifest, board.states, output, command, board.gathering)
    folder.remember(manifest, board.states, output, command)
    remove_leftovers(output)
    return gathered


def check_same_study(output: Path, name: str) -> None:
    """Raise Error if a file would be replaced that is not what this sweep has come to before.

    Args:
        name: of the sweep.
    """
    if not output.exists():
        return
    advice = "name another --output, or move it out of the way"
    try:
        is_one = is_sweep(output)
        other = sweep_name(output) if is_one else ""
    except ResultError as error:
        raise Error(f"{error}: would be replaced by the results of a sweep; {advice}") from None
    if not is_one:
        raise Error(f"{output}: would be replaced, and is not the file of a sweep; {advice}")
    if other != name:
        raise Error(f"{output}: would be replaced, and is the file of another sweep, {other!r}; {advice}")
