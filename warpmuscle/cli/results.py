"""Commands about result files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from warpmuscle.cli.console import out

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
    run: Run = None,
) -> None:
    """Show what an optimisation found: outcomes, convergence, the score explained, parameters in their bounds."""
    from warpmuscle.report import report as lines_of
    from warpmuscle.results import read

    for line in lines_of(read(result, run)):
        out.print(line, markup=False)


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
