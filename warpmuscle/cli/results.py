"""Commands about result files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from warpmuscle.cli.console import log, out

Run = Annotated[str | None, typer.Option(help="Which run of the file of a sweep.")]


def apply(
    result: Annotated[Path, typer.Argument(help="HDF5 file of an optimisation.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="TOML file to write.")],
    run: Run = None,
) -> None:
    """Write the scene of an optimisation with its best parameters as a scene file."""
    import numpy as np

    from warpmuscle.errors import ResultError
    from warpmuscle.formats import save, toml
    from warpmuscle.parameters import with_values
    from warpmuscle.results import read

    content = read(result, run)
    if content.best is None:
        raise ResultError(f"{result} holds no candidates to choose the best of")
    save(with_values(toml.loads(content.scene), np.asarray(content.best.params, dtype=np.float64)), output)
    out.print(f"wrote {output}")


def report(
    result: Annotated[Path, typer.Argument(help="HDF5 file of an optimisation.")],
    output: Annotated[Path | None, typer.Option("--output", "-o", help=".html page to write, with figures.")] = None,
    reference: Annotated[
        list[Path] | None, typer.Option(help="HDF5 file of another walk to put beside this one's numbers in the page.")
    ] = None,
    replay: Annotated[int, typer.Option(min=0, help="Which motion of the file is in the page.")] = 0,
    run: Run = None,
) -> None:
    """Show what an optimisation found: outcomes, convergence, the score explained, parameters in their bounds.

    With -o it is one page that needs nothing but a browser, with figures, the motion to play, and the gait beside human
    walking. Example: warpmuscle report result.h5 -o report.html
    """
    from warpmuscle.report import report as lines_of
    from warpmuscle.results import read

    if output is not None:
        _write_page(result, output, reference or [], replay, run)
        return
    for line in lines_of(read(result, run)):
        out.print(line, markup=False)


def _write_page(result: Path, output: Path, references: list[Path], replay: int, run: str | None) -> None:
    from warpmuscle.cli.common import start_warp, writable
    from warpmuscle.errors import Error
    from warpmuscle.formats.files import replace_file
    from warpmuscle.plots.subject import Choices, Subject
    from warpmuscle.report_page import report_html
    from warpmuscle.results import read

    if output.suffix.lower() not in (".html", ".htm"):
        raise Error(f"{output}: a report is written as .html")
    writable(output)
    subject = Subject(read(result, run), Choices(replay), result, run)
    others = [Subject(read(path), Choices(), path) for path in references]
    start_warp()
    with log.status("drawing") as shown:
        page = report_html(subject, others, lambda what: shown.update(f"drawing: {what}"))
    replace_file(output, page)
    out.print(f"wrote {output}", markup=False)


def export(
    result: Annotated[Path, typer.Argument(help="HDF5 file with a recorded motion.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="OpenSim's .mot (angles) or .sto (muscles), or .csv.")],
    replay: Annotated[int, typer.Option(min=0, help="Which motion of the file.")] = 0,
    run: Run = None,
) -> None:
    """Write a recorded motion for OpenSim or as comma-separated values."""
    from warpmuscle.errors import ResultError
    from warpmuscle.formats import sto, toml
    from warpmuscle.results import read

    content = read(result, run)
    if replay >= len(content.replays):
        raise ResultError(f"{result} has {len(content.replays)} motions, none with number {replay}")
    sto.write(content.replays[replay], toml.loads(content.scene), output)
    out.print(f"wrote {output}")
