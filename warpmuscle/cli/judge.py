"""The command that judges a gait."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.text import Text

from warpmuscle.cli.common import Commands, Device, JsonFile, Policy, Settings, Threads, Trust, start_warp, writable
from warpmuscle.cli.console import log, out
from warpmuscle.cli.walkers import Walkers, of_a_policy, walker_of
from warpmuscle.core.extras import check_report
from warpmuscle.core.plain_text import rounded

if TYPE_CHECKING:
    from warpmuscle.studies.judge import Judgement
    from warpmuscle.studies.verdicts import Bar, Verdict

STYLES = {"goal": "green", "must": "green", "missed": "red", "does not count": "red", "not measured": "yellow"}


def judge(
    sources: Walkers,
    policy: Policy = None,
    settings: Settings = None,
    commands: Commands = None,
    pushes: Annotated[int, typer.Option(min=0, help="Pushes of each of ten impulses; 0 leaves them out.")] = 20,
    device: Device = None,
    threads: Threads = None,
    trust: Trust = False,
    output: JsonFile = None,
    report: Annotated[Path | None, typer.Option(help="Page to write: indices, both sides, figures, all rows.")] = None,
) -> None:
    """Judge a gait: its likeness to people's, cost and robustness, beside required and desired values.

    It walks 60 s, then 20 runs of 10 s with noise of 0.1 m/s, each body's mass 10 % more or less, on slopes within 3
    degrees, is pushed, and walks on slopes of 5 degrees, with loads, and at other speeds if it takes a speed. It is
    also tried with all disturbances at once, harder, with friction of 0.4 and delayed, noisy nerves; with sideways
    pushes of 80 N s at ten phases; and with random commands. A policy acts without noise, from the scene's own start,
    at 1.25 m/s if it has learnt that speed. Examples: warpmuscle judge walk56_person;
    warpmuscle judge walk56_commands --command speed=1.5; warpmuscle judge policy.h5 --report policy.html;
    warpmuscle judge walk56 --policy policy.h5
    """
    writable(output)
    if report is not None:
        check_report(report)
    start_warp()
    from warpmuscle.core.files import replace_file
    from warpmuscle.studies.judge import judge as judged
    from warpmuscle.studies.verdicts import RUNS

    recorded = None if policy or settings or commands else _of_recording(sources)
    if recorded is not None:
        name, judgement = recorded
    else:
        name, walker = walker_of(
            sources, policy=policy, settings=settings, commands=commands, device=device, threads=threads
        )
        with log.status("compiling, which may take some seconds") as shown:
            judgement = judged(walker, pushes=pushes, tell=shown.update)
    speed = judgement.measures.get("speed")
    at = "" if speed is None else f" at {rounded(speed, 2)} m/s"
    out.print(f"{name}, judged as a {'run' if judgement.running else 'walk'}{at}: {judgement.end}", markup=False)
    for one in judgement.impaired:
        out.print(f"impaired: {one}", markup=False)
    if judgement.impossible:
        out.print("Its bodies pass through each other: nothing that it reaches counts.", style="red")
    _print_table(judgement.verdicts)
    out.print("besides:")
    _print_table(judgement.further)
    fallen = [f"{what}: {number} of {RUNS}" for what, number in judgement.felled_by.items() if number]
    if recorded is None:
        out.print("fells it: " + (", ".join(fallen) or "none of these disturbances by itself"), markup=False)
    if report is not None:
        from warpmuscle.report.clinic import clinic_html

        with log.status("drawing") as shown:
            page = clinic_html(name, judgement, shown.update)
        replace_file(report, page.encode())
        out.print(f"wrote {report}", markup=False)
    if output is not None:
        replace_file(output, json.dumps(_numbers(name, judgement), indent=1).encode() + b"\n")
        out.print(f"wrote {output}", markup=False)


def _of_recording(sources: list[str]) -> tuple[str, Judgement] | None:
    """Name and judgement of a file of `warpmuscle inverse`, of its first trial, or of a policy's motion; else None."""
    from warpmuscle.optimization.best_scene import recorded_scene
    from warpmuscle.results.result import holds_trials, read
    from warpmuscle.studies.judge_recording import judge_recording
    from warpmuscle.view.sources import is_result

    if len(sources) != 1 or not is_result(sources[0]):
        return None
    result = read(sources[0], replay=0)
    if not holds_trials(sources[0]) and not of_a_policy(result):
        return None
    name = Path(sources[0]).stem if not result.replay_names else result.replay_names[0]
    return name, judge_recording(result.replays[0], recorded_scene(result))


def _print_table(verdicts: list[Verdict]) -> None:
    """A line a measure, in columns; lines are not cut, wherever they are printed."""
    from warpmuscle.studies.verdicts import ends

    rows = [("", "", "", "must", "goal", "", "")] + [
        (one.bar.name, one.shown, one.bar.unit, ends(one.bar.must), ends(one.bar.goal), one.reached, one.note)
        for one in verdicts
    ]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for number, row in enumerate(rows):
        *cells, reached, note = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        style = STYLES.get(row[5], "") if number else "bold"
        line = Text("  ".join(cells) + "  ", style="" if number else "bold")
        out.print(line.append(reached, style).append(f"  {note}".rstrip()))


def _numbers(name: str, judgement: Judgement) -> dict[str, Any]:
    """All numbers, fit for JSON."""

    def of_bar(bar: Bar) -> dict[str, Any]:
        return {"name": bar.name, "unit": bar.unit, "must": bar.must, "goal": bar.goal}

    def of(verdicts: list[Verdict]) -> list[dict[str, Any]]:
        return [of_bar(one.bar) | {"value": one.value, "reached": one.reached, "note": one.note} for one in verdicts]

    commanded = [{"command": one.asked, "measures": one.measures, "why": one.why} for one in judgement.commanded]
    return {
        "scene": name, "running": judgement.running, "end": judgement.end, "verdicts": of(judgement.verdicts),
        "further": of(judgement.further),
        "measures": judgement.measures, "commanded": commanded, "impossible": judgement.impossible,
        "felled_by": judgement.felled_by,
    }  # fmt: skip
