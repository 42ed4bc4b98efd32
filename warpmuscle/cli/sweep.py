"""The command `warpmuscle sweep`."""

from __future__ import annotations

import shlex
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import Device, Trust, doubts_printed, searches_told, start_warp
from warpmuscle.cli.console import log, out
from warpmuscle.cli.progress_bar import Bar
from warpmuscle.core.errors import Error
from warpmuscle.core.interruption import INTERRUPTED
from warpmuscle.core.plain_text import number_of
from warpmuscle.simulation.cuda_warmup import start_driver

if TYPE_CHECKING:
    from warpmuscle.sweep.board import SweepProgress
    from warpmuscle.sweep.status import SweepStatus


MOST_SHOWN = 1000  # runs; of more, those that have not ended


def sweep(
    file: Annotated[Path, typer.Argument(metavar="SWEEP", help="TOML file of a sweep; with --status its output, too.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="HDF5 file for all results; by default the name and .h5.")
    ] = None,
    cluster: Annotated[
        str | None, typer.Option(help="Run on a Ray cluster: its address, or auto for one on this machine.")
    ] = None,
    share: Annotated[
        int | None, typer.Option(min=1, help="Runs that share the batches of a task of the cluster.")
    ] = None,
    device: Device = None,
    threads: Annotated[int | None, typer.Option(min=1, help="CPU threads; of each task of a cluster.")] = None,
    status: Annotated[bool, typer.Option("--status", help="Only print how far the sweep has got.")] = False,
    trust: Trust = False,
) -> None:
    """Run many optimisations of a scene with other numbers, or trainings of policies, gathered into one file.

    Given again, the command goes on where it was, also after a kill, or with values and seeds that were added to the
    file of the sweep since. Examples: warpmuscle sweep weakness.toml;
    warpmuscle sweep weakness.toml --cluster auto; warpmuscle sweep --status weakness.toml
    """
    if status:
        from warpmuscle.sweep.status import sweep_status

        _print_status(sweep_status(file))
        return
    if cluster is None:
        start_driver(device)
    from warpmuscle.sweep.plan import read

    with doubts_printed():
        plan = read(file)
    start_warp()
    from warpmuscle.sweep.run import sweep as run
    from warpmuscle.sweep.status import sweep_status

    output = output if output is not None else Path(f"{file.stem}.h5")
    begin = time.perf_counter()
    try:
        with searches_told(), _Bar() as bar:
            result = run(
                plan, output, cluster=cluster, device=device, threads=threads, share=share,
                command=f"warpmuscle sweep {shlex.quote(file.name)}", progress=bar.update,
            )  # fmt: skip
    except KeyboardInterrupt:
        log.print("what was evaluated is kept, and the same command goes on")
        raise typer.Exit(INTERRUPTED) from None
    _print_status(sweep_status(output))
    out.print(
        f"wrote {output} with {number_of(result.gathered, 'run')} in {time.perf_counter() - begin:.1f} s", markup=False
    )
    if result.failed:
        name, why = next(iter(result.failed.items()))
        raise Error(f"{len(result.failed)} of {number_of(len(result.manifest.runs), 'run')} failed; {name}: {why}")


def _print_status(status: SweepStatus) -> None:
    """A line a run, and what they add up to."""
    sign = -1.0 if status.trains else 1.0
    counted, named = ("iterations", "return") if status.trains else ("candidates", "best cost")
    rows = [("run", counted, named, "state")]
    shown = status.runs if len(status.runs) <= MOST_SHOWN else [run for run in status.runs if not run.ended]
    for run in shown[:MOST_SHOWN]:
        best = f"{sign * run.best:.6g}" if run.evaluated else "-"
        done = f"{run.evaluated}/{run.candidates}" if run.candidates or not status.trains else str(run.evaluated)
        rows.append((run.name, done, best, status.word(run)))
    width = [max(len(row[column]) for row in rows) for column in range(3)]
    for name, candidates, best, state in rows if len(rows) > 1 else ():
        line = f"{name:{width[0]}}  {candidates:>{width[1]}}  {best:>{width[2]}}  {state}"
        out.print(line, markup=False)
    if len(shown) > MOST_SHOWN:
        out.print(f"and {number_of(len(shown) - MOST_SHOWN, 'further run')} that go on", markup=False)
    best_run = status.best
    word = "return" if status.trains else "cost"
    best = "" if best_run is None else f"; best: {best_run.name}, {word} {sign * best_run.best:.6g}"
    total = (
        f"{status.name}: {status.ended} of {number_of(len(status.runs), 'run')} done, {status.evaluated} "
        f"{counted}{best}"
    )
    out.print(total, markup=False)


class _Bar(Bar):
    """Progress of a sweep: runs and candidates done, the best run, time left."""

    def update(self, progress: SweepProgress) -> None:
        """Show this progress."""
        if progress.training is not None:
            p = progress.training
            part, done = (
                (progress.ended + p.fraction) / progress.runs,
                f"{progress.ended}/{number_of(progress.runs, 'run')}",
            )
            self.show(part, done, f"{progress.best_run}: {number_of(p.iterations, 'iteration')}, return {p.gain:.4g}")
            return
        if progress.gathered:
            self.show(progress.gathered / progress.runs, f"{progress.gathered}/{progress.runs} gathered", "")
            return
        best = f"best {progress.best:.5g} of {progress.best_run}" if progress.evaluated else ""
        done = f"{progress.ended}/{number_of(progress.runs, 'run')}, {progress.evaluated}/{progress.candidates}"
        part = progress.evaluated / max(progress.candidates, 1)
        self.show(part, done, f"{progress.alive} alive, {best}" if progress.alive else best)
