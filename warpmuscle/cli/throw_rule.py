"""The command that learns which signals of synergies throw where, and throws by that rule."""

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
from warpmuscle.cli.console import log, out, print_table
from warpmuscle.core.errors import Error

if TYPE_CHECKING:
    from warpmuscle.core.array_types import Floats
    from warpmuscle.throw.rule import Rule


def throw_rule(
    files: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[MOTION]", help="A recorded throw, as `throw` takes it; else the scene's own."),
    ] = None,
    scene: Annotated[
        str, typer.Option(help="The arm, with a ball in its hand.", autocompletion=scene_names_like)
    ] = "throw_ball",
    goals: Annotated[int, typer.Option(min=10, max=10_000, help="Goals to learn from.")] = 200,
    between: Annotated[int, typer.Option(min=1, max=1000, help="Goals between these to try the rule on.")] = 30,
    beyond: Annotated[int, typer.Option(min=1, max=1000, help="Goals beyond them to try it on.")] = 20,
    target: Annotated[list[float] | None, typer.Option(help="Distance to throw to by the rule, m.")] = None,
    height: Annotated[float, typer.Option(help="Height of the target above the ground, m.")] = 0.5,
    angle: Annotated[float, typer.Option(help="Of the release above the horizontal, degrees.")] = 25.0,
    number: Annotated[int | None, typer.Option("--number", "-n", min=1, help="How many synergies; else 5.")] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="HDF5 file of goals and changes.")] = None,
    device: Device = None,
    threads: Threads = None,
    seed: Annotated[int, typer.Option(min=0, help="Of searches and of the goals.")] = 0,
    trust: Trust = False,
) -> None:
    """Learn the rule from goals to signals: distance (2 to 4 m), height (0 to 1 m) and angle of release (10 to 40 deg).

    A throw at the middle of these goals is searched for, and from it many others; a thin-plate spline learns the
    signals, and is tried by simulation on goals between those and beyond them, beside a copy of the nearest goal.

    Examples: warpmuscle throw-rule throws/T0001.csv -o rule.h5; warpmuscle throw-rule --goals 50
    --target 3 --height 1 --angle 30
    """
    from warpmuscle.core.extras import need
    from warpmuscle.throw.job import Job, Options
    from warpmuscle.throw.rule import learn

    writable(output)
    need("sklearn", "synergies of motions need")
    asked = _asked(target or [], height, angle)
    if files and len(files) > 1:
        raise Error(f"a rule is learned out of one throw, not of {len(files)}")
    loaded = load_scene([scene])
    start_warp()
    job = Job(loaded, files or [], Options(count=number, device=device, threads=threads, seed=seed))
    with log.status("fitting") as shown:
        job.fit(lambda stage: shown.update(f"fitting {stage}"))
        rule = learn(job, goals, seed, shown.update)
    out.print(f"{len(rule.goals) - 1} of {goals} goals are met, by {rule.walk.simulations} simulations; all throws are "
              f"released after {rule.middle.release:.2f} s")  # fmt: skip
    errors = _tried(rule, between, beyond, seed)
    for row in asked:
        landed, left = rule.walk.outcomes(rule.told(row[None]), row[None])[0]
        past = math.degrees(float(rule.walk.past_limits(rule.told(row[None]))[0]))
        out.print(f"to {row[0]:g} m at {row[1]:g} m of height with {math.degrees(row[2]):.3g} deg: lands at "
                  f"{landed:.3f} m, leaves at "
                  f"{math.degrees(left):.1f} deg, joints {past:.1f} deg past their limits")  # fmt: skip
    if output is not None:
        _write(output, rule, errors)
        out.print(f"wrote {output}")


def _asked(targets: list[float], height: float, angle: float) -> Floats:
    """Goals (n, 3) to throw to by the rule."""
    import numpy as np

    from warpmuscle.throw.goals import Goal

    for distance in targets:
        Goal(distance, height, angle=math.radians(angle))  # which refuses what makes no sense
    return np.array([[distance, height, math.radians(angle)] for distance in targets]).reshape(-1, 3)


def _tried(rule: Rule, between: int, beyond: int, seed: int) -> dict[str, Floats]:
    """Print how far the rule misses goals that it has not learned from, beside a copy; errors by what was tried."""
    import numpy as np

    from warpmuscle.throw.rule import MARGIN, goals_about

    rng = np.random.default_rng([seed, 1])
    found = {}
    for name, count, margin in (("between", between, 0.0), ("beyond", beyond, MARGIN)):
        goals = goals_about(count, margin, rng)
        found[f"learned, {name}"] = rule.errors(rule.told(goals), goals)
        found[f"copy of the nearest, {name}"] = rule.errors(rule.copied(goals), goals)
    rows = []
    for name, error in found.items():
        middle, most = np.median(error, axis=0), np.percentile(error, 95, axis=0)
        rows.append((name, f"{100.0 * middle[0]:.1f}", f"{100.0 * most[0]:.1f}", f"{np.degrees(middle[1]):.1f}",
                     f"{np.degrees(most[1]):.1f}"))  # fmt: skip
    print_table(["", "landing, cm", "95 %", "angle, deg", "95 %"], rows, [""], "errors at goals not learned from")
    return found


def _write(path: Path, rule: Rule, errors: dict[str, Floats]) -> None:
    """Keep goals, changes of the signals, and the errors of the goals that were tried."""
    import io

    import h5py

    from warpmuscle.core.files import replace_file
    from warpmuscle.core.hdf5_writing import store

    memory = io.BytesIO()
    with h5py.File(memory, "w", track_order=True) as file:
        file.attrs["format"], file.attrs["command"] = "warpmuscle throw rule", command_line()
        store(file, "goals", rule.goals, axes="goal, distance height angle", description="met; in m, m and rad")
        store(file, "changes", rule.changes, axes="goal, synergy and coarse knot",
              description="of the signals, from those of the first goal")  # fmt: skip
        store(file, "known", rule.walk.thrower.own, axes="signal", description="signals that changes are of")
        store(file, "hats", rule.walk.thrower.hats, axes="knot, coarse knot")
        store(file, "release", rule.middle.release, units="s")
        group = file.create_group("errors", track_order=True)
        for name, error in errors.items():
            store(group, name.replace(", ", "_").replace(" ", "_"), error, axes="goal, landing angle",
                  description="of landing, m, and of the angle, rad")  # fmt: skip
    replace_file(path, memory.getvalue())
