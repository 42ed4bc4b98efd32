"""Figures of walks on muscles: the character with its muscles, joint angles beside those on torques, activations.

For docs/explanation/muscles.md.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from common import COLORS, angle, draw, on_torques, panels, plt, run, store

import warpmuscle as wm
from warpmuscle.core.pose import rotate
from warpmuscle.gait.cycles import strides
from warpmuscle.plots.projection import project
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import pieces
from warpmuscle.scene.parameters import at_start

X = (1.0, 0.0, 0.0)
SIDE, FRONT = (2, 1), (0, 1)  # world axes to the right and up of the page
ANGLES = (("Hip", -1.0), ("Knee", 1.0), ("Ankle", -1.0))
DURATION = 10.0


def walk(name: str, figure: str, folder: Path) -> Recording:
    """Run a scene, store it, draw it beside the same walk on torques, and print how it went."""
    scene = wm.load(name)
    muscles, torques = run(scene, DURATION), run(on_torques(scene), DURATION)
    store(folder / f"{name}.h5", scene, muscles)
    assert scene.controller is not None
    gait, reference = (wm.measure(motion, *scene.controller.feet) for motion in (muscles, torques))
    print(
        f"{name}: {len(muscles.muscle_names)} muscles, {muscles.time[-1]:.2f} s, {gait.speed_forward:.2f} m/s "
        f"(on torques {reference.speed_forward:.2f} m/s)"
    )
    page, axes = panels(2, 3, 11, 7.5, height_ratios=(1.6, 1.0))
    grid = axes[0, 0].get_gridspec()
    for panel in axes[0]:
        panel.remove()
    shown = last_stride(muscles)
    with_muscles(page.add_subplot(grid[0, 0]), scene, shown, FRONT)
    with_muscles(page.add_subplot(grid[0, 1]), scene, shown, SIDE)
    activations(page, page.add_subplot(grid[0, 2]), shown)
    for panel, (joint, sign) in zip(axes[1], ANGLES, strict=True):
        for motion, style, label in ((torques, ":", "torques"), (muscles, "-", "muscles")):
            stride = last_stride(motion)
            time = 100.0 * (stride.time - stride.time[0]) / (stride.time[-1] - stride.time[0])
            for side, color in zip("lr", COLORS, strict=False):
                turn = sign * np.degrees(angle(stride, f"{side}{joint}", X))
                panel.plot(time, turn, style, color=color, label=f"{'left' if side == 'l' else 'right'}, {label}")
        panel.set(title=f"{joint} flexion", xlabel="stride (%)", ylabel="angle (deg)")
    axes[1, 0].legend(fontsize=7)
    draw(folder / f"{name}.png", page, f"{name}: {gait.speed_forward:.2f} m/s on muscles ({figure})")
    return muscles


def last_stride(motion: Recording) -> Recording:
    """The last whole gait cycle of a motion, from one contact of the left foot to its next, or all of it."""
    cycles = strides(motion, "left")
    return motion.window(*cycles[-1]) if cycles else motion


def with_muscles(axes: Any, scene: Scene, motion: Recording, view: tuple[int, int], frame: int = 0) -> None:
    """The character in one frame with its muscles, the darker the more active."""
    plain = at_start(scene)
    assert plain.controller is not None
    for piece in pieces(plain.character, plain.controller.feet):
        axes.plot(*project(motion, piece, frame, view).T, color="#B0B0B0", lw=2.0, zorder=1)
    map_ = plt.get_cmap("plasma_r")
    for m, name in enumerate(motion.muscle_names):
        points = []
        for point in plain.character.muscles[name].path:
            body = motion.body_names.index(point.body)
            turned = rotate(motion.body_orientation[frame, body], np.array(point.place(), dtype=float))
            points.append(motion.body_position[frame, body] + turned)
        line = np.array(points)[:, list(view)]
        strength = float(motion.muscle_activation[frame, m])
        axes.plot(*line.T, "-o", color=map_(0.15 + 0.85 * strength), lw=1.2, ms=1.8, zorder=2)
    axes.set_aspect("equal")
    axes.set(title="Front" if view == FRONT else "Side", xlabel="left, x (m)" if view == FRONT else "forward, z (m)")
    axes.set_ylabel("height, y (m)")


def activations(page: Any, axes: Any, motion: Recording) -> None:
    """Activations of all muscles over a stride."""
    image = axes.imshow(
        motion.muscle_activation.T, aspect="auto", cmap="viridis", vmin=0.0, vmax=1.0, interpolation="nearest",
        extent=(0.0, 100.0, len(motion.muscle_names), 0.0),
    )  # fmt: skip
    size = 7 if len(motion.muscle_names) < 30 else 4.5
    axes.set_yticks(np.arange(len(motion.muscle_names)) + 0.5, motion.muscle_names, fontsize=size)
    axes.set(title="Activation", xlabel="stride (%)")
    page.colorbar(image, ax=axes, shrink=0.5)
