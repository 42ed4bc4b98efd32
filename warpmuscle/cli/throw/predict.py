"""The command that learns which signals of synergies throw where, and predicts those of new goals."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import (
    Device,
    Threads,
    Trust,
    command_line,
    load_scene,
    scene_names_like,
    start_warp,
    writable,
)
from warpmuscle.cli.console import log, marked, out, print_table
from warpmuscle.core.errors import Error
from warpmuscle.core.interruption import INTERRUPTED
from warpmuscle.core.plain_text import number_of

GOALS = 200

if TYPE_CHECKING:
    from warpmuscle.core.array_types import Floats
    from warpmuscle.throw.rules.rule import Rule


def predict(
    files: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[MOTION]", help="A recorded throw, as `throw fit` takes it; else the scene's own."),
    ] = None,
    scene: Annotated[
        str, typer.Option(help="The arm, with a ball in its hand.", autocompletion=scene_names_like)
    ] = "throw_ball",
    goals: Annotated[int | None, typer.Option(min=10, max=10_000, help=f"Goals to learn from; else {GOALS}.")] = None,
    between: Annotated[int, typer.Option(min=1, max=1000, help="Goals between these to try the rule on.")] = 30,
    beyond: Annotated[int, typer.Option(min=1, max=1000, help="Goals beyond them to try the rule on.")] = 20,
    target: Annotated[list[float] | None, typer.Option(help="Distance to throw to by the rule, m.")] = None,
    height: Annotated[float, typer.Option(help="Height of the target above the ground, m.")] = 0.5,
    angle: Annotated[float, typer.Option(help="Angle of release above the horizontal, degrees.")] = 25.0,
    number: Annotated[int | None, typer.Option("--number", "-n", min=1, help="How many synergies; else 5.")] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="HDF5 file of goals and changes.")] = None,
    resume: Annotated[
        Path | None, typer.Option(help="File of an interrupted search of the same throw, to go on with its goals.")
    ] = None,
    device: Device = None,
    threads: Threads = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of searches and of the goals; else 0.")] = None,
    trust: Trust = False,
) -> int:
    """Predict signals by a rule learned from many throws to distances (2 to 4 m), heights and angles of release.

    Goals are distance, height of the target (0 to 1 m) and angle of release (10 to 40 degrees).

    A throw at the middle of these goals is searched for, and from it many others; a thin-plate spline learns the
    signals, and is tried by simulation on goals between those and beyond them, beside a copy of the nearest goal.
    Ctrl-C ends the search and writes the goals met so far; --resume goes on from that file.

    Examples: warpmuscle throw predict throws/T0001.csv -o rule.h5; warpmuscle throw predict --goals 50
    --target 3 --height 1 --angle 30
    """
    from warpmuscle.core.extras import need
    from warpmuscle.throw.job import Job, JobOptions
    from warpmuscle.throw.rules.rule import LEAST_GOALS, begin
    from warpmuscle.throw.rules.rule_file import read_rule, read_seed, write_rule

    writable(output)
    need("sklearn", "synergies of motions need")
    asked = _asked(target or [], height, angle)
    if files and len(files) > 1:
        raise Error(f"a rule is learned out of one throw, not of {len(files)}")
    if resume is not None and (goals is not None or seed is not None):
        raise Error("--resume goes on with the goals and the seed of its file; leave out --goals and --seed")
    loaded = load_scene([scene])
    start_warp()
    seed = (seed or 0) if resume is None else read_seed(resume)
    job = Job(loaded, files or [], JobOptions(count=number, device=device, threads=threads, seed=seed))
    with log.status("fitting") as shown:
        if resume is not None:
            rule = read_rule(resume, job)
        else:
            job.fit(lambda stage: shown.update(f"fitting {stage}"))
            rule = begin(job, goals or GOALS, seed, shown.update)
    interrupted = False
    try:
        with log.status("meeting goals") as shown:
            rule.meet(shown.update)
    except KeyboardInterrupt:
        interrupted = True
        _tell_kept(rule, output)
    try:
        errors = _reported(rule, asked, between, beyond) if rule.enough else {}
    except KeyboardInterrupt:
        errors, interrupted = {}, True
    if output is not None:
        write_rule(output, job, rule, errors, command_line())
        out.print(f"wrote {output}")
    if not rule.enough and not interrupted:
        raise Error(f"{int(rule.met.sum())} of {number_of(len(rule.wanted), 'goal')} are met, too few to learn "
        "from; at least "
                    f"{LEAST_GOALS - 1}")  # fmt: skip
    return INTERRUPTED if interrupted else 0


def _tell_kept(rule: Rule, output: Path | None) -> None:
    """Say after Ctrl-C how far it came, and how it goes on."""
    tried, kept = int((rule.tried_from >= 0).sum()), "with -o they would have been kept"
    kept = kept if output is None else f"--resume {output} goes on from there"
    log.print(
        f"done so far: {tried} of {number_of(len(rule.wanted), 'goal')} tried, {int(rule.met.sum())} of them met; "
        f"{kept}"
    )


def _reported(rule: Rule, asked: Floats, between: int, beyond: int) -> dict[str, Floats]:
    """Print what the rule was learned from, how well it throws, and throws that are asked for; see `_tried`."""
    out.print(f"{int(rule.met.sum())} of {number_of(len(rule.wanted), 'goal')} are met, by "
    f"{number_of(rule.walk.simulations, 'simulation')}; all "
              f"throws are released after {rule.release:.2f} s")  # fmt: skip
    from warpmuscle.throw.rules.rule import beyond_learned

    errors = _tried(rule, between, beyond)
    for row in asked:
        outcome, past = rule.walk.outcomes(rule.predicted(row[None]), row[None])
        out.print(f"to {row[0]:g} m at {row[1]:g} m of height with {math.degrees(row[2]):.3g} deg: lands at "
                  f"{outcome[0, 0]:.3f} m, leaves at {math.degrees(outcome[0, 1]):.1f} deg, joints "
                  f"{math.degrees(past.max()):.1f} deg past their limits")  # fmt: skip
        if outside := beyond_learned(row):
            log.print(marked("note:", "yellow", f" the rule has learned nothing of {outside}"))
    return errors


def _asked(targets: list[float], height: float, angle: float) -> Floats:
    """Goals (n, 3) to throw to by the rule."""
    import numpy as np

    from warpmuscle.throw.goals import Goal

    for distance in targets:
        Goal(distance, height, angle=math.radians(angle))  # which refuses what makes no sense
    return np.array([[distance, height, math.radians(angle)] for distance in targets]).reshape(-1, 3)


def _tried(rule: Rule, between: int, beyond: int) -> dict[str, Floats]:
    """Print how far the rule misses goals that it has not learned from, beside a copy; errors by what was tried."""
    import numpy as np

    from warpmuscle.throw.rules.rule import MARGIN, goals_about

    rng = np.random.default_rng([rule.seed, 1])
    found = {}
    for name, count, margin in (("between", between, 0.0), ("beyond", beyond, MARGIN)):
        goals = goals_about(count, margin, rng)
        found[f"learned, {name}"] = rule.errors(rule.predicted(goals), goals)
        found[f"copy of the nearest, {name}"] = rule.errors(rule.copied(goals), goals)
    rows = []
    for name, error in found.items():
        middle, most = np.median(error, axis=0), np.percentile(error, 95, axis=0)
        rows.append((name, f"{100.0 * middle[0]:.1f}", f"{100.0 * most[0]:.1f}", f"{np.degrees(middle[1]):.1f}",
                     f"{np.degrees(most[1]):.1f}", f"{np.degrees(most[2]):.1f}"))  # fmt: skip
    headings = ["", "landing, cm", "95 %", "angle, deg", "95 %", "past limits, deg, 95 %"]
    print_table(headings, rows, [""], "errors at goals not learned from")
    return found
