"""A course walked with noise, and one figure: the path and the feet from above, the ground and the body from the side.

For docs/how-to/steer-a-walk.md.

python tools/research/course_figure.py course.png              20 walks; minutes of two cores
python tools/research/course_figure.py course.png --runs 1
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import matplotlib.pyplot as plt
import numpy as np
import typer

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.terrain.surface import surface

NOISE = 0.1  # m/s, of each component of the root's velocity at the start
LEFT, RIGHT, BODY, GROUND = "#c2410c", "#0f766e", "#1f2937", "#d6d3d1"


def along_way(com: np.ndarray) -> np.ndarray:
    """How far the centre of mass has gone over the ground, m, (frames,)."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(com[:, 0]), np.diff(com[:, 2])))])


def standing(recording: Any, side: int) -> np.ndarray:
    """Frames in the middle of each contact of a foot."""
    force = (recording.foot_force_left, recording.foot_force_right)[side][:, 1]
    down = np.concatenate([[False], force > 20.0, [False]])
    first, end = np.flatnonzero(~down[:-1] & down[1:]), np.flatnonzero(down[:-1] & ~down[1:])
    long = end - first > 5
    return np.asarray(((first + end) // 2)[long])


def draw(scene: Any, recordings: list[Any], figure: Path) -> None:
    """The first walk, and the paths of the others."""
    recording, ground = recordings[0], surface(at_start(scene).ground)
    com, way = recording.com, along_way(recording.com)
    names = list(recording.body_names)
    feet = [recording.body_position[:, names.index(foot)] for foot in scene.feet]
    drawn, (above, aside) = plt.subplots(2, 1, figsize=(11, 6.5), height_ratios=[3, 2], constrained_layout=True)
    for other in recordings[1:]:
        above.plot(other.com[:, 0], other.com[:, 2], color=BODY, lw=0.4, alpha=0.3)
    above.plot(com[:, 0], com[:, 2], color=BODY, lw=1.2, label="centre of mass")
    below = ground.height_at(com[:, 0], com[:, 2])
    aside.fill_between(way, below, below.min() - 0.1, color=GROUND, label="ground below it")
    aside.plot(way, com[:, 1], color=BODY, lw=1.2, label="centre of mass")
    for side, (foot, color, word) in enumerate(zip(feet, (LEFT, RIGHT), ("left", "right"), strict=True)):
        frames = standing(recording, side)
        above.plot(foot[frames, 0], foot[frames, 2], "o", ms=3, color=color, label=f"{word} foot")
        aside.plot(way, foot[:, 1], color=color, lw=0.8, label=f"{word} foot")
    above.set(xlabel="x, m", ylabel="z, m", aspect="equal", title="from above")
    aside.set(xlabel="way of the centre of mass, m", ylabel="height, m", title="from the side")
    for axes in (above, aside):
        axes.legend(frameon=False, fontsize=8, loc="lower right" if axes is above else "upper left")
        axes.spines[["top", "right"]].set_visible(False)
    drawn.savefig(figure, dpi=130)


def main(
    figure: Annotated[Path, typer.Argument(help="picture")],
    runs: Annotated[int, typer.Option(help="walks with noise")] = 20,
    seed: Annotated[int, typer.Option(help="of the noise")] = 1,
) -> None:
    """Walk it, say how many came through, and draw it."""
    scene = wm.load("course")
    rollout = wm.Rollout(scene, runs, "cpu", record=range(runs))
    rollout.reset(velocity_noise=NOISE, seed=seed)
    rollout.run()
    through = np.asarray(rollout.status()) == wm.Status.COMPLETED
    print(f"{through.sum()} of {runs} came through")
    order = [*np.flatnonzero(through), *np.flatnonzero(~through)]
    draw(scene, [rollout.recording(run) for run in order], figure)


if __name__ == "__main__":
    run_script(main)
