"""The command that makes a film of a motion."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from warpmuscle.cli.common import Trust
from warpmuscle.cli.console import log, out
from warpmuscle.cli.plot import End, Start
from warpmuscle.cli.results import Replay, Run
from warpmuscle.core.plain_text import number_of


def video(
    results: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", help="HDF5 files with a recorded motion, to be shown side by side."),
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help=".mp4, .gif or .webp file to write.")],
    size: Annotated[str, typer.Option(help="Width x height, px.")] = "1280x720",
    rate: Annotated[float, typer.Option(help="Frames a second.")] = 30.0,
    speed: Annotated[float, typer.Option(help="Speed of the motion; 0.25 is four times slower.")] = 1.0,
    azimuth: Annotated[float, typer.Option(help="Place of the camera, deg: 0 on the right side, 90 in front.")] = 20.0,
    elevation: Annotated[float, typer.Option(help="Elevation of the camera, deg.")] = 6.0,
    strides: Annotated[
        int,
        typer.Option(min=0, help="Of one motion, show only this many last gait cycles, as a film that repeats."),
    ] = 0,
    forces: Annotated[bool, typer.Option(help="Draw ground forces, or not.")] = True,
    caption: Annotated[bool, typer.Option(help="Write name, time and scale of colours, or not.")] = True,
    replay: Replay = 0,
    start: Start = None,
    end: End = None,
    run: Run = None,
    trust: Trust = False,
) -> None:
    """Make a film of a motion, or of several ones side by side, without a screen.

    Examples: warpmuscle video walk.h5 -o walk.mp4; warpmuscle video walk.h5 -o walk.gif --size 480x400 --strides 2;
    warpmuscle video before.h5 after.h5 -o both.mp4
    """
    from rich.progress import Progress

    from warpmuscle.plots.subject import Choices, Subject
    from warpmuscle.results.result import read
    from warpmuscle.video import Beside, Film, Look, check_film, films_beside, make_film, write

    check_film(output)
    look = Look(*_size(size), rate, azimuth, elevation, speed, strides, forces, caption)
    choices = Choices.between(replay, start, end)
    subjects = [Subject(read(result, run, replay=replay), choices, result, run) for result in results]
    film: Film | Beside
    if len(subjects) == 1:
        film = make_film(subjects[0].recording, subjects[0].scene, look, subjects[0].title)
    else:
        names = [result.stem for result in results]
        if len(set(names)) < len(names):
            names = [str(result) for result in results]
        motions = [(name, one.recording, one.scene) for name, one in zip(names, subjects, strict=True)]
        film = films_beside(motions, look)
    with Progress(console=log, transient=True) as progress:
        task = progress.add_task("drawing", total=len(film.time))
        write(film, output, lambda done, total: progress.update(task, completed=done))
    seconds = len(film.time) / look.rate
    out.print(f"wrote {output}: {number_of(len(film.time), 'frame')}, {seconds:.4g} s", markup=False)


def _size(text: str) -> tuple[int, int]:
    """Width and height of `1280x720`."""
    width, found, height = text.lower().partition("x")
    if not (found and width.strip().isdecimal() and height.strip().isdecimal()):
        raise typer.BadParameter(f"{text!r} is not a size such as 1280x720", param_hint="--size")
    return int(width), int(height)
