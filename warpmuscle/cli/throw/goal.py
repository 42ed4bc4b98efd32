"""The command that searches for new throws of an arm, at goals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import Device, Figure, Quantities, ResultFile, Single, Threads, Trust
from warpmuscle.cli.console import log, marked, out
from warpmuscle.cli.throw.options import (
    Arm,
    Channels,
    Emg,
    LowPass,
    Number,
    Prescribed,
    Seed,
    check_files,
    check_needed,
    check_synergies,
    fit,
    load_arm,
    pairs,
    write_files,
)
from warpmuscle.cli.throw.tables import print_fit, print_problem, tell_kept
from warpmuscle.core.errors import Error
from warpmuscle.core.interruption import INTERRUPTED

# Exit codes where new throws miss a part of their goals; several parts are SEVERAL.
MISSED, SEVERAL = {"distance": 1, "speed": 3, "angle": 4, "duration": 5, "limits": 7}, 6

if TYPE_CHECKING:
    from warpmuscle.throw.goals import Goal
    from warpmuscle.throw.job import Job
    from warpmuscle.throw.synthesis import Throw


def goal(
    files: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[MOTION]...", help="Motions as `throw fit` takes them; else the scene's own."),
    ] = None,
    target: Annotated[
        list[float] | None, typer.Option(help="Distance at which a ball is to land, m; may be given several times.")
    ] = None,
    height: Annotated[float | None, typer.Option(help="Height of the target above the ground, m; else 0.")] = None,
    speed: Annotated[float | None, typer.Option(help="Speed at which the ball is to leave the hand, m/s.")] = None,
    angle: Annotated[
        float | None, typer.Option(help="Angle above the horizontal at which it is to leave the hand, degrees.")
    ] = None,
    flight_time: Annotated[float | None, typer.Option(help="Time from the release to the target's height, s.")] = None,
    release: Annotated[
        float | None, typer.Option(help="Time of release, s; by default the one that suits the goal best.")
    ] = None,
    adapt: Annotated[
        int | None, typer.Option(min=1, help="How many synergies' signals may change for a new throw; else all.")
    ] = None,
    solutions: Annotated[int, typer.Option(min=1, max=20, help="Throws to find for each goal, unlike each other.")] = 1,
    scene: Arm = None,
    number: Number = None,
    emg: Emg = None,
    channel: Channels = None,
    low_pass: LowPass = None,
    prescribe: Prescribed = None,
    output: ResultFile = None,
    plot: Figure = None,
    device: Device = None,
    threads: Threads = None,
    seed: Seed = 0,
    trust: Trust = False,
    quantities: Quantities = None,
    single: Single = False,
) -> int:
    """Throw a ball at a target: fit an arm to a known throw, and search for the signals that throw elsewhere.

    The arm is that of `throw fit`, with a ball in its hand: throw18_ball, or throw_ball with --emg. A new throw stays
    overhead: the hand is above the shoulder when it lets go, and no joint passes its limits till then.

    Exit codes: 0; where new throws miss a part of their goals 1 (distance), 3 (speed), 4 (angle), 5 (time of flight), 7
    (limits of joints) or 6 (several of these), with files written all the same; 2 if an input cannot be used; 130
    after Ctrl-C, with the throws that were complete written.

    Examples: warpmuscle throw goal --target 2 --target 4; warpmuscle throw goal throws/*.csv --target 3 --angle 30
    """
    from warpmuscle.throw.job import Job, JobOptions

    check_files(output, plot)
    goals = _goals(target or [], height or 0.0, speed, angle, flight_time)
    if not goals:
        raise Error("name a goal: --target, --speed, --angle or --flight-time")
    check_synergies(emg, channel, False, number)
    check_needed({"--low-pass": low_pass}, files, "files with motions")
    loaded = load_arm(scene or ("throw18_ball" if emg is None else "throw_ball"), device)
    options = JobOptions(
        count=number, prescribed=tuple(prescribe or ()), emg=emg, channels=pairs(channel), low_pass=low_pass,
        device=device, threads=threads, seed=seed,
    )  # fmt: skip
    job = Job(loaded, files or [], options)
    if release is not None:
        job.check_release(release)
    print_problem(job)
    interrupted = False
    try:
        fit(job)
        assert job.fitted is not None
        print_fit(job, job.fitted)
        _throw(job, goals, release, adapt, solutions)
    except KeyboardInterrupt:
        interrupted = True
        tell_kept(job, len(goals) * solutions)
        if job.fitted is None:
            raise
    write_files(job, output, plot, None, seed, quantities, single)
    return INTERRUPTED if interrupted else exit_code(job.throws)


def exit_code(throws: Sequence[Throw]) -> int:
    """What of the goals was missed."""
    missed = {name for made in throws for name in made.missed}
    return 0 if not missed else MISSED[missed.pop()] if len(missed) == 1 else SEVERAL


def _goals(
    targets: Sequence[float], height: float, speed: float | None, angle: float | None, duration: float | None
) -> list[Goal]:
    from warpmuscle.throw.goals import Goal

    radians = None if angle is None else math.radians(angle)
    if not targets and speed is None and radians is None and duration is None:
        return []
    distances: list[float | None] = [*targets] or [None]
    return [Goal(distance, height, speed, radians, duration) for distance in distances]


def _throw(job: Job, goals: Sequence[Goal], release: float | None, adapt: int | None, solutions: int) -> None:
    """Make new throws, and print all that were made, also after Ctrl-C."""
    try:
        with log.status("throwing") as shown:
            job.throw(goals, release, adapt, solutions, progress=shown.update)
    finally:
        _print_throws(job)


def _print_throws(job: Job) -> None:
    for made in job.throws:
        flight, goal = made.flight, made.goal
        text = (
            f"{goal}: released after {made.release:.3g} s at {flight.speed[0]:.2f} m/s, "
            f"{math.degrees(flight.angle[0]):.1f} deg, the hand {100.0 * made.clearance:.0f} cm above the shoulder"
        )
        if math.isfinite(flight.distance[0]):
            text += f"; lands at {flight.distance[0]:.3f} m after {flight.duration[0]:.2f} s"
        out.print(f"{text}; signals changed by {made.change:.3f}, effort {made.effort:.4f}")
        if made.past_after:
            beyond = [f"{name} by {math.degrees(past):.1f} deg" for name, past in made.past_after.items()]
            log.print(marked("note:", "yellow", f" after the release joints reach their stops: {', '.join(beyond)}"))
        if not made.met:
            log.print(marked("missed:", "yellow", f" {_missed(job, made)}"))


def _missed(job: Job, made: Throw) -> str:
    """What a throw misses, and what may help."""
    from warpmuscle.throw.goals import NAMES

    text = f"no signals were found that throw {made.goal} overhead: {' and '.join(NAMES[name] for name in made.missed)}"
    if "limits" in made.missed:
        beyond = [f"{name} by {math.degrees(past):.1f} deg" for name, past in made.past_limits.items()]
        text += f"; beyond its limits moves {', '.join(beyond)}"
        text += "; another --seed may find a throw within them" if len(made.missed) == 1 else ""
    if made.lack:
        text += f"; {made.lack}"
    if len(made.synergies) < job.follower.synergies.count:
        text += f"; --adapt {job.follower.synergies.count} lets all signals change"
    return text
