"""The gaits in numbers, beside human walking and the torque-driven original.

For docs/explanation/gait-tables.md.

python tools/research/gait_table.py                            table in Markdown of the shipped gaits, 60 s each
python tools/research/gait_table.py walk56 mine.toml           of these scenes
python tools/research/gait_table.py "walk56:objective.target_speed=1.25"
                                                      of a scene with another number
python tools/research/gait_table.py --json gaits.json --pictures FOLDER
                                                      also all numbers, and figures of every gait
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

import msgspec
import typer
import warp as wp
from gait_pictures import compare, draw_gait

import warpmuscle as wm
from warpmuscle.cli.common import with_settings
from warpmuscle.cli.ending import run_script
from warpmuscle.core.errors import Error
from warpmuscle.core.files import replace_file
from warpmuscle.core.status import Status
from warpmuscle.gait.quality import Measures, gait_measures
from warpmuscle.gait.table import DECIMALS, human, shown_rows, unit_of
from warpmuscle.model.muscles import driven
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import installed_versions
from warpmuscle.scene import Scene
from warpmuscle.scene.accounting import accounting
from warpmuscle.scene.norms import KEY_POINTS
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.multi_device import make_rollout
from warpmuscle.studies.robustness import upright
from warpmuscle.studies.walkers import SceneWalker

ORIGINAL = "fwalk"  # the torque-driven walk that all others stand beside
SCENES = (
    "walk56", "walk56_human", "walk56_person", "walk56_commands", "run56",
    "walk56_speeds:objective.target_speed=0.8", "walk56_speeds:objective.target_speed=1.0",
    "walk56_speeds:objective.target_speed=1.25", "walk56_speeds:objective.target_speed=1.5", "walk44_but_hips",
    "walk50_but_back", "wang2012:objective.target_speed=1.0", "wang2012:objective.target_speed=1.25", "jog56",
    "walk56_slopes:ground.normal.2=-0.0875", "walk56_slopes:ground.normal.2=0.0875", "walk56_robust", "inplace56",
    "back56", "reflex_walk", "fjog",
)  # fmt: skip
RATE = 200.0  # frames/s, for what happens at a touch-down and for trembling
SECONDS_OF_RUNS = 10.0  # s
# What a gait should have: the measure, the least and the greatest value.
AIMS = {
    "angles outside the norms": (0.0, 0.25),
    "deviation of the ground force": (0.0, 1.0),
    "depth of the valley": (0.05, 1.0),
    "cost of transport": (0.0, 4.5),
    "maximum slide of the stance foot": (0.0, 2.0),
    "maximum error of the heading": (0.0, 10.0),
    "depth of the feet": (0.0, 5.0),
    "knee, minimum": (-1.0, 90.0),
}
DOUBLE_SUPPORT = (18.0, 25.0)  # % of the cycle, of gaits that are judged as walking
LARGEST_SPEED_ERROR = 0.05  # of the speed aimed at; m/s where that is 0
ENOUGH_UPRIGHT = 0.9  # of the runs


@dataclass(frozen=True)
class Judged:
    """A gait and its numbers."""

    name: str
    status: str  # how the long run ended
    completed: bool
    end_time: float  # s, of it
    upright: int  # of the runs with noise
    torques_help: bool  # besides muscles
    measures: Measures  # none of a motion without whole gait cycles
    why: str = ""  # there are none
    accounting: str = ""  # how its metabolic energy is counted


def scene_of(name: str) -> Scene:
    """A scene by name or file, with other numbers behind a colon: `walk56:duration=5,objective.target_speed=1.25`.

    Raises:
        Error: there is no such scene, or no such number in it.
    """
    base, _, changes = name.partition(":")
    scene = with_settings(wm.load(base), changes.split(",")) if changes else wm.load(base)
    return at_start(scene)


def called(name: str) -> str:
    """A short name of a scene with other numbers: that of the scene and the numbers."""
    base, _, changes = name.partition(":")
    return " ".join([base, *(change.partition("=")[2] for change in changes.split(",") if changes)])


def judge(
    name: str, scene: Scene, duration: float, runs: int, noise: float, device: str | None, threads: int | None
) -> tuple[Judged, Recording]:
    """Simulate a gait once for long and several times with noise at the start, and measure it."""
    lasting = msgspec.structs.replace(scene, duration=duration)
    rollout = make_rollout(lasting, 1, device, record=[0], record_rate=RATE, threads=threads)
    rollout.run()
    status, recording = Status(rollout.status()[0]), rollout.recording()
    measures: Measures = {}
    why = ""
    try:
        measures = gait_measures(recording, scene)
    except Error as error:
        why = str(error)
    count = upright(SceneWalker(scene, device, threads), runs, noise, min(SECONDS_OF_RUNS, duration))
    completed, helped = status == Status.COMPLETED, _torques_help(scene)
    end = float(rollout.end_time()[0])
    counted = accounting(scene, recording.muscle_names)
    return Judged(name, status.meaning, completed, end, count, helped, measures, why, counted), recording


def _torques_help(scene: Scene) -> bool:
    """Whether torques drive a part of a character that has muscles."""
    found = driven(scene, topology(scene.character))
    return bool(found.muscles) and found.torques_help


def markdown(gaits: list[Judged], runs: int, noise: float, seconds: float) -> list[str]:
    """Lines of the table: a row a measure, a column a gait; the runs with noise took so many seconds."""
    lines = [
        "| measure | unit | human | " + " | ".join(f"`{gait.name}`" for gait in gaits) + " |",
        "|---|---|---|" + "---|" * len(gaits),
        "| upright | s | | " + " | ".join(_end(gait) for gait in gaits) + " |",
        f"| upright of {runs} runs of {seconds:g} s, noise {noise:g} m/s | | | "
        + " | ".join(str(gait.upright) for gait in gaits) + " |",
    ]  # fmt: skip
    for name, unit, known, *cells in shown_rows([gait.measures for gait in gaits]):
        lines.append(f"| {name} | {unit} | {known} | {' | '.join(cells)} |")
    return lines


def accountings(gaits: list[Judged]) -> list[str]:
    """How the cost of transport of the gaits that have one is counted, a line for all that count alike."""
    found: dict[str, list[str]] = {}
    for gait in gaits:
        if gait.measures.get("metabolic power") is not None:
            found.setdefault(gait.accounting, []).append(f"`{gait.name}`")
    return [f"Metabolic power of {', '.join(names)}: {words}." for words, names in found.items()]


def _end(gait: Judged) -> str:
    return f"{gait.end_time:.0f}" if gait.completed else _failure(gait)


def _failure(gait: Judged) -> str:
    return f"{gait.status.partition(':')[0]} at {gait.end_time:.1f}"


def misses(gait: Judged, runs: int) -> list[str]:
    """Where a gait misses its aims, in words."""
    found = [] if gait.completed else [f"{_failure(gait)} s"]
    if gait.upright < ENOUGH_UPRIGHT * runs:
        found.append(f"upright in {gait.upright} of {runs} runs")
    error, target = gait.measures.get("error of the speed"), gait.measures.get("target speed")
    if error is not None and target is not None and abs(error) > LARGEST_SPEED_ERROR * (abs(target) or 1.0):
        found.append(f"speed {target + error:.2f} m/s for {target:g} m/s")
    walking = {"double support": DOUBLE_SUPPORT} if f"angles from {KEY_POINTS}" in gait.measures else {}
    for name, (low, high) in (AIMS | walking).items():
        value = gait.measures.get(name)
        if value is not None and not low <= value <= high:
            aim = f"aim: {high:g}" if value > high else f"aim: {low:g} or more"
            found.append(f"{name} {value:.{DECIMALS[unit_of(name)]}f} {unit_of(name)} ({aim})")
    return found


def content(gaits: list[Judged], options: dict[str, Any]) -> bytes:
    """All numbers as JSON."""
    units = {name: unit_of(name) for gait in gaits for name in gait.measures}
    people = {name: {"value": human(name)[0], "source": human(name)[1]} for name in units if human(name)[0]}
    table = {"options": options, "versions": installed_versions(), "units": units, "human": people}
    return json.dumps(table | {"gaits": [asdict(gait) for gait in gaits]}, indent=1).encode() + b"\n"


def main(
    scenes: Annotated[list[str] | None, typer.Argument(help="Scenes; by default the shipped gaits.")] = None,
    duration: Annotated[float, typer.Option(min=1.0, help="Simulated time, s.")] = 60.0,
    runs: Annotated[int, typer.Option(min=1, help="Runs with noise.")] = 20,
    noise: Annotated[float, typer.Option(min=0.0, help="Of their root's velocity, m/s.")] = 0.05,
    device: Annotated[str, typer.Option(help="cpu, cuda:0, ...")] = "cpu",
    threads: Annotated[int | None, typer.Option(min=1, help="CPU threads.")] = None,
    output: Annotated[Path | None, typer.Option("--json", help="File for all numbers.")] = None,
    pictures: Annotated[Path | None, typer.Option(help="Folder for figures.")] = None,
) -> None:
    """Print how good the gaits are."""
    wp.config.log_level = wp.LOG_WARNING
    names = list(dict.fromkeys([ORIGINAL, *(scenes or SCENES)]))
    short = [called(name) for name in names]
    labels = short if len(set(short)) == len(names) else names
    found = {label: scene_of(name) for label, name in zip(labels, names, strict=True)}
    gaits: list[Judged] = []
    motions: dict[str, tuple[Recording, Scene]] = {}
    for name, scene in found.items():
        gait, recording = judge(name, scene, duration, runs, noise, device, threads)
        gaits.append(gait)
        if pictures is not None and gait.measures:
            draw_gait(pictures, name, recording, scene)
            if "knee, minimum" in gait.measures:
                motions[name] = recording, scene
    if pictures is not None and motions:
        compare(pictures / "gaits.png", motions)
    if output is not None:
        options = {"duration": duration, "runs": runs, "noise": noise, "device": device}
        replace_file(output, content(gaits, options))
    typer.echo("\n".join(markdown(gaits, runs, noise, min(SECONDS_OF_RUNS, duration))) + "\n")
    typer.echo("\n".join([*accountings(gaits), ""]))
    if helped := [f"`{gait.name}`" for gait in gaits if gait.torques_help]:
        typer.echo(f"Torques help to drive {', '.join(helped)}; only muscles count in their power and cost.\n")
    for gait in gaits[1:]:
        typer.echo(
            f"`{gait.name}` misses: {'; '.join(misses(gait, runs)) or 'nothing'}.{' ' + gait.why if gait.why else ''}"
        )


if __name__ == "__main__":
    run_script(main)
