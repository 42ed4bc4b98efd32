"""The command that makes a film of a motion."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from warpmuscle.cli.console import log, out
from warpmuscle.cli.plot import End, Replay, Start
from warpmuscle.cli.results import Run


def video(
    result: Annotated[Path, typer.Argument(help="HDF5 file with a recorded motion.")],
    output: Annotated[Path, typer.Option("--output", "-o", help=".mp4, .gif or .webp file to write.")],
    size: Annotated[str, typer.Option(help="Width x height, px.")] = "1280x720",
    rate: Annotated[float, typer.Option(help="Frames a second.")] = 30.0,
    speed: Annotated[float, typer.Option(help="Of the motion; 0.25 is four times slower.")] = 1.0,
    azimuth: Annotated[float, typer.Option(help="Where the camera is, deg: 0 on the right side, 90 in front.")] = 20.0,
    elevation: Annotated[float, typer.Option(help="How far from above it looks, deg.")] = 6.0,
    strides: Annotated[
        int, typer.Option(min=0, help="Show so many last gait cycles, as a film to be repeated without a jump.")
    ] = 0,
    forces: Annotated[bool, typer.Option(help="Draw ground forces, or not.")] = True,
    caption: Annotated[bool, typer.Option(help="Write name, time and scale of colours, or not.")] = True,
    replay: Replay = 0,
    start: Start = None,
    end: End = None,
    run: Run = None,
) -> None:
    """Make a film of a motion, without a screen.

    Examples: warpmuscle video walk.h5 -o walk.mp4; warpmuscle video walk.h5 -o walk.gif --size 480x400 --strides 2
    """
    from rich.progress import Progress

    from warpmuscle.plots.subject import Choices, Subject
    from warpmuscle.results import read
    from warpmuscle.video import Look, check_film, make_film, write

    check_film(output)
    look = Look(*_size(size), rate, azimuth, elevation, speed, strides, forces, caption)
    subject = Subject(read(result, run), Choices.between(replay, start, end), result, run)
    film = make_film(subject.recording, subject.scene, look)
    with Progress(console=log, transient=True) as progress:
        task = progress.add_task("drawing", total=len(film.time))
        write(film, output, lambda done, total: progress.update(task, completed=done))
    seconds = len(film.time) / look.rate
    out.print(f"wrote {output}: {len(film.time)} frames, {seconds:.4g} s", markup=False)


def _size(text: str) -> tuple[int, int]:
    """Width and height of `1280x720`."""
    width, found, height = text.lower().partition("x")
    if not (found and width.strip().isdecimal() and height.strip().isdecimal()):
        raise typer.BadParameter(f"{text!r} is not a size such as 1280x720", param_hint="--size")
    return int(width), int(height)
