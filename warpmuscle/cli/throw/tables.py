"""What the command `throw` prints of a problem, of fits and of what is left of them after Ctrl-C."""

from __future__ import annotations

from typing import TYPE_CHECKING

from warpmuscle.cli.console import log, marked, out, print_table
from warpmuscle.core.plain_text import number_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from warpmuscle.throw.fit import Fitted
    from warpmuscle.throw.job import Job
    from warpmuscle.throw.missing_torque import Lack
    from warpmuscle.throw.report import TableRow


def print_problem(job: Job) -> None:
    """What is to be fitted, and what the muscles lack for it."""
    from warpmuscle.throw.computed_synergies import COMPUTED

    motions, synergies, arm = job.motions, job.follower.synergies, job.arm
    kind = "computed by static optimisation of the same motions, not EMG"
    kind = kind if synergies.source == COMPUTED else synergies.source
    out.print(
        f"{number_of(len(motions), 'motion')} of {motions.time[-1]:.3g} s, muscles on "
        f"{', '.join(arm.driven)}; {number_of(synergies.count, 'synergy')} ({kind}), VAF {synergies.explained:.4f}"
    )
    for note in job.notes():
        log.print(marked("note:", "yellow", f" {note}"))
    _print_calibration(job)
    whose = "the muscle groups that compute activations" if job.strong is not job.arm else "the muscles"
    _print_lacks("before the fit:", job, job.lacks, whose)


def _print_calibration(job: Job) -> None:
    """What was found of the channels and the muscles, if that was asked for."""
    from warpmuscle.throw.report import calibration_rows

    if job.calibration is None:
        return
    found = job.calibration
    headings = ["gain", "delay, ms", "f_max, N", "calibrated", "l_slack, mm", "calibrated"]
    print_rows("channels and muscles, calibrated to the torques", headings, calibration_rows(job.arm, found))
    before, after = (" ".join(f"{value:.3f}" for value in row) for row in found.torque_r2)
    out.print(
        f"torques of {', '.join(job.arm.driven)}: r2 {before}, calibrated {after}; mean square activation "
        f"{found.effort[0]:.4f}, calibrated {found.effort[1]:.4f}"
    )


def _print_lacks(when: str, job: Job, lacks: Sequence[Lack], whose: str) -> None:
    from warpmuscle.throw.missing_torque import shortcoming

    text = shortcoming(job.arm, lacks, len(job.motions), whose)
    if text:
        log.print(marked(when, "yellow", f" {text}"))


def print_published(job: Job) -> None:
    from warpmuscle.throw.report import PAPER, published_rows

    headings = [*(f"{joint} r2" for joint in job.arm.driven), "time"]
    with log.status("fitting as published") as shown:
        if len(job.motions) > 1 and job.options.emg is None:
            mean = job.publish_mean()
            print_rows("as published, mean motion", headings, published_rows(mean))
        result = job.publish(lambda stage: shown.update(f"fitting as published: {stage}"))
    title = "as published, median (worst) of each motion fitted by itself" if len(job.motions) > 1 else "as published"
    print_rows(title, headings, published_rows(result))
    out.print(f"Cruz Ruiz et al. 2015: after parameters {' '.join(PAPER['parameters'])}, after signals "
              f"{' '.join(PAPER['signals'])} (shoulder, elbow, wrist)")  # fmt: skip


def print_fit(job: Job, fitted: Fitted) -> None:
    import numpy as np

    from warpmuscle.throw.report import baseline_row, stage_rows, synergy_rows

    headings = [f"{joint} r2" for joint in job.arm.driven]
    headings += ["lowest r2", "velocity r2", "least", "hand, cm (most)", "correlation (least)", "all bars"]
    if job.held_out:
        headings.append("held out")
    rows = stage_rows(fitted.stages, job.held_out)
    baseline = baseline_row(job.follower)
    print_rows("better fit, medians over motions", [*headings, "time"], [*([baseline] if baseline else []), *rows])
    good, a = fitted.agreement.good(), fitted.agreement
    columns = ["with the extracted (least)", "with other motions'", "difference (least)"]
    print_rows("correlation of signals by synergy, medians over motions", columns, synergy_rows(a))
    for k in (~good).nonzero()[0] if len(job.motions) > 1 else []:
        out.print(
            f"  {job.motions.names[k]}: r2 {a.r2[k].min():.4f}, velocity r2 {a.velocity_r2[k].min():.3f}, "
            f"hand {100.0 * a.hand_error[k]:.1f} cm, correlation {a.correlation[k]:.3f}"
            + ("" if a.null is None else f", least lead of a synergy over other motions {np.nanmin(a.lead[k]):+.3f}")
        )
    _print_lacks("beyond the arm:", job, job.final_lacks(), "the fitted muscles")


def print_rows(title: str, headings: Sequence[str], rows: Sequence[TableRow]) -> None:
    """A table with a title."""
    print_table(["", *headings], [(row.name, *row.cells) for row in rows], [""], title)


def print_curve(job: Job) -> None:
    """Accuracy against fidelity to the extracted signals."""
    import numpy as np

    from warpmuscle.throw.report import TableRow

    headings = ["correlation", *(f"{joint} r2" for joint in job.arm.driven), "lowest r2"]
    rows = []
    with log.status("fitting at several prices"):
        for price, a in job.curve():
            middle = [f"{value:.4f}" for value in np.median(a.r2, axis=0)]
            rows.append(TableRow(f"{price:g}", (f"{np.nanmedian(a.correlation):.3f}", *middle, f"{a.r2.min():.4f}")))
    print_rows("accuracy against fidelity, by its price", headings, rows)


def tell_kept(job: Job, wanted: int) -> None:
    """Say after Ctrl-C what had finished.

    Args:
        wanted: how many new throws were.
    """
    done = []
    if job.published is not None:
        done.append("the fit as published")
    if job.fitted is not None:
        done.append("the fit" if job.fitted.complete else f"the fit up to its stage {job.fitted.stages[-1].name!r}")
    if wanted and job.throws:
        done.append(f"{len(job.throws)} of {number_of(wanted, 'new throw')}")
    log.print(f"done so far: {', '.join(done) or 'no stage of the fit'}; the same command starts again")
