"""The command that draws figures of a result file."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from warpmuscle.cli.common import Trust
from warpmuscle.cli.console import log, out
from warpmuscle.cli.results import Replay, Run

Start = Annotated[float | None, typer.Option(help="Start of the part of the motion that counts, s.")]
End = Annotated[float | None, typer.Option(help="End of that part, s.")]


def plot(
    results: Annotated[
        list[Path], typer.Argument(metavar="FILE...", help="HDF5 file of a simulation, an optimisation or throws.")
    ],
    what: Annotated[
        list[str] | None,
        typer.Option(help="Which figures: kinds, or dataset:/PATH; all that the file has if not given."),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help=".png, .svg or .pdf; for several figures, the beginning of their names."),
    ] = None,
    joint: Annotated[list[str] | None, typer.Option(help="Joints to show, names or patterns such as 'l*'.")] = None,
    muscle: Annotated[list[str] | None, typer.Option(help="Muscles to show, names or patterns such as '?SOL'.")] = None,
    norms: Annotated[bool, typer.Option(help="Draw norms of human walking, or not.")] = True,
    replay: Replay = 0,
    start: Start = None,
    end: End = None,
    run: Run = None,
    trust: Trust = False,
) -> None:
    """Draw figures of a result file, or of several over one another.

    Kinds: sticks, angles, ground_force, moments, body, feet, activation, control, joints, moment_arms, convergence,
    parameters.
    Examples: warpmuscle plot walk.h5; warpmuscle plot walk.h5 --what angles -o angles.svg;
    warpmuscle plot walk.h5 --what dataset:/replay/0/com; warpmuscle plot before.h5 after.h5 -o both.png
    """
    from warpmuscle.cli.common import start_warp
    from warpmuscle.core.errors import Error
    from warpmuscle.plots import KINDS, Absent, Choices, Subject, check_kind, draw_over, save
    from warpmuscle.plots.overlay import OVERLAYS
    from warpmuscle.plots.style import check_picture
    from warpmuscle.results.result import read

    kinds = what or list(KINDS if len(results) == 1 else OVERLAYS)
    plain = output or Path(f"{'_'.join(result.stem for result in results)}.png")
    paths = [_path(plain, kind, len(kinds) > 1 or output is None) for kind in kinds]
    for kind, path in zip(kinds, paths, strict=True):
        check_kind(kind)
        check_picture(path)
    choices = Choices.between(replay, start, end, joints=tuple(joint or ()), muscles=tuple(muscle or ()), norms=norms)
    subjects = [Subject(read(file, run, replay=replay), choices, file, run) for file in results]
    start_warp()
    missing: list[Error] = []
    for kind, path in zip(kinds, paths, strict=True):
        try:
            with log.status(f"drawing {kind}"):
                figure = draw_over(subjects, kind)
        except Absent as error:
            if what:
                raise
            missing.append(error)
            continue
        save(figure, path)
        out.print(f"wrote {path}", markup=False)
    if len(missing) == len(kinds):
        raise missing[0]
    for reason in dict.fromkeys(map(str, missing)):
        log.print(f"left out: {reason}", markup=False)


def _path(output: Path, kind: str, several: bool) -> Path:
    """The file of a figure; of several ones its kind is added to the name."""
    if not several or not output.name:
        return output
    from warpmuscle.core.names import file_name

    name = file_name(re.sub(r"\W+", "_", kind.removeprefix("dataset:")).strip("_"))
    return output.with_name(f"{output.stem}_{name}{output.suffix}")
