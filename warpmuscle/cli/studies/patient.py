"""The command from a patient's recordings to what a change of the body predicts."""

from __future__ import annotations

import shlex
import time
from pathlib import Path
from typing import Annotated

import typer

from warpmuscle.cli.common import Device, Threads, Trust, doubts_printed, start_warp
from warpmuscle.cli.console import log, out
from warpmuscle.cli.sweep import Seeds, progress_shown
from warpmuscle.core.errors import Error
from warpmuscle.simulation.cuda_warmup import start_driver


def patient(
    file: Annotated[Path, typer.Argument(metavar="PATIENT", help="TOML file of recordings, a scene and changes.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="HTML page; a table, .csv, and a folder, .patient, are written beside it."),
    ] = None,
    seeds: Seeds = None,
    device: Device = None,
    threads: Threads = None,
    trust: Trust = False,
) -> None:
    """Search for walks like a patient's recorded one, and predict what a changed muscle, tendon or brace does to it.

    Searches, one for each seed, bring the angles of hips, knees and ankles near the patient's mean stride, measured in
    the patient's own spread; others start from there with each change, and without one. The page says how near they
    came, also in moments and forces that no search saw, and what changed. Run again, the command continues where it
    stopped. Example: warpmuscle patient patient.toml --seeds 6
    """
    from warpmuscle.core.extras import need_for_page
    from warpmuscle.core.files import check_output, files_beside, replace_file

    page = output if output is not None else Path(f"{file.stem}.html")
    check_output(page, "a patient's path", (".html",))
    (table,) = files_beside(page, (".csv",))
    need_for_page()
    start_driver(device)
    from warpmuscle.sweep.patient.file import read

    asked = read(file, seeds)
    start_warp()
    from warpmuscle.report.tables import aligned, write
    from warpmuscle.sweep.patient import page as pages
    from warpmuscle.sweep.patient.path import follow

    begin = time.perf_counter()
    command = f"warpmuscle patient {shlex.quote(file.name)}"
    with doubts_printed(), progress_shown() as bar:
        found = follow(
            asked, page, device=device, threads=threads, command=command, progress=bar.update,
            say=lambda what: log.print(what, markup=False),
        )  # fmt: skip
    with log.status("drawing"):
        text = pages.page(found, command)
    for line in [*aligned(pages.match_lines(found), texts=2), "", *aligned(pages.change_lines(found), texts=2)]:
        out.print(line, markup=False)
    write(table, pages.table(found), {})
    replace_file(page, text)
    took = f"{time.perf_counter() - begin:.1f} s"
    out.print(f"{pages.counted(found)}; wrote {page} and {table} in {took}", markup=False)
    if found.failure:
        raise Error(found.failure)
