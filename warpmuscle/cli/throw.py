"""The command that fits muscles and synergies to recorded motions of an arm, and makes new throws."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import (
    Device,
    Quantities,
    Single,
    Threads,
    Trust,
    command_line,
    load_scene,
    quantities_in,
    scene_names_like,
    start_warp,
    writable,
)
from warpmuscle.cli.console import log, marked, out
from warpmuscle.cli.throw_tables import print_curve, print_fit, print_problem, print_published, print_rows, tell_kept
from warpmuscle.core.errors import Error
from warpmuscle.core.interruption import INTERRUPTED
from warpmuscle.core.plain_text import number_of
from warpmuscle.simulation.cuda_warmup import start_driver

# Exit codes where new throws miss a part of their goals; several parts are SEVERAL.
MISSED, SEVERAL = {"distance": 1, "speed": 3, "angle": 4, "duration": 5, "limits": 7}, 6

ENOUGH = 0.95  # of the motions that are to meet all bars

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from warpmuscle.scene import Scene
    from warpmuscle.throw.goals import Goal
    from warpmuscle.throw.job import Job, Options
    from warpmuscle.throw.report import Row
    from warpmuscle.throw.synthesis import Throw


def throw(
    files: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[MOTION]...", help="CSV, .mot, .sto or .npz files with times and joint angles."),
    ] = None,
    scene: Annotated[
        str | None,
        typer.Option(
            help="The arm: a shipped scene or a TOML file; by default throw18; with --as-published or --emg "
            "the six pulley muscles of throw; for a goal the same with a ball, throw18_ball or throw_ball.",
            autocompletion=scene_names_like,
        ),
    ] = None,
    number: Annotated[
        int | None,
        typer.Option(
            "--number",
            "-n",
            min=1,
            help="How many synergies to compute; else 5, or two a joint and one beyond three joints.",
        ),
    ] = None,
    numbers: Annotated[
        tuple[int, int] | None,
        typer.Option(
            metavar="LEAST MOST", help="Fit with each of these numbers of synergies, and take the fewest that do."
        ),
    ] = None,
    emg: Annotated[
        Path | None, typer.Option(help="HDF5 file of `warpmuscle synergies`, in place of computed synergies.")
    ] = None,
    channel: Annotated[
        list[str] | None, typer.Option(metavar="MUSCLE=CHANNEL", help="Which channel of --emg stands for a muscle.")
    ] = None,
    calibrate: Annotated[
        bool,
        typer.Option("--calibrate", help="Find gains and delays of the channels of --emg, together with the muscles."),
    ] = False,
    low_pass: Annotated[
        float | None,
        typer.Option(
            min=0.0,
            help="Low-pass recorded motions at so many Hz; 0 for none. By default only where they are noisy, at a "
            "cut-off found by residual analysis, and never with --as-published.",
        ),
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
    height: Annotated[float | None, typer.Option(help="Height of the target above the ground, m; else 0.")] = None,
    speed: Annotated[float | None, typer.Option(help="Speed at which the ball is to leave the hand, m/s.")] = None,
    angle: Annotated[float | None, typer.Option(help="Its angle above the horizontal, degrees.")] = None,
    flight_time: Annotated[float | None, typer.Option(help="Time from the release to the target's height, s.")] = None,
    release: Annotated[
        float | None, typer.Option(help="Time of release, s; by default the one that suits the goal best.")
    ] = None,
    adapt: Annotated[
        int | None, typer.Option(min=1, help="How many synergies' signals may change for a new throw; else all.")
    ] = None,
    solutions: Annotated[
        int | None, typer.Option(min=1, max=20, help="Throws to find for each goal, unlike each other; else 1.")
    ] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="HDF5 file to write.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Figure to draw, .png, .svg or .pdf.")] = None,
    plot_each: Annotated[
        Path | None, typer.Option(help="Folder for a figure of each motion, with muscles and the flight of a ball.")
    ] = None,
    device: Device = None,
    threads: Threads = None,
    seed: Annotated[int, typer.Option(min=0, help="Of random starts.")] = 0,
    trust: Trust = False,
    quantities: Quantities = None,
    single: Single = False,
) -> int:
    """Fit an arm's muscles and synergies to recorded motions and replay them, or throw a ball at a target.

    A MOTION has columns time_s and, for each joint, shoulder_deg, elbow_deg, wrist_deg (or _rad; also
    shoulder_flexion_deg and so on). Read as well, and taken to be 0 where they are missing: trunk_pitch_deg, how far
    the trunk leans forwards, or shoulder_flexion_gravity_deg, the upper arm's angle to gravity, from which that
    follows; shoulder_forward_m and shoulder_up_m, the shoulder's place.

    A new throw stays overhead: the hand is above the shoulder when it lets go, and no joint passes its limits till
    then. Exit
    codes: 0; where new throws miss a part of their goals 1 (distance), 3 (speed), 4 (angle), 5 (time of flight), 7
    (limits of joints) or 6 (several of these), with files written all the same; 2 if an input cannot be used; 130
    after Ctrl-C, with what had come to its end written.

    Examples: warpmuscle throw throws/*.csv -o throw.h5; warpmuscle throw serve.csv --prescribe shoulder;
    warpmuscle throw lift.csv --emg syn.h5 --prescribe wrist --curve; warpmuscle throw --target 2 --target 4
    """
    from warpmuscle.core.extras import need
    from warpmuscle.throw.job import Job, Options

    writable(output, plot)
    if emg is None or calibrate:
        need("sklearn", "synergies of motions need")
    if plot_each is not None:
        need("matplotlib", "figures need")
    if plot is not None:
        from warpmuscle.plots.style import check_picture

        check_picture(plot)
        if output is not None and plot.resolve() == output.resolve():
            raise Error(f"--output and --plot both name {plot}")
    if plot_each is not None and plot_each.exists() and not plot_each.is_dir():
        raise Error(f"--plot-each names {plot_each}, which is no folder")
    if not files and not target and speed is None and angle is None and flight_time is None:
        raise Error("nothing to do: name files with motions, or a goal such as --target 4")
    goals = _goals(target or [], height or 0.0, speed, angle, flight_time)
    _check_needed({"--channel": channel, "--calibrate": calibrate}, emg, "--emg")
    _check_needed({"--height": height, "--release": release, "--adapt": adapt, "--solutions": solutions}, goals,
                  "a goal such as --target 4")  # fmt: skip
    _check_needed({"--low-pass": low_pass}, files, "files with motions")
    if emg is not None and (number is not None or numbers is not None):
        raise Error("--number is for computed synergies; --emg brings its own")
    if numbers is not None and not 1 <= numbers[0] <= numbers[1]:
        raise Error(f"--numbers go from one number of synergies to a greater, not from {numbers[0]} to {numbers[1]}")
    start_driver(device)
    loaded = load_scene([scene or _usual_scene(bool(goals), as_published, emg is not None)])
    start_warp()
    if as_published and low_pass is None:
        low_pass = 0.0
    options = Options(
        count=number, prescribed=tuple(prescribe or ()), emg=emg, channels=_pairs(channel or []), calibrated=calibrate,
        fit_all=fit_all,
        fidelity=fidelity, low_pass=low_pass, device=device, threads=threads, seed=seed,
    )  # fmt: skip
    interrupted = False
    if numbers is None:
        job = Job(loaded, files or [], options)
    else:
        job, interrupted = _fewest(loaded, files or [], options, numbers)
    if release is not None:
        job.check_release(release)
    print_problem(job)
    try:
        if as_published:
            print_published(job)
        if job.fitted is None and (not as_published or goals or curve):
            _fit(job)
        if job.fitted is not None:
            print_fit(job, job.fitted)
        if curve and job.fitted is not None and not interrupted:
            print_curve(job)
        if goals and job.fitted is not None and not interrupted:
            _throw(job, goals, release, adapt, solutions or 1)
    except KeyboardInterrupt:
        interrupted = True
        tell_kept(job, len(goals) * (solutions or 1))
        if job.fitted is None and job.published is None:
            raise
    fitted, throws = job.fitted, job.throws
    if output is not None:
        job.write(output, {"command": command_line(), "seed": seed}, quantities_in(quantities), single)
        out.print(f"wrote {output}")
    if plot is not None:
        from warpmuscle.throw.motion_plot import draw_result

        draw_result(plot, job.follower, fitted, job.published, throws)
        out.print(f"wrote {plot}")
    if plot_each is not None and not (interrupted and fitted is None):
        from warpmuscle.throw.motion_plot import draw_each

        if fitted is None:
            raise Error("--plot-each draws fitted motions; leave out --as-published")
        draw_each(plot_each, job.follower, fitted)
        out.print(f"wrote {number_of(len(job.motions), 'figure')} to {plot_each}")
    return INTERRUPTED if interrupted else exit_code(throws)


def _usual_scene(goals: bool, as_published: bool, measured: bool) -> str:
    """Eighteen muscles, which five synergies bind, with a ball for goals; six on pulleys where they are asked for."""
    usual = "throw" if as_published or measured else "throw18"
    return f"{usual}_ball" if goals else usual


def exit_code(throws: Sequence[Throw]) -> int:
    """What of the goals was missed."""
    missed = {name for made in throws for name in made.missed}
    return 0 if not missed else MISSED[missed.pop()] if len(missed) == 1 else SEVERAL


def _check_needed(options: Mapping[str, object], given: object, what: str) -> None:
    """Error if one of these options is given without what it is for."""
    for name, value in options.items():
        if value and not given:
            raise Error(f"{name} is of use only with {what}")


def _pairs(texts: Sequence[str]) -> dict[str, str]:
    pairs = {}
    for text in texts:
        muscle, equals, name = text.partition("=")
        if not equals or not muscle or not name:
            raise Error(f"--channel {text!r}: say MUSCLE=CHANNEL")
        pairs[muscle.strip()] = name.strip()
    return pairs


def _goals(
    targets: Sequence[float], height: float, speed: float | None, angle: float | None, duration: float | None
) -> list[Goal]:
    from warpmuscle.throw.goals import Goal

    radians = None if angle is None else math.radians(angle)
    if not targets and speed is None and radians is None and duration is None:
        return []
    distances: list[float | None] = [*targets] or [None]
    return [Goal(distance, height, speed, radians, duration) for distance in distances]


def _fewest(scene: Scene, files: Sequence[Path], options: Options, numbers: tuple[int, int]) -> tuple[Job, bool]:
    """A job fitted with the fewest synergies that follow all motions but one in twenty, or with the most.

    And whether Ctrl-C ended this, which leaves the numbers whose fits had come to their end.
    """
    from dataclasses import replace

    from warpmuscle.throw.job import Job
    from warpmuscle.throw.report import number_row

    rows: list[Row] = []
    chosen: Job | None = None
    last: Job | None = None
    interrupted = False
    try:
        with log.status("fitting") as shown:
            for count in range(numbers[0], numbers[1] + 1):
                shown.update(f"fitting {number_of(count, 'synergy')}")
                job = Job(scene, files, replace(options, count=count))
                fitted = job.fit()
                rows.append(number_row(job.follower, fitted))
                last = job
                if chosen is None and fitted.agreement.good().mean() >= ENOUGH:
                    chosen = job
    except KeyboardInterrupt:
        interrupted = True
        done = f"{len(rows)} of {number_of(numbers[1] - numbers[0] + 1, 'number')} of synergies"
        log.print(f"done so far: {done}; the same command begins anew")
        if last is None:
            raise
    assert last is not None
    headings = ["VAF", "largest share", *(f"{joint} r2" for joint in last.arm.driven)]
    headings += ["lowest r2", "velocity r2", "hand, cm", "correlation", "all bars"]
    print_rows("by number of synergies: medians and the worst of all motions", headings, rows)
    if chosen is None:
        out.print(f"no number up to {last.count} meets all bars; this is the fit with {last.count}")
        return last, interrupted
    out.print(f"the fewest that meet all bars: {number_of(chosen.count, 'synergy')}")
    return chosen, interrupted


def _fit(job: Job) -> None:
    """Fit, and print what an interrupted fit had come to."""
    try:
        with log.status("fitting") as shown:
            job.fit(lambda stage: shown.update(f"fitting {stage}"))
    except KeyboardInterrupt:
        if job.fitted is not None:
            print_fit(job, job.fitted)
        raise


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
            log.print(marked("note:", "yellow", f" behind the release joints come to their stops: {', '.join(beyond)}"))
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
