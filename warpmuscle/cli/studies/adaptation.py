"""The command that predicts how people adapt their walking, and compares with what was measured."""

from __future__ import annotations

import shlex
import time
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import (
    Device,
    Population,
    Settings,
    Threads,
    Trust,
    doubts_printed,
    seconds,
    settings_in,
    start_warp,
    with_settings,
)
from warpmuscle.cli.console import log, out
from warpmuscle.cli.sweep import check_all_ran, progress_shown
from warpmuscle.core.errors import Error
from warpmuscle.simulation.cuda_warmup import start_driver

if TYPE_CHECKING:
    from warpmuscle.sweep.adaptation.records import Record


def adaptation(
    data: Annotated[Path, typer.Argument(metavar="DATA", help="JSON file of measured conditions.")],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="HDF5 file of the sweep; beside it .toml, .html and .csv.")
    ] = Path("adaptation.h5"),
    scene: Annotated[str, typer.Option(help="Scene that walks: a shipped one, or a TOML file.")] = "reflex_planar",
    conditions: Annotated[
        list[str] | None, typer.Option(help="Names of conditions, or patterns; by default all.")
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Searches of each condition.")] = 6,
    candidates: Annotated[int, typer.Option(min=1, help="Candidates of a search.")] = 300,
    duration: Annotated[float, typer.Option(min=1.0, help="Duration of each simulation, s.")] = 6.0,
    sigma: Annotated[float, typer.Option(min=0.0001, help="First step of a search, over the unit interval.")] = 0.03,
    population: Population = None,
    settings: Settings = None,
    until: Annotated[str | None, typer.Option(metavar="TIME", help="Wall time of all searches: 90s, 5m.")] = None,
    device: Device = None,
    threads: Threads = None,
    trust: Trust = False,
) -> None:
    """Search for walks under measured conditions, and compare the changes that they predict with those of people.

    Compares changes of metabolic power, by seven formulas, of stride frequency, and of angles, with speed, slope
    and load. Run again, the command continues where it stopped.
    Examples: warpmuscle adaptation adaptation.json --conditions "Koelewijn*" --seeds 6; warpmuscle adaptation
    adaptation.json --set objective.cost_of_transport=5 --set objective.metabolic_model=margaria
    """
    from warpmuscle.core.extras import need_for_page
    from warpmuscle.core.files import files_beside, replace_file
    from warpmuscle.core.machine import cores

    need_for_page()
    sweep_file, page_file, table_file = files_beside(output, (".toml", ".html", ".csv"))
    start_driver(device)
    from warpmuscle.formats import load
    from warpmuscle.sweep.adaptation.plan import check_not_edited, sweep_text
    from warpmuscle.sweep.adaptation.records import read_records
    from warpmuscle.sweep.plan import read

    records = _chosen(read_records(data), conditions, data)
    check_not_edited(sweep_file)
    search = {"candidates": candidates, "sigma": sigma}
    search |= {} if population is None else {"population": population}
    search |= {} if until is None else {"until": seconds(until)}
    named = str(Path(scene).absolute()) if Path(scene).suffix else scene
    with doubts_printed():
        walker = with_settings(load(scene, trust=trust), settings or [])
        values = dict(settings_in(settings or []))
        replace_file(sweep_file, sweep_text(records, walker, named, seeds, search, duration, values))
        plan = read(sweep_file, trusted=trust)
    start_warp()
    from warpmuscle.report.tables import aligned, write
    from warpmuscle.sweep.adaptation import page as pages
    from warpmuscle.sweep.adaptation.comparison import comparison
    from warpmuscle.sweep.run import sweep as run

    begin, command = time.perf_counter(), f"warpmuscle adaptation {shlex.quote(data.name)}"
    with progress_shown() as bar:
        done = run(plan, output, device=device, threads=threads, command=command, progress=bar.update)
    with log.status("measuring"):
        found = comparison(records, plan, done, walker, threads or cores())
        page = pages.page(found, plan.text, command)
    for line in aligned(pages.lines(found), texts=2):
        out.print(line, markup=False)
    write(table_file, pages.change_table(found), {})
    replace_file(page_file, page)
    took = f"{time.perf_counter() - begin:.1f} s"
    out.print(f"{found.counted}; wrote {page_file}, {table_file} and {output} in {took}", markup=False)
    check_all_ran(done)


def _chosen(records: list[Record], patterns: list[str] | None, data: Path) -> list[Record]:
    """The conditions of these names, with those that they are compared with."""
    from warpmuscle.scene.validation.checks import near
    from warpmuscle.sweep.adaptation.records import reference_of

    if not patterns:
        return records
    names = set()
    for pattern in patterns:
        found = [record for record in records if fnmatchcase(record.name, pattern)]
        if not found:
            raise Error(f"{data}: no condition is called {pattern!r}{near(pattern, [one.name for one in records])}")
        for record in found:
            reference = reference_of(record, records)
            names |= {record.name} | ({reference.name} if reference is not None else set())
    return [record for record in records if record.name in names]
