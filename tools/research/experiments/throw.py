"""Figures 5 and 7 to 12 of Cruz Ruiz et al. 2015 from recorded motions, and how far corrupted signals can be fitted.

For docs/explanation/throwing.md.

    python tools/research/experiments/throw.py throws/*.csv -o figures
    python tools/research/experiments/throw.py throws/*.csv -o figures --corrupted

`curves.png` (5), `synergies.png` (7 and 8), `published.png` (9, 10 and 12), `signals.png` (11 and 12), `trade.png`
(accuracy against fidelity), `targets.png` (balls thrown at targets). `--corrupted` fits signals with gains, shifts,
noise and floors of all sizes, and prints what each fit came to.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
import warp as wp
from common import COLORS, STYLE, plt
from scipy.ndimage import gaussian_filter1d

from warpmuscle.cli.ending import run_script
from warpmuscle.core.array_types import Floats
from warpmuscle.formats import load
from warpmuscle.kernels.curve import curves
from warpmuscle.throw.arm import Arm
from warpmuscle.throw.computed_synergies import computed_excitation, factorized
from warpmuscle.throw.fit import fit_motions
from warpmuscle.throw.follow import Follower
from warpmuscle.throw.goals import Goal
from warpmuscle.throw.job import Job, JobOptions
from warpmuscle.throw.motion import RATE
from warpmuscle.throw.plot import draw_fit, draw_throws
from warpmuscle.throw.published import Published

# Gains, shift (s, positive: early), noise and floor, each in parts of an activation.
CORRUPTIONS = {
    "clean": (0.0, 0.0, 0.0, 0.0),
    "mild": (0.3, 0.0, 0.15, 0.02),
    "middle": (0.6, 0.04, 0.3, 0.05),
    "hard, early": (0.6, 0.06, 0.6, 0.1),
    "hard, late": (0.6, -0.06, 0.6, 0.1),
}


def trade_figure(path: Path, correlation: Floats, r2: Floats) -> None:
    """Accuracy, 1 - r2 of the least followed joint, over the correlation with the extracted signals."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(6.0, 4.0), layout="constrained")
        axes.semilogy(correlation, np.maximum(1.0 - r2, 1e-7), marker="o", color=COLORS[0])
        axes.set_xlabel("correlation of fitted with extracted signals")
        axes.set_ylabel("1 - r2, least followed joint")
        figure.savefig(path, dpi=140)


def curve_figure(path: Path) -> None:
    """Active and passive force over length, and force over velocity, of the arm's muscles."""
    model = curves.THELEN_EXPLICIT
    x = wp.array(np.linspace(0.4, 1.7, 200), dtype=float)
    v = wp.array(np.linspace(-1.0, 1.0, 200), dtype=float)
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(7.0, 2.6), layout="constrained")
        axes[0].plot(x.numpy(), wp.map(curves.active_force_length, model, x).numpy(), color=COLORS[0], label="active")
        axes[0].plot(x.numpy(), wp.map(curves.passive_force_length, model, x).numpy(), color=COLORS[1], label="passive")
        axes[0].set(title="force over length", xlabel="fibre length / optimal", ylim=(0.0, 1.6))
        axes[0].legend()
        axes[1].plot(v.numpy(), wp.map(curves.force_velocity, model, v, 1.0).numpy(), color=COLORS[0])
        axes[1].set(title="force over velocity", xlabel="fibre velocity / greatest, lengthening > 0")
        figure.savefig(path, dpi=140)


def synergy_figure(path: Path, job: Job) -> None:
    """Synergies, and their signals along all motions one after the other."""
    synergies, motions = job.follower.synergies, job.motions
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(
            synergies.count, 2, figsize=(10.0, 1.2 * synergies.count), layout="constrained", width_ratios=[1.0, 3.0],
            sharex="col", squeeze=False,
        )  # fmt: skip
        long = np.concatenate([synergies.signals[k][motions.valid[k] > 0.0] for k in range(len(motions))])
        for k, (left, right) in enumerate(axes):
            left.bar(job.arm.muscles, synergies.weights[:, k], color=COLORS[k % len(COLORS)])
            left.set(title=f"w{k + 1}", ylim=(0.0, 1.05))
            right.plot(np.arange(len(long)) / RATE, long[:, k], color=COLORS[k % len(COLORS)], linewidth=0.9)
            right.set(title=f"C{k + 1}, computed from the motions", ylim=(0.0, 1.0))
            left.set_ylabel("weight (1)")
        axes[-1, 1].set_xlabel("time of all motions one after the other (s)")
        figure.savefig(path, dpi=140)


def published_figure(path: Path, job: Job, result: Published, motion: int = 0) -> None:
    """Recorded and simulated angles of a motion after every stage of the published procedure."""
    stages = [stage for stage in result.stages if stage.replay is not None]
    inside, time = job.motions.valid[motion] > 0.0, job.motions.time
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(
            len(job.arm.driven), len(stages), figsize=(2.9 * len(stages), 1.9 * len(job.arm.driven)), sharex=True,
            sharey="row", squeeze=False, layout="constrained",
        )  # fmt: skip
        for row, column in enumerate(job.arm.free):
            for panel, stage in zip(axes[row], stages, strict=True):
                recorded = np.degrees(job.motions.angles[0][motion][inside, column])
                panel.plot(time[inside], recorded, color="#222222", linewidth=2.6, alpha=0.35)
                simulated: Any = stage.replay
                panel.plot(time[inside], np.degrees(simulated.angle[motion][inside, column]), color=COLORS[1])
                panel.set_title(f"{job.arm.joints[column]}, r2 {stage.r2[motion, row]:.3f}\n{stage.name}")
                panel.set_ylim(recorded.min() - 40.0, recorded.max() + 40.0)
            axes[row, 0].set_ylabel("flexion (deg)")
        for panel in axes[-1]:
            panel.set_xlabel("time (s)")
        figure.savefig(path, dpi=140)


def corrupted(excitation: np.ndarray, kind: str, seed: int = 1) -> np.ndarray:
    """Excitations (n, T, M) with false gains, shifted, noisy, and never at rest."""
    gain, shift, noise, floor = CORRUPTIONS[kind]
    rng = np.random.default_rng(seed)
    samples = np.arange(excitation.shape[1]) + round(shift * RATE)
    values = excitation[:, np.clip(samples, 0, excitation.shape[1] - 1)]
    values = values * (1.0 + gain * rng.uniform(-1.0, 1.0, excitation.shape[2]))
    slow, slower = (gaussian_filter1d(rng.standard_normal(values.shape), width, axis=1) for width in (8, 15))
    slow *= np.sqrt(2.0 * 8.0 * np.sqrt(np.pi))  # of unit variance
    return np.clip(values * np.exp(noise * slow) + floor * (1.0 + 3.5 * slower), 0.0, 1.0)


def corruption_table(job: Job, strong: Arm) -> None:
    """Fit corrupted signals and print what the fits came to."""
    activation, excitation, _ = computed_excitation(strong, job.motions)
    for kind in CORRUPTIONS:
        signals = corrupted(excitation, kind)
        start = activation[:, 0] if kind == "clean" else signals[:, 0]
        synergies = factorized(job.arm, job.motions, signals, start, job.count, kind)
        follower = Follower(job.arm, job.motions, synergies, job.follower.knots)
        a = fit_motions(follower, job.start, job.training, job.settings).agreement
        close = a.r2.min(axis=1) >= 0.99
        print(
            f"{kind:12s} VAF {synergies.explained:.3f}  r2 >= 0.99 on {close.sum()} of {len(close)}, held out "
            f"{close[job.held_out].sum()} of {len(job.held_out)}; lowest r2 {np.round(a.r2.min(axis=0), 4)}, all bars "
            f"{a.good().sum()}, correlation {np.median(a.correlation):.3f} ({a.correlation.min():.3f})",
            flush=True,
        )


def main(
    files: Annotated[list[Path], typer.Argument(help="Motions, as `warpmuscle throw fit` takes them.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the figures.")] = Path("figures"),
    only_corrupted: Annotated[
        bool, typer.Option("--corrupted", help="Fit corrupted signals, without figures.")
    ] = False,
) -> None:
    """Draw all figures, or fit corrupted signals."""
    job = Job(load("throw"), files, JobOptions())
    if only_corrupted:
        corruption_table(job, job.strong)
        return
    output.mkdir(parents=True, exist_ok=True)
    curve_figure(output / "curves.png")
    synergy_figure(output / "synergies.png", job)
    published = job.publish()
    published_figure(output / "published.png", job, published)
    fitted = job.fit()
    draw_fit(output / "signals.png", job.follower, fitted, published)
    trade = [a for _, a in job.curve()]
    worst = np.array([np.median(a.r2.min(axis=1)) for a in trade])
    trade_figure(output / "trade.png", np.array([np.median(a.correlation) for a in trade]), worst)
    ball = Job(load("throw_ball"), [], JobOptions())
    ball.fit()
    throws = ball.throw([Goal(distance=distance) for distance in (2.0, 4.0, 7.0)])
    draw_throws(output / "targets.png", ball.follower, throws)
    for throw in throws:
        print(f"{throw.goal.distance:g} m: lands at {throw.flight.distance[0]:.3f} m")


if __name__ == "__main__":
    run_script(main)
