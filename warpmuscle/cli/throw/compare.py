"""The command that fits recorded motions of an arm in several ways, and compares these."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import Device, Figure, Quantities, ResultFile, Single, Threads, Trust
from warpmuscle.cli.console import log, out
from warpmuscle.cli.throw.options import (
    FIDELITY,
    Arm,
    Calibrate,
    Channels,
    Emg,
    Fidelity,
    FitAll,
    LowPass,
    Motions,
    Number,
    Prescribed,
    Seed,
    check_files,
    check_synergies,
    fit,
    load_arm,
    pairs,
    write_files,
)
from warpmuscle.cli.throw.tables import print_curve, print_fit, print_problem, print_published, print_rows, tell_kept
from warpmuscle.core.errors import Error
from warpmuscle.core.interruption import INTERRUPTED
from warpmuscle.core.plain_text import number_of

if TYPE_CHECKING:
    from warpmuscle.scene import Scene
    from warpmuscle.throw.job import Job, JobOptions
    from warpmuscle.throw.report import TableRow

ENOUGH = 0.95  # of the motions that are to meet all bars


def compare(
    files: Motions,
    numbers: Annotated[
        tuple[int, int] | None,
        typer.Option(
            metavar="LEAST MOST",
            help="Fit with each of these numbers of synergies, and take the fewest that meet all bars.",
        ),
    ] = None,
    as_published: Annotated[
        bool, typer.Option("--as-published", help="Fit as Cruz Ruiz et al. 2015 did, each motion by itself.")
    ] = False,
    curve: Annotated[
        bool, typer.Option("--curve", help="Compare accuracy and fidelity to the extracted signals at several prices.")
    ] = False,
    scene: Arm = None,
    number: Number = None,
    emg: Emg = None,
    channel: Channels = None,
    calibrate: Calibrate = False,
    low_pass: LowPass = None,
    prescribe: Prescribed = None,
    fit_all: FitAll = False,
    fidelity: Fidelity = FIDELITY,
    output: ResultFile = None,
    plot: Figure = None,
    device: Device = None,
    threads: Threads = None,
    seed: Seed = 0,
    trust: Trust = False,
    quantities: Quantities = None,
    single: Single = False,
) -> int:
    """Compare fits of recorded motions: numbers of synergies, the published procedure, prices of fidelity.

    One of --numbers, --as-published and --curve says what is compared. The output holds the fit that was chosen.
    Exit codes: 0; 2 if an input cannot be used; 130 after Ctrl-C, with the fits that were complete written.

    Examples: warpmuscle throw compare throws/*.csv --numbers 4 6; warpmuscle throw compare throws/*.csv
    --as-published; warpmuscle throw compare lift.csv --emg syn.h5 --prescribe wrist --curve
    """
    from warpmuscle.throw.job import Job, JobOptions

    check_files(output, plot)
    if numbers is None and not as_published and not curve:
        raise Error("say what to compare: --numbers LEAST MOST, --as-published or --curve")
    if numbers is not None and number is not None:
        raise Error("name --number or --numbers, not both")
    check_synergies(emg, channel, calibrate, number if number is not None else numbers)
    if numbers is not None and not 1 <= numbers[0] <= numbers[1]:
        raise Error(f"--numbers go from one number of synergies to a greater, not from {numbers[0]} to {numbers[1]}")
    loaded = load_arm(scene or ("throw" if as_published or emg is not None else "throw18"), device)
    options = JobOptions(
        count=number, prescribed=tuple(prescribe or ()), emg=emg, channels=pairs(channel), calibrated=calibrate,
        fit_all=fit_all, fidelity=fidelity, low_pass=0.0 if as_published and low_pass is None else low_pass,
        device=device, threads=threads, seed=seed,
    )  # fmt: skip
    interrupted = False
    if numbers is None:
        job = Job(loaded, files, options)
    else:
        job, interrupted = _fewest(loaded, files, options, numbers)
    print_problem(job)
    interrupted = _compare(job, as_published, curve, interrupted) or interrupted
    write_files(job, output, plot, None, seed, quantities, single)
    return INTERRUPTED if interrupted else 0


def _compare(job: Job, as_published: bool, curve: bool, interrupted: bool) -> bool:
    """Fit in the ways that were asked for, and print the results; whether Ctrl-C ended that."""
    try:
        if as_published:
            print_published(job)
        if job.fitted is None and (not as_published or curve):
            fit(job)
        if job.fitted is not None:
            print_fit(job, job.fitted)
        if curve and not interrupted:
            print_curve(job)
    except KeyboardInterrupt:
        tell_kept(job, 0)
        if job.fitted is None and job.published is None:
            raise
        return True
    return False


def _fewest(scene: Scene, files: Sequence[Path], options: JobOptions, numbers: tuple[int, int]) -> tuple[Job, bool]:
    """A job fitted with the fewest synergies that follow all motions but one in twenty, or with the most.

    And whether Ctrl-C ended this, which leaves the numbers whose fits were complete.
    """
    from dataclasses import replace

    from warpmuscle.throw.job import Job
    from warpmuscle.throw.report import number_row

    rows: list[TableRow] = []
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
        log.print(f"done so far: {done}; the same command starts again")
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
