"""The commands of sweeps: run one, join parts of one, and run and measure one that is a study."""

from __future__ import annotations

import shlex
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import (
    BoardFolder,
    Device,
    Population,
    Threads,
    Trust,
    board_too,
    doubts_printed,
    search_notes_printed,
    seconds,
    start_warp,
)
from warpmuscle.cli.console import log, out
from warpmuscle.cli.progress_bar import Bar
from warpmuscle.core.errors import Error
from warpmuscle.core.interruption import INTERRUPTED
from warpmuscle.core.plain_text import number_of
from warpmuscle.simulation.cuda_warmup import start_driver

if TYPE_CHECKING:
    from warpmuscle.sweep.board import SweepProgress
    from warpmuscle.sweep.plan import Plan
    from warpmuscle.sweep.run import SweepResult
    from warpmuscle.sweep.status import SweepStatus


SweepFile = Annotated[
    Path | None, typer.Option("--output", "-o", help="HDF5 file for all results; by default the name and .h5.")
]
Seeds = Annotated[int | None, typer.Option(min=1, help="Number of seeds, from 1 on, in place of the file's.")]
MOST_SHOWN = 1000  # runs; of more, those that have not ended


def sweep(
    file: Annotated[Path, typer.Argument(metavar="SWEEP", help="TOML file of a sweep; with --status its output, too.")],
    output: SweepFile = None,
    cluster: Annotated[
        str | None, typer.Option(help="Run on a Ray cluster: its address, or auto for one on this machine.")
    ] = None,
    share: Annotated[
        int | None, typer.Option(min=1, help="Runs that share the batches of a task of the cluster.")
    ] = None,
    device: Device = None,
    threads: Annotated[int | None, typer.Option(min=1, help="CPU threads; of each task of a cluster.")] = None,
    part: Annotated[
        str | None, typer.Option(metavar="K/N", help="Run only part K of N, which `warpmuscle join` puts together.")
    ] = None,
    slurm: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Write a script for Slurm, an array of N parts, and end.")
    ] = None,
    status: Annotated[bool, typer.Option("--status", help="Only print how far the sweep has got.")] = False,
    trust: Trust = False,
    tensorboard: BoardFolder = None,
) -> None:
    """Run many optimisations of a scene with other numbers, or trainings of policies, gathered into one file.

    Run again, the command continues where it stopped, also after a kill, or with values and seeds that were added to
    the file of the sweep since. Examples: warpmuscle sweep weakness.toml;
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
    output = output if output is not None else _usual_output(file)
    if slurm is not None:
        _write_script(plan, output, slurm, device, threads)
        return
    start_warp()
    from warpmuscle.sweep.run import sweep as run
    from warpmuscle.sweep.status import sweep_status

    begin = time.perf_counter()
    with progress_shown() as bar, board_too(bar.update, tensorboard) as tell:
        result = run(
            plan, output, cluster=cluster, device=device, threads=threads, share=share, part=part,
            command=f"warpmuscle sweep {shlex.quote(file.name)}", progress=tell,
        )  # fmt: skip
    _print_status(sweep_status(result.folder.path))
    took = f"{time.perf_counter() - begin:.1f} s"
    if part is not None:
        again = _join_command(file, output)
        out.print(f"part {part} is in {result.folder.path} after {took}; once all are: {again}", markup=False)
    else:
        out.print(f"wrote {output} with {number_of(result.gathered, 'run')} in {took}", markup=False)
    check_all_ran(result)


def join(
    file: Annotated[Path, typer.Argument(metavar="SWEEP", help="TOML file of the sweep.")],
    parts: Annotated[
        list[Path] | None, typer.Argument(metavar="[PART]...", help="Folders of parts, by default beside the output.")
    ] = None,
    output: SweepFile = None,
    incomplete: Annotated[
        bool, typer.Option("--incomplete", help="Join the runs that have ended; by default all must have.")
    ] = False,
    trust: Trust = False,
) -> None:
    """Put parts of a sweep together, as if one process had run all of it.

    Example: warpmuscle sweep weakness.toml --part 1/2; warpmuscle sweep weakness.toml --part 2/2;
    warpmuscle join weakness.toml
    """
    from warpmuscle.sweep.plan import read

    with doubts_printed():
        plan = read(file)
    from warpmuscle.sweep.join import join as joined

    output = output if output is not None else _usual_output(file)
    begin = time.perf_counter()
    with _Bar() as bar:
        result = joined(
            plan, output, parts or [], incomplete=incomplete, command=f"warpmuscle sweep {shlex.quote(file.name)}",
            progress=bar.update,
        )  # fmt: skip
    left = len(result.manifest.runs) - result.gathered
    rest = f"; {number_of(left, 'run')} had not ended" if left else ""
    out.print(
        f"wrote {output} with {number_of(result.gathered, 'run')} in {time.perf_counter() - begin:.1f} s{rest}",
        markup=False,
    )


def study(
    file: Annotated[
        Path, typer.Argument(metavar="STUDY", help="TOML file of a sweep with a table \\[study], or a shipped study.")
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="HDF5 file of the sweep; by default the name and .h5.")
    ] = None,
    seeds: Seeds = None,
    candidates: Annotated[
        int | None, typer.Option(min=1, help="Candidates of each search, in place of the file's.")
    ] = None,
    population: Population = None,
    until: Annotated[str | None, typer.Option(metavar="TIME", help="Wall time of each batch of searches: 90s.")] = None,
    device: Device = None,
    threads: Threads = None,
    trust: Trust = False,
) -> None:
    """Run a sweep, measure its gaits, compare conditions over seeds, and put them beside what is expected.

    Writes a page and a table of runs (.html, .csv) beside the results. Run again, the command continues where it
    stopped; what is measured and expected may have changed. Of a shipped study, such as brace, a copy is written here
    first; `warpmuscle example studies` writes all of them. Examples: warpmuscle study weak_calves.toml;
    warpmuscle study brace
    """
    from warpmuscle.core.extras import need_for_page
    from warpmuscle.core.files import files_beside, replace_file, shown
    from warpmuscle.core.machine import cores

    need_for_page()
    file = study_file(file)
    start_driver(device)
    from warpmuscle.sweep.plan import read

    given = {"candidates": candidates, "population": population, "until": None if until is None else seconds(until)}
    options = {name: value for name, value in given.items() if value is not None}
    with doubts_printed():
        plan = read(file, seeds=seeds, options=options)
    if plan.study is None:
        raise Error(f"{file}: no [study]: `warpmuscle sweep` runs it, and the manual says what a study is")
    output = output if output is not None else _usual_output(file)
    page_file, table_file = files_beside(output, (".html", ".csv"))
    start_warp()
    from warpmuscle.report.tables import aligned, write
    from warpmuscle.sweep.run import sweep as run
    from warpmuscle.sweep.study import page as study_page
    from warpmuscle.sweep.study.measured import measured

    words = [file.name, *(() if seeds is None else ("--seeds", str(seeds)))]
    words += [word for name, value in options.items() for word in (f"--{name}", shown(value))]
    begin, command = time.perf_counter(), f"warpmuscle study {shlex.join(words)}"
    with progress_shown() as bar:
        done = run(plan, output, device=device, threads=threads, command=command, progress=bar.update)
    with log.status("measuring"):
        found = measured(plan, done, threads or cores())
        page = study_page.page(found, plan, command)
    rows = study_page.lines(found)
    for line in [*aligned(rows, texts=rows[0].index("unit") + 1), *study_page.held_lines(found)]:
        out.print(line, markup=False)
    write(table_file, study_page.run_table(found), {})
    replace_file(page_file, page)
    took = f"{time.perf_counter() - begin:.1f} s"
    out.print(f"{study_page.counted(found)}; wrote {page_file}, {table_file} and {output} in {took}", markup=False)
    check_all_ran(done)


def study_file(file: Path) -> Path:
    """The file of a study: the given one, or a copy of a shipped one of this name, which is written unless it is there.

    Raises:
        Error: there is neither.
    """
    from warpmuscle.core.files import replace_file
    from warpmuscle.examples.studies import STUDIES, study_files
    from warpmuscle.scene.validation.checks import near

    name = str(file)
    if file.is_file() or file.suffix:
        return file
    if name not in STUDIES:
        raise Error(f"{name}: no such file, and no shipped study{near(name, STUDIES)}; there are {', '.join(STUDIES)}")
    copy, *others = map(Path, contents := study_files(name))
    for other in others:
        if not other.exists():
            replace_file(other, contents[str(other)])
            log.print(f"wrote {other}, with which it begins", markup=False)
    if not copy.exists():
        replace_file(copy, contents[str(copy)])
        log.print(f"wrote {copy}: {STUDIES[name]}", markup=False)
    return copy


def _write_script(plan: Plan, output: Path, parts: int, device: str | None, threads: int | None) -> None:
    from warpmuscle.core.files import files_beside
    from warpmuscle.sweep.slurm import slurm_script, write_slurm_script

    if parts > len(plan.runs):
        raise Error(f"--slurm {parts}: the sweep has only {number_of(len(plan.runs), 'run')}")
    more = "" if device is None else f" --device {shlex.quote(device)}"
    more += "" if threads is None else f" --threads {threads}"
    (script,) = files_beside(output, (".slurm",))
    write_slurm_script(script, slurm_script(plan.file, output, parts, more))
    again = _join_command(plan.file, output)
    out.print(f"wrote {script}: sbatch {script}; once all its jobs have ended: {again}", markup=False)


def _join_command(file: Path, output: Path) -> str:
    named = [] if output == _usual_output(file) else ["-o", str(output)]
    return shlex.join(["warpmuscle", "join", str(file), *named])


def _usual_output(file: Path) -> Path:
    return Path(f"{file.stem}.h5")


@contextmanager
def progress_shown() -> Iterator[_Bar]:
    """A bar of what runs within; an interruption ends the program, after it has said that nothing is lost."""
    try:
        with search_notes_printed(), _Bar() as bar:
            yield bar
    except KeyboardInterrupt:
        log.print("what was evaluated is kept, and the same command goes on")
        raise typer.Exit(INTERRUPTED) from None


def check_all_ran(result: SweepResult) -> None:
    """Raise Error if a run has failed."""
    if result.failed:
        raise Error(result.failure)


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
        alive = f"{progress.alive} alive" if progress.alive else ""
        self.show(part, done, ", ".join(word for word in (alive, best) if word))
