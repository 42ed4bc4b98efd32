"""Figures of fitted motions: one of all together, and one of each with its muscles and the flight of a ball."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.names import file_name
from warpmuscle.core.plain_text import number_of
from warpmuscle.plots.style import matplotlib, save
from warpmuscle.scene.parameters import at_start
from warpmuscle.throw.arm import hand_position, needed_torques, states
from warpmuscle.throw.fit import Fitted
from warpmuscle.throw.follow import Follower
from warpmuscle.throw.metrics import determination
from warpmuscle.throw.motion import RATE
from warpmuscle.throw.plot import RECORDED, SIMULATED, STYLE, draw_fit, draw_throws
from warpmuscle.throw.published import Published
from warpmuscle.throw.signals import to_activation
from warpmuscle.throw.synthesis import Throw

FAST = 0.5  # of the greatest speed of the hand, below which no ball is let go


@dataclass(frozen=True)
class Course:
    """What muscles do along n fitted motions."""

    activation: Floats  # (n, T, M)
    force: Floats  # (n, T, M) N
    torque: Floats  # (n, T, J) N m, of all muscles about each joint
    needed: Floats  # (n, T, J) N m, by inverse dynamics of the recording
    hand: Floats  # (n, T, 2) m, forwards and up

    @staticmethod
    def of(follower: Follower, fitted: Fitted) -> Course:
        """From the fitted signals and the simulated angles."""
        arm, motions = follower.arm, follower.motions
        signals = follower.knots.sampled(follower.shaped(fitted.individual))
        activation = to_activation(arm, follower.synergies.excitation(signals), follower.start(fitted.individual))
        table = arm.muscle_table(fitted.unknowns[None])
        q = states(arm, motions)[0]
        q[:, :, arm.coordinate_places] = fitted.replay.angle
        force, torque = [], []
        for individual, angle, speed in zip(activation, fitted.replay.angle, fitted.replay.speed, strict=True):
            force.append(table.forces(individual, angle, speed)[0])
            torque.append(table.torques(individual, angle, speed)[0].sum(axis=1))
        hand = np.stack([hand_position(arm, one)[:, [2, 1]] for one in q])
        return Course(activation, np.stack(force), np.stack(torque), needed_torques(arm, motions), hand)


def draw_result(
    path: Path, follower: Follower, fitted: Fitted | None, published: Published | None, throws: Sequence[Throw]
) -> None:
    """Draw throws if there are any, else all motions, or one as fitted and as published."""
    if throws:
        draw_throws(path, follower, throws)
    elif fitted is not None and len(follower.motions) > 1:
        draw_motions(path, follower, fitted)
    else:
        draw_fit(path, follower, fitted, published)


def draw_each(folder: Path, follower: Follower, fitted: Fitted) -> None:
    """A figure of each fitted motion, named as it is."""
    folder.mkdir(parents=True, exist_ok=True)
    course = Course.of(follower, fitted)
    for row, name in enumerate(follower.motions.names):
        draw_motion(folder / f"{file_name(name)}.png", follower, fitted, course, row)


def draw_motions(path: str | Path, follower: Follower, fitted: Fitted) -> None:
    """Draw all motions at once: angles, angular velocities, torques, weights of synergies, and their signals.

    Raises:
        Error: matplotlib is not installed, or the file cannot be written.
    """
    motions, rows, count = follower.motions, len(follower.arm.driven), follower.synergies.count
    course = Course.of(follower, fitted)
    with matplotlib().rc_context(STYLE):
        heights = [1.7 * rows, 1.1 * count]
        figure = matplotlib().figure.Figure(figsize=(11.0, 0.8 + sum(heights)), layout="constrained")
        upper, lower = figure.subfigures(2, 1, height_ratios=heights)
        grid = upper.subplots(rows, 3, sharex=True, squeeze=False)
        left, right = lower.subfigures(1, 2)
        panels = right.subplots(count, 1, sharex=True, sharey=True, squeeze=False)[:, 0]
        for row in range(len(motions)):
            _draw_joints(grid, follower, fitted, course, row, 0.6)
            _draw_signals(panels, follower, fitted, row, 0.6)
        _title_joints(grid, follower, fitted, list(range(len(motions))))
        _draw_weights(left.subplots(count, 1, sharex=True, sharey=True, squeeze=False)[:, 0], follower)
        good = int(fitted.agreement.good().sum())
        figure.suptitle(
            f"{number_of(len(motions), 'motion')}, {good} with all bars met (grey: recorded, needed, or extracted)"
        )
        save(figure, path)


def draw_motion(path: str | Path, follower: Follower, fitted: Fitted, course: Course, row: int) -> None:
    """Draw one motion with its muscles, and the flight of a ball that is let go where it flies farthest.

    Raises:
        Error: matplotlib is not installed, or the file cannot be written.
    """
    arm, motions, count = follower.arm, follower.motions, follower.synergies.count
    inside = motions.valid[row] > 0.0
    with matplotlib().rc_context(STYLE):
        heights = [1.7 * len(arm.driven), max(1.2 * count, 0.22 * len(arm.muscles) + 1.0)]
        figure = matplotlib().figure.Figure(figsize=(12.0, 0.8 + sum(heights)), layout="constrained")
        upper, lower = figure.subfigures(2, 1, height_ratios=heights)
        grid = upper.subplots(len(arm.driven), 3, sharex=True, squeeze=False)
        _draw_joints(grid, follower, fitted, course, row, 1.3)
        _title_joints(grid, follower, fitted, [row])
        first, second, third = lower.subfigures(1, 3, width_ratios=[1.3, 1.3, 0.9])
        values = {"activation (1)": course.activation[row][inside], "force (kN)": course.force[row][inside] / 1000.0}
        for axes, (title, one) in zip(first.subplots(1, 2, sharey=True), values.items(), strict=True):
            _draw_muscles(axes, follower, motions.time[inside], one, title)
        panels = second.subplots(count, 2, sharex="col", sharey=True, squeeze=False)
        _draw_weights(panels[:, 0], follower)
        _draw_signals(panels[:, 1], follower, fitted, row, 1.2)
        _draw_flight(third.subplots(), follower, course.hand[row][inside])
        figure.suptitle(f"{motions.names[row]} (grey: recorded, needed, or extracted)", fontweight="bold")
        save(figure, path)


def _draw_joints(grid: Any, follower: Follower, fitted: Fitted, course: Course, row: int, width: float) -> None:
    """Angles, their rates and torques of a motion."""
    arm, motions = follower.arm, follower.motions
    inside = motions.valid[row] > 0.0
    time = motions.time[inside]
    pairs = (
        (np.degrees(motions.angles[0][row]), np.degrees(fitted.replay.angle[row])),
        (np.degrees(motions.angles[1][row]), np.degrees(fitted.replay.speed[row])),
        (course.needed[row], course.torque[row]),
    )
    for axes, column in zip(grid, arm.free, strict=True):
        for panel, (recorded, simulated) in zip(axes, pairs, strict=True):
            panel.plot(time, recorded[inside, column], color=RECORDED, linewidth=2.0 * width, alpha=0.25)
            panel.plot(time, simulated[inside, column], color=SIMULATED, linewidth=width)


def _title_joints(grid: Any, follower: Follower, fitted: Fitted, rows: list[int]) -> None:
    """Name the panels of `_draw_joints`, with the lowest r2 of some motions."""
    arm, motions = follower.arm, follower.motions
    word = "r2" if len(rows) == 1 else "lowest r2"
    for axes, name, column in zip(grid, arm.driven, arm.free, strict=True):
        pairs = ((motions.angles[0], fitted.replay.angle), (motions.angles[1], fitted.replay.speed))
        angle, rate = (
            determination(b[rows][:, :, [column]], a[rows][:, :, [column]], motions.valid[rows]).min() for a, b in pairs
        )
        axes[0].set_title(f"{name.replace('_', ' ')} (deg), {word} {angle:.4f}")
        axes[1].set_title(f"rate (deg/s), {word} {rate:.3f}")
        axes[2].set_title("torque of muscles (N m)")
    for panel in grid[-1]:
        panel.set_xlabel("time (s)")


def _draw_muscles(axes: Any, follower: Follower, time: Floats, values: Floats, title: str) -> None:
    """Something of all muscles (T, M) over time, a row each."""
    names = follower.arm.muscles
    extent = (time[0], time[-1], len(names) - 0.5, -0.5)
    image = axes.imshow(values.T, aspect="auto", extent=extent, cmap="magma_r", vmin=0.0, interpolation="nearest")
    axes.set_title(title)
    axes.set_xlabel("time (s)")
    axes.set_yticks(range(len(names)), names, fontsize=7)
    axes.figure.colorbar(image, ax=axes, location="bottom", shrink=0.8)


def _draw_weights(panels: Any, follower: Follower) -> None:
    """Weights of synergies as bars, in one panel each."""
    weights, names = follower.synergies.weights, follower.arm.muscles
    for k, axes in enumerate(panels):
        axes.bar(range(len(names)), weights[:, k], color=SIMULATED, width=0.7)
        axes.set_title(f"W{k + 1}")
        axes.set_ylim(0.0, 1.05)
    panels[-1].set_xticks(range(len(names)), names, rotation=90, fontsize=7)


def _draw_signals(panels: Any, follower: Follower, fitted: Fitted, row: int, width: float) -> None:
    """Signals of a motion as extracted and fitted, in one panel a synergy."""
    inside = follower.motions.valid[row] > 0.0
    time = follower.motions.time[inside]
    signals = follower.knots.sampled(follower.shaped(fitted.individual[row : row + 1]))[0]
    for k, axes in enumerate(panels):
        axes.plot(time, follower.synergies.signals[row][inside, k], color=RECORDED, linewidth=2.0 * width, alpha=0.25)
        axes.plot(time, signals[inside, k], color=SIMULATED, linewidth=width)
        axes.set_title(f"C{k + 1}")
    panels[-1].set_xlabel("time (s)")


def _draw_flight(axes: Any, follower: Follower, hand: Floats) -> None:
    """Way of the hand (T, 2), m, and the flight of a ball that leaves it where it would fly farthest."""
    velocity = np.gradient(hand, 1.0 / RATE, axis=0)
    gravity = float(at_start(follower.arm.scene).gravity)  # type: ignore[arg-type]
    rise, speed = velocity[:, 1], np.linalg.norm(velocity, axis=1)
    duration = (rise + np.sqrt(rise**2 + 2.0 * gravity * np.maximum(hand[:, 1], 0.0))) / gravity
    reach = np.where(speed >= FAST * speed.max(), hand[:, 0] + velocity[:, 0] * duration, -np.inf)
    at = int(reach.argmax())
    time = np.linspace(0.0, duration[at], 60)[:, None]
    flight = hand[at] + velocity[at] * time - np.array([0.0, 0.5 * gravity]) * time**2
    axes.plot(hand[:, 0], hand[:, 1], color=RECORDED, linewidth=1.2)
    axes.plot(flight[:, 0], flight[:, 1], color=SIMULATED, linestyle="--", linewidth=1.2)
    axes.plot(*hand[at], marker="o", color=SIMULATED)
    axes.set_aspect("equal", adjustable="box", anchor="N")
    angle = np.degrees(np.arctan2(velocity[at, 1], velocity[at, 0]))
    axes.set_title(f"let go after {at / RATE:.2f} s at {speed[at]:.1f} m/s, {angle:.0f} deg")
    axes.set_xlabel("forwards (m)")
    axes.set_ylabel("height (m)")
