"""The command that fits muscles and synergies to recorded motions of an arm, and makes new throws."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from warpmuscle.cli.common import Device, Threads, command_line, load_scene, start_warp, writable
from warpmuscle.cli.console import log, out
from warpmuscle.errors import Error

if TYPE_CHECKING:
    from collections.abc import Sequence

    from warpmuscle.throw.arm import Arm
    from warpmuscle.throw.fit import Fitted
    from warpmuscle.throw.follow import Follower
    from warpmuscle.throw.job import Job
    from warpmuscle.throw.published import Published
    from warpmuscle.throw.synthesis import Throw


def throw(
    files: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[MOTION]...", help="CSV, .mot, .sto or .npz files with times and joint angles."),
    ] = None,
    scene: Annotated[str, typer.Option(help="The arm: a shipped scene or a TOML file.")] = "throw",
    number: Annotated[int, typer.Option("--number", "-n", min=1, help="How many synergies, of computed ones.")] = 5,
    emg: Annotated[
        Path | None, typer.Option(help="HDF5 file of `warpmuscle synergies`, in place of computed synergies.")
    ] = None,
    channel: Annotated[
        list[str] | None, typer.Option(metavar="MUSCLE=CHANNEL", help="Which channel of --emg stands for a muscle.")
    ] = None,
    prescribe: Annotated[
        list[str] | None, typer.Option(metavar="JOINT", help="A joint that moves as recorded, without muscles.")
    ] = None,
    as_published: Annotated[
        bool, typer.Option("--as-published", help="Fit as Cruz Ruiz et al. 2015 did, each motion by itself.")
    ] = False,
    fit_all: Annotated[
        bool, typer.Option("--fit-all", help="Fit parameters to all motions, rather than to every other one.")
    ] = False,
    fidelity: Annotated[
        float, typer.Option(min=0.0, help="Price of leaving the extracted signals, against accuracy.")
    ] = 1e-3,
    curve: Annotated[bool, typer.Option("--curve", help="Print accuracy against fidelity at several prices.")] = False,
    target: Annotated[
        list[float] | None, typer.Option(help="Distance at which a ball is to land, m; may be given several times.")
    ] = None,
    height: Annotated[float, typer.Option(help="Height of the target above the ground, m.")] = 0.0,
    speed: Annotated[float | None, typer.Option(help="Speed at which the ball is to leave the hand, m/s.")] = None,
    angle: Annotated[float | None, typer.Option(help="Its angle above the horizontal, degrees.")] = None,
    release: Annotated[
        float | None, typer.Option(help="Time of release, s; by default when the hand is fastest.")
    ] = None,
    adapt: Annotated[int, typer.Option(min=1, help="How many synergies' signals may change for a new throw.")] = 3,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="HDF5 file to write.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Figure to draw, .png, .svg or .pdf.")] = None,
    device: Device = None,
    threads: Threads = None,
    seed: Annotated[int, typer.Option(min=0, help="Of random starts.")] = 0,
) -> None:
    """Fit an arm's muscles and synergies to recorded motions and replay them, or throw a ball at a target.

    Examples: warpmuscle throw throws/*.csv -o throw.h5; warpmuscle throw serve.csv --prescribe shoulder;
    warpmuscle throw lift.csv --emg syn.h5 --prescribe wrist --curve; warpmuscle throw --target 2 --target 4
    """
    from warpmuscle.throw.job import Job, Options

    writable(output, plot)
    if not files and not target and speed is None and angle is None:
        raise Error("nothing to do: name files with motions, or a goal such as --target 4")
    loaded = load_scene([scene])
    start_warp()
    options = Options(
        count=number, prescribed=tuple(prescribe or ()), emg=emg, channels=_pairs(channel or []), fit_all=fit_all,
        fidelity=fidelity, device=device, threads=threads, seed=seed,
    )  # fmt: skip
    job = Job(loaded, files or [], options)
    _print_problem(job)
    if as_published:
        _published(job)
    goals = _goals(target or [], height, speed, angle)
    fitted = None
    if not as_published or goals or curve:
        with log.status("fitting") as shown:
            fitted = job.fit(lambda stage: shown.update(f"fitting {stage}"))
        _print_fit(job, fitted)
    if curve and fitted is not None:
        _print_curve(job, fitted)
    throws: list[Throw] = []
    if goals and fitted is not None:
        throws = _throws(job, fitted, goals, release, adapt)
    if output is not None:
        job.write(output, throws, {"command": command_line(), "seed": seed})
        out.print(f"wrote {output}")
    if plot is not None:
        from warpmuscle.throw.plot import draw_fit, draw_throws

        if throws:
            draw_throws(plot, job.follower, throws)
        else:
            draw_fit(plot, job.follower, fitted, job.published)
        out.print(f"wrote {plot}")
