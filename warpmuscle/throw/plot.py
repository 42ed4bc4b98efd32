"""Figures of fits and throws, as figures 9 to 12 of Cruz Ruiz et al. 2015; needs matplotlib, the extra `plot`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.plots.style import matplotlib, save
from warpmuscle.throw.arm import hand_position, joint_positions, states
from warpmuscle.throw.fit import Fitted
from warpmuscle.throw.follow import Follower
from warpmuscle.throw.metrics import determination
from warpmuscle.throw.published import Published
from warpmuscle.throw.synthesis import Throw

RECORDED, SIMULATED, OTHER = "#222222", "#D55E00", "#0072B2"
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
STYLE: Any = {
    "font.size": 9.0, "axes.titlesize": 9.5, "axes.titlelocation": "left", "axes.spines.top": False,
    "axes.spines.right": False, "axes.linewidth": 0.8, "legend.frameon": False,
}  # fmt: skip
FRAMES = 7  # poses of the arm that are drawn


def draw_fit(
    path: str | Path, follower: Follower, fitted: Fitted | None, published: Published | None, motion: int = 0
) -> None:
    """Draw a motion's angles as recorded and simulated, and its signals as extracted and fitted.

    Raises:
        Error: matplotlib is not installed, or the file cannot be written.
    """
    arm, motions, synergies = follower.arm, follower.motions, follower.synergies
    inside = motions.valid[motion] > 0.0
    time = motions.time[inside]
    curves = []
    if published is not None:
        curves.append(("as published", published.replay.angle[motion], published.signals[motion], OTHER))
    if fitted is not None:
        signals = follower.knots.sampled(follower.shaped(fitted.individual))
        curves.append(("better fit", fitted.replay.angle[motion], signals[motion], SIMULATED))
    with matplotlib().rc_context(STYLE):
        count = max(len(arm.driven), synergies.count)
        figure = matplotlib().figure.Figure(figsize=(10.0, 1.0 + 1.35 * count), layout="constrained")
        left, right = figure.subfigures(1, 2, width_ratios=[1.0, 1.0])
        angles = left.subplots(len(arm.driven), 1, sharex=True, squeeze=False)[:, 0]
        for axes, column in zip(angles, arm.free, strict=True):
            recorded = motions.angles[0][motion][inside, column]
            axes.plot(time, np.degrees(recorded), color=RECORDED, linewidth=2.6, label="recorded", alpha=0.35)
            notes = []
            for name, angle, _, color in curves:
                axes.plot(time, np.degrees(angle[inside, column]), color=color, linewidth=1.2, label=name)
                r2 = determination(angle[None, inside, column, None], recorded[None, :, None], np.ones((1, len(time))))
                notes.append(f"{name} r2 {r2[0, 0]:.4f}")
            axes.set_title(f"{arm.joints[column]} flexion (deg): {', '.join(notes)}")
        angles[0].legend(fontsize=8)
        angles[-1].set_xlabel("time (s)")
        panels = right.subplots(synergies.count, 1, sharex=True, sharey=True, squeeze=False)[:, 0]
        for k, axes in enumerate(panels):
            extracted = synergies.signals[motion][inside, k]
            axes.plot(time, extracted, color=RECORDED, linewidth=2.6, alpha=0.35, label="extracted")
            for name, _, signals, color in curves:
                axes.plot(time, signals[inside, k], color=color, linewidth=1.0, label=name)
            strongest = np.argsort(-synergies.weights[:, k])
            named = [
                f"{arm.muscles[m]} {synergies.weights[m, k]:.2f}" for m in strongest if synergies.weights[m, k] > 0.1
            ]
            axes.set_title(f"C{k + 1}: {', '.join(named)}")
            axes.set_ylim(-0.03, 1.03)
        panels[0].legend(fontsize=8)
        panels[-1].set_xlabel("time (s)")
        what = "computed from the motion, not EMG" if synergies.source == "computed" else synergies.source
        figure.suptitle(f"{motions.names[motion]}; synergies {what}", fontweight="bold")
        save(figure, path)


def draw_throws(path: str | Path, follower: Follower, throws: Sequence[Throw]) -> None:
    """Draw the arm of every throw up to its release, and its ball's flight to the target.

    Raises:
        Error: matplotlib is not installed, or the file cannot be written.
    """
    with matplotlib().rc_context(STYLE):
        figure = matplotlib().figure.Figure(figsize=(10.0, 3.0 + 2.1 * len(throws)), layout="constrained")
        flights, rest = figure.subfigures(2, 1, height_ratios=[3.0, 2.1 * len(throws)])
        axes = flights.subplots()
        rows = rest.subplots(len(throws), follower.synergies.count, sharex=True, sharey=True, squeeze=False)
        for index, throw in enumerate(throws):
            color = COLORS[index % len(COLORS)]
            _draw_flight(axes, follower, throw, color)
            _draw_changes(rows[index], follower, throw, color)
        axes.axhline(0.0, color="#909090", linewidth=1.0)
        axes.margins(0.05)  # for the marks of targets
        axes.set_aspect("equal", adjustable="datalim")  # a box that shrinks leaves its label and legend no room
        axes.set_xlabel("forwards from below the shoulder (m)")
        axes.set_ylabel("height (m)")
        axes.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.02, 1.0))
        for axes in rows[-1]:
            axes.set_xlabel("time (s)")
        for axes in rows[:, 0]:
            axes.set_ylabel("signal (1)")
        save(figure, path)


def _draw_flight(axes: Any, follower: Follower, throw: Throw, color: str) -> None:
    arm = follower.arm
    q = states(arm, follower.motions.rows([0]))[0][0]
    q[:, arm.coordinate_places] = throw.replay.angle[0]
    release = round(throw.release / (follower.motions.time[1] - follower.motions.time[0]))
    for number, frame in enumerate(np.linspace(0, release, FRAMES).astype(int)):
        chain = joint_positions(arm, q[frame : frame + 1])
        points = np.stack([*chain, hand_position(arm, q[frame : frame + 1])])[:, 0] - [0.0, throw.ground, throw.below]
        axes.plot(
            points[:, 2], points[:, 1], color=color, linewidth=1.5, alpha=min(0.2 + 0.8 * number / (FRAMES - 1), 1.0)
        )
    flight, goal = throw.flight, throw.goal
    duration = flight.duration[0] if np.isfinite(flight.duration[0]) else 0.5
    time = np.linspace(0.0, duration, 100)
    x = flight.position[0, 0] + flight.velocity[0, 0] * time
    y = flight.position[0, 1] + flight.velocity[0, 1] * time - 0.5 * throw.gravity * time**2
    label = f"{flight.speed[0]:.2f} m/s at {np.degrees(flight.angle[0]):.0f} deg"
    if goal.distance is not None:
        label += f", {flight.distance[0]:.3f} m for {goal.distance:g} m"
        axes.plot([goal.distance], [goal.height], marker="x", color=color, markersize=9, markeredgewidth=2)
    axes.plot(x, y, color=color, linewidth=1.2, linestyle="--", label=label)


def _draw_changes(row: Any, follower: Follower, throw: Throw, color: str) -> None:
    knots = follower.knots.time
    before, after = (follower.shaped(signals[None])[0] for signals in (throw.known, throw.individual))
    for k, axes in enumerate(row):
        axes.plot(knots, before[k], color=RECORDED, linewidth=2.6, alpha=0.35)
        axes.plot(knots, after[k], color=color, linewidth=1.2)
        axes.axvline(throw.release, color="#909090", linewidth=0.6)
        axes.set_title(f"C{k + 1}{' (may change)' if k in throw.synergies else ''}")
        axes.set_ylim(-0.03, 1.03)
