"""What the commands of throws share: their options, and the job that these describe."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import command_line, load_scene, quantities_in, scene_names_like, start_warp, writable
from warpmuscle.cli.console import log, out
from warpmuscle.cli.throw.tables import print_fit
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of
from warpmuscle.simulation.cuda_warmup import start_driver

if TYPE_CHECKING:
    from warpmuscle.scene import Scene
    from warpmuscle.throw.job import Job

Motions = Annotated[
    list[Path], typer.Argument(metavar="MOTION...", help="CSV, .mot, .sto or .npz files with times and joint angles.")
]
Number = Annotated[
    int | None,
    typer.Option(
        "--number",
        "-n",
        min=1,
        help="How many synergies to compute; else 5, or two a joint and one beyond three joints.",
    ),
]
Arm = Annotated[
    str | None,
    typer.Option(
        help="The arm: a shipped scene or a TOML file; by default throw18, or with --emg or --as-published the six "
        "pulley muscles of throw.",
        autocompletion=scene_names_like,
    ),
]
Emg = Annotated[
    Path | None, typer.Option(help="HDF5 file of `warpmuscle synergies extract`, in place of computed synergies.")
]
Channels = Annotated[
    list[str] | None, typer.Option(metavar="MUSCLE=CHANNEL", help="Which channel of --emg stands for a muscle.")
]
Calibrate = Annotated[
    bool, typer.Option("--calibrate", help="Find gains and delays of the channels of --emg, and of the muscles.")
]
LowPass = Annotated[
    float | None,
    typer.Option(
        min=0.0,
        help="Low-pass recorded motions at so many Hz; 0 for none. By default only where they are noisy, at a "
        "cut-off found by residual analysis, and never with --as-published.",
    ),
]
Prescribed = Annotated[
    list[str] | None, typer.Option(metavar="JOINT", help="A joint that moves as recorded, without muscles.")
]
FitAll = Annotated[
    bool, typer.Option("--fit-all", help="Fit parameters to all motions, rather than to every other one.")
]
Fidelity = Annotated[float, typer.Option(min=0.0, help="Price of leaving the extracted signals, against accuracy.")]
PlotEach = Annotated[
    Path | None, typer.Option(help="Folder for a figure of each motion, with muscles and the flight of a ball.")
]
Seed = Annotated[int, typer.Option(min=0, help="Seed of random starts.")]

FIDELITY = 1e-3


def check_files(output: Path | None, plot: Path | None, plot_each: Path | None = None) -> None:
    """Error now, rather than after the work, if a file cannot be written."""
    from warpmuscle.core.extras import need

    writable(output, plot)
    if plot_each is not None:
        need("matplotlib", "figures need")
        if plot_each.exists() and not plot_each.is_dir():
            raise Error(f"--plot-each names {plot_each}, which is not a folder")
    if plot is not None:
        from warpmuscle.plots.style import check_picture

        check_picture(plot)
        if output is not None and plot.resolve() == output.resolve():
            raise Error(f"--output and --plot both name {plot}")


def check_synergies(emg: Path | None, channels: Sequence[str] | None, calibrate: bool, numbers: object) -> None:
    """Error if options that say where synergies come from contradict each other."""
    from warpmuscle.core.extras import need

    if emg is None or calibrate:
        need("sklearn", "synergies of motions need")
    check_needed({"--channel": channels, "--calibrate": calibrate}, emg, "--emg")
    if emg is not None and numbers is not None:
        raise Error("--number is for computed synergies; --emg brings its own")


def check_needed(options: Mapping[str, object], given: object, what: str) -> None:
    """Error if one of these options is given without what it is for."""
    for name, value in options.items():
        if value and not given:
            raise Error(f"{name} is of use only with {what}")


def pairs(texts: Sequence[str] | None) -> dict[str, str]:
    """Channels by muscle, each given as MUSCLE=CHANNEL."""
    found = {}
    for text in texts or []:
        muscle, equals, name = text.partition("=")
        if not equals or not muscle or not name:
            raise Error(f"--channel {text!r}: say MUSCLE=CHANNEL")
        found[muscle.strip()] = name.strip()
    return found


def load_arm(scene: str, device: str | None) -> Scene:
    """The scene of an arm, with Warp and its device on their way."""
    start_driver(device)
    loaded = load_scene([scene])
    start_warp()
    return loaded


def fit(job: Job) -> None:
    """Fit, and print what an interrupted fit had found."""
    try:
        with log.status("fitting") as shown:
            job.fit(lambda stage: shown.update(f"fitting {stage}"))
    except KeyboardInterrupt:
        if job.fitted is not None:
            print_fit(job, job.fitted)
        raise


def write_files(
    job: Job,
    output: Path | None,
    plot: Path | None,
    plot_each: Path | None,
    seed: int,
    quantities: str | None,
    single: bool,
) -> None:
    """Write the results of a job, complete or interrupted."""
    if output is not None:
        job.write(output, {"command": command_line(), "seed": seed}, quantities_in(quantities), single)
        out.print(f"wrote {output}")
    if plot is not None:
        from warpmuscle.throw.motion_plot import draw_result

        draw_result(plot, job.follower, job.fitted, job.published, job.throws)
        out.print(f"wrote {plot}")
    if plot_each is not None and job.fitted is not None:
        from warpmuscle.throw.motion_plot import draw_each

        draw_each(plot_each, job.follower, job.fitted)
        out.print(f"wrote {number_of(len(job.motions), 'figure')} to {plot_each}")
