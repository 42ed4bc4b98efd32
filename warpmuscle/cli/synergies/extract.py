"""The command that extracts muscle synergies from electromyograms."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from warpmuscle.cli.common import Figure, ResultFile, command_line, writable
from warpmuscle.cli.console import log, marked, out
from warpmuscle.core.plain_text import number_of

if TYPE_CHECKING:
    from warpmuscle.synergy.cross_validation import Prediction
    from warpmuscle.synergy.files import SynergyResult


Recordings = Annotated[
    list[Path], typer.Argument(metavar="EMG...", help="CSV, .mot, .sto, HDF5 or C3D files, joined in this order.")
]
Number = Annotated[
    str,
    typer.Option(
        "--number",
        "-n",
        help="How many synergies; knee: from where on r2 grows in a straight line; auto: the fewest that reach "
        "--vaf and --muscle-vaf, or the knee if they ask for many more; cross: by cross-validation.",
    ),
]
Channels = Annotated[
    str | None, typer.Option(help="Names or patterns of the channels, separated by commas, such as 'env_*,BIC'.")
]
Vaf = Annotated[float, typer.Option(help="Variance to account for, of all muscles, for -n auto.")]
MuscleVaf = Annotated[float, typer.Option(help="The same for each muscle.")]
Band = Annotated[tuple[float, float] | None, typer.Option(metavar="LOW HIGH", help="Band-pass, Hz; by default 10 450.")]
LowPass = Annotated[float, typer.Option(help="Low-pass after rectification, Hz; for gait 20 is usual.")]
Order = Annotated[int, typer.Option(help="Order of one pass of each Butterworth filter.")]
AlreadyFiltered = Annotated[
    bool, typer.Option("--already-filtered", help="The files hold envelopes, at the rate that is wanted.")
]
SamplingRate = Annotated[float | None, typer.Option(help="Samples per second of files without times.")]
Rate = Annotated[
    float | None, typer.Option(help="Activations a second; by default 100, or as the files if already filtered.")
]
Ecg = Annotated[
    str | None,
    typer.Option(
        metavar="auto|CHANNEL",
        help="Remove the heart's signal: components with regular beats, or that go with an ECG channel.",
    ),
]
TimeWindow = Annotated[
    tuple[float, float] | None, typer.Option(metavar="BEGIN END", help="Part of each recording to use, s.")
]
Cycles = Annotated[
    list[Path] | None,
    typer.Option(
        help="CSV with the start of each cycle, and of its second phase if there is "
        "another column, s; one for each recording."
    ),
]
CycleRange = Annotated[
    tuple[int, int] | None, typer.Option(metavar="FIRST LAST", help="Cycles to use, counted from 1.")
]
Points = Annotated[int, typer.Option(help="Points of a cycle, shared out equally among its phases.")]
SubtractMinimum = Annotated[bool, typer.Option("--subtract-minimum", help="Subtract each channel's minimum from it.")]
Mvc = Annotated[
    Path | None,
    typer.Option(help="Recording of maximum voluntary contractions to normalise by, instead of the maxima."),
]
Like = Annotated[Path | None, typer.Option(help="HDF5 file of synergies that gives the order, and to compare with.")]
Restarts = Annotated[int, typer.Option(min=1, help="Factorisations of each number of synergies.")]
Seed = Annotated[int, typer.Option(min=0, help="Seed of the random starts.")]


def extract(
    recordings: Recordings,
    number: Number = "knee",
    output: ResultFile = None,
    plot: Figure = None,
    channels: Channels = None,
    vaf: Vaf = 0.95,
    muscle_vaf: MuscleVaf = 0.75,
    band: Band = None,
    low_pass: LowPass = 6.0,
    order: Order = 4,
    already_filtered: AlreadyFiltered = False,
    sampling_rate: SamplingRate = None,
    rate: Rate = None,
    ecg: Ecg = None,
    time_window: TimeWindow = None,
    cycles: Cycles = None,
    cycle_range: CycleRange = None,
    points: Points = 200,
    subtract_minimum: SubtractMinimum = False,
    mvc: Mvc = None,
    like: Like = None,
    restarts: Restarts = 10,
    seed: Seed = 0,
) -> None:
    """Extract muscle synergies from EMG: filter, normalise, factorise A(t) = W C(t), print what they account for.

    Examples: warpmuscle synergies extract throw.csv -n 5 -o syn.h5 --plot syn.png;
    warpmuscle synergies extract walk.csv --cycles strides.csv --band 50 450 --low-pass 20 -n knee
    """  # fmt: skip
    from warpmuscle.core.extras import need
    from warpmuscle.synergy.cross_validation import cross_validate
    from warpmuscle.synergy.emg import Chain
    from warpmuscle.synergy.extraction import CROSS, Rule, largest, reason
    from warpmuscle.synergy.extraction import extract as extracted
    from warpmuscle.synergy.files import SynergyResult, described, in_order_of, read, write
    from warpmuscle.synergy.preparation import Preparation, prepare

    writable(output, plot)
    need("sklearn", "synergies need")
    rule = Rule.of(number, vaf, muscle_vaf)
    preparation = Preparation(
        channels=tuple(name.strip() for name in channels.split(",") if name.strip()) if channels else (),
        sampling_rate=sampling_rate,
        chain=Chain(band or (10.0, 450.0), low_pass, order),
        already_filtered=already_filtered,
        ecg=ecg or "",
        window=time_window,
        rate=rate if rate is not None or already_filtered else 100.0,
        cycles=tuple(cycles or ()),
        cycle_range=cycle_range,
        points=points,
        subtract_minimum=subtract_minimum,
        maxima=mvc,
    )
    reference = None if like is None else read(like)
    with log.status("reading and filtering") as shown:
        activations = prepare(recordings, preparation)
        prediction = None
        if rule.method == CROSS:
            prediction = cross_validate(
                activations.values, largest(len(activations.muscles)), seed,
                lambda count: shown.update(f"cross-validating, {number_of(count, 'synergy')}"),
            )  # fmt: skip
            rule = replace(rule, count=prediction.count)
        found, accounts = extracted(
            activations.values,
            rule,
            restarts,
            seed,
            lambda count: shown.update(f"factorising, {number_of(count, 'synergy')}"),
        )
    similarity = None
    if reference is not None:
        found, similarity = in_order_of(reference, activations.muscles, found)
    attributes = {"command": command_line(), "seed": seed, **described(preparation)}
    result = SynergyResult(activations, found, tuple(accounts), similarity, attributes)
    _print(result, prediction)
    if why := reason(accounts, rule, found.account.count, activations.muscles):
        log.print(marked("note:", "yellow", f" {why}"))
    if output is not None:
        write(output, result)
        out.print(f"wrote {output}")
    if plot is not None:
        from warpmuscle.plots.synergies import draw_synergies

        draw_synergies(plot, activations, found, accounts)
        out.print(f"wrote {plot}")


def _print(result: SynergyResult, prediction: Prediction | None) -> None:
    """Print what each number of synergies accounts for, and the synergies that were taken."""
    activations, account = result.activations, result.synergies.account
    for note in activations.notes:
        log.print(marked("note:", "yellow", f" {note}"))
    samples, muscles = activations.values.shape
    trials = len(set(activations.trial.tolist()))
    what = "cycle" if activations.time_unit == "cycle" else "recording"
    out.print(f"{number_of(muscles, 'channel')}, {number_of(samples, 'sample')} of {number_of(trials, what)}")
    table = Table("synergies", "VAF", "r2", "worst channel", "worst restart")
    if prediction is not None:
        table.add_column("error of prediction")
    for row in result.counts:
        worst = int(row.muscle_vaf.argmin())
        cells = [f"{row.count}", f"{row.vaf:.4f}", f"{row.r2:.4f}",
                 f"{row.muscle_vaf[worst]:.4f}  {activations.muscles[worst]}",
                 f"{row.restart_vaf.min():.4f}"]  # fmt: skip
        if prediction is not None and row.count <= len(prediction.error):
            cells.append(f"{prediction.error[row.count - 1]:.4f}")
        table.add_row(*cells, style="bold" if row.count == account.count else None)
    out.print(table)
    names = [f"w{k + 1}" for k in range(account.count)]
    table = Table(f"{number_of(account.count, 'synergy')}", *names, "VAF")
    for m, muscle in enumerate(activations.muscles):
        weights = [f"{weight:.3f}" for weight in result.synergies.weights[m]]
        table.add_row(muscle, *weights, f"{account.muscle_vaf[m]:.4f}")
    if result.similarity is not None:
        table.add_row("cosine", *(f"{cosine:.3f}" for cosine in result.similarity), style="italic")
    out.print(table)
    _print_timing(result)
    out.print(f"{number_of(account.count, 'synergy', 'account')} for {account.vaf:.4f} of the variance")


def _print_timing(result: SynergyResult) -> None:
    """Print when synergies are active, means and standard deviations over trials."""
    timing, cyclic = result.timing, result.activations.time_unit == "cycle"
    factor, unit = (100.0, "% of the cycle") if cyclic else (1.0, "s")
    table = Table("active", *(f"w{k + 1}" for k in range(result.synergies.account.count)))
    for name, mean, spread in (
        ("centre", timing.centre, timing.centre_spread),
        ("width at half of the maximum", timing.width, timing.width_spread),
    ):
        table.add_row(f"{name}, {unit}", *(f"{factor * value:.3g}" for value in mean))
        table.add_row("±", *(f"{factor * value:.2g}" for value in spread), style="dim")
    out.print(table)
