"""Commands that judge gaits: in numbers beside people's, and by what they withstand."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import (
    Commands,
    Device,
    Duration,
    Settings,
    Threads,
    Trust,
    changed,
    load_scene,
    scene_names_like,
    start_warp,
)
from warpmuscle.cli.console import log, out
from warpmuscle.cli.results import Run
from warpmuscle.cli.walkers import walker_of
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import readable

if TYPE_CHECKING:
    from warpmuscle.results.recording import Recording
    from warpmuscle.scene import Scene

RATE = 200.0  # frames/s, for what happens at a touch-down
Table = Annotated[Path | None, typer.Option("--output", "-o", help="File to write as well: .csv, .md, or .json.")]


def gait(
    sources: Annotated[
        list[str],
        typer.Argument(metavar="FILE...|SCENE...", help="Result files, or scenes.", autocompletion=scene_names_like),
    ],
    duration: Duration = None,
    replay: Annotated[int, typer.Option(min=0, help="Which motion of a file.")] = 0,
    run: Run = None,
    settings: Settings = None,
    device: Device = None,
    trust: Trust = False,
    output: Table = None,
) -> None:
    """Measure walks in result files, or in scenes that it runs, beside people's.

    Speed, steps, support, joint angles, moments and ground forces beside published norms, pelvis and trunk, when
    muscles act, energy, how the feet slide. A .json file holds curves over the gait cycle as well.
    Examples: warpmuscle gait walk.h5; warpmuscle gait walk56 walk56_person --duration 30 -o gaits.csv
    """
    from warpmuscle.report import gait as report
    from warpmuscle.report.tables import aligned, check_table, write

    check_table(output)
    start_warp()
    names = _names(sources)
    walks = []
    for name, source in zip(names, sources, strict=True):
        motion, scene = _walk(source, duration, replay, run, settings, device)
        walks.append(report.measured(name, motion, scene))
    rows = report.table(walks)
    for line in [*aligned(rows, texts=2), *report.energies(walks), *report.coarse(walks)]:
        out.print(line, markup=False)
    if output is not None:
        write(output, rows, report.numbers(walks))
        out.print(f"wrote {output}", markup=False)


def robustness(
    scenes: Annotated[
        list[str],
        typer.Argument(
            metavar="SCENE...|FILE...",
            help="Scene names, TOML files, or result files, of searches or of `learn`.",
            autocompletion=scene_names_like,
        ),
    ],
    pushes: Annotated[int, typer.Option(min=1, help="Pushes at each impulse.")] = 20,
    impulse: Annotated[
        list[float] | None, typer.Option(help="Impulse of pushes, N s; once for each; by default ten from 5 to 80.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of directions and times.")] = 1,
    slope: Annotated[float, typer.Option(min=-45.0, max=45.0, help="Slope, degrees, up and down.")] = 5.0,
    duration: Annotated[float, typer.Option(min=1.0, help="Simulated time on a slope, s.")] = 20.0,
    settings: Settings = None,
    commands: Commands = None,
    device: Device = None,
    threads: Threads = None,
    trust: Trust = False,
    output: Table = None,
) -> None:
    """Find out what gaits withstand: pushes of 0.1 s from all sides at random times, and slopes up and down.

    All pushes of a gait are one batch. Examples: warpmuscle robustness walk56 --pushes 10 --impulse 20 --impulse 40;
    warpmuscle robustness before.toml after.toml -o robustness.csv; warpmuscle robustness policy.h5 -c speed=1.4
    """
    from warpmuscle.report import robustness as report
    from warpmuscle.report.tables import aligned, check_table, write
    from warpmuscle.studies.robustness import IMPULSES

    check_table(output)
    start_warp()
    trials = []
    for name, source in zip(_names(scenes), scenes, strict=True):
        _, walker = walker_of([source], settings=settings, commands=commands, device=device, threads=threads)
        with log.status(f"pushing {name}, and letting it walk on slopes"):
            trials.append(report.tried(name, walker, impulse or IMPULSES, pushes, seed, slope, duration))
    rows = report.table(trials, slope, duration)
    for line in aligned(rows):
        out.print(line, markup=False)
    if output is not None:
        write(output, rows, report.numbers(trials, seed))
        out.print(f"wrote {output}", markup=False)


def _names(sources: list[str]) -> list[str]:
    """What sources are called: without folder and suffix, if they still differ."""
    short = [readable(Path(source).stem or source) for source in sources]
    return short if len(set(short)) == len(sources) else sources


def _walk(
    source: str, duration: float | None, replay: int, run: str | None, settings: list[str] | None, device: str | None
) -> tuple[Recording, Scene]:
    """The motion in a result file, or of a scene that is run, and the scene without free parameters."""
    from warpmuscle.optimization.best_scene import recorded_scene
    from warpmuscle.results.partial_motion import motion_of
    from warpmuscle.results.result import read
    from warpmuscle.view.sources import is_result

    if not is_result(source):
        return _simulated(source, duration, settings, device)
    for option, value in {"--duration": duration, "--set": settings or None}.items():
        if value is not None:
            raise Error(f"{source}: a result file takes no {option}")
    result = read(source, run, replay=replay)
    return motion_of(result, source, replay), recorded_scene(result)


def _simulated(
    source: str, duration: float | None, settings: list[str] | None, device: str | None
) -> tuple[Recording, Scene]:
    from warpmuscle.scene.parameters import at_start
    from warpmuscle.simulation.devices import find_devices
    from warpmuscle.simulation.rollout import Rollout

    scene = changed(load_scene([source], settings=settings), duration, None, None)
    with log.status(f"simulating {source}"):
        rollout = Rollout(scene, 1, str(find_devices(device)[0]), record=[0], record_rate=RATE)
        rollout.run()
    return rollout.recording(), at_start(scene)
