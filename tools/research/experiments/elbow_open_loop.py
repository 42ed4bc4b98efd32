"""Six muscles fold and unfold an elbow by linear excitations (Bergmann 2017, fig. 9).

For docs/explanation/muscles.md.

python tools/research/experiments/elbow_open_loop.py [--folder FOLDER]
"""

from pathlib import Path

import numpy as np
from common import COLORS, angle, draw, main, panels, run, store

import warpmuscle as wm

NAME, Y = "elbow_open_loop", (0.0, 1.0, 0.0)


def experiment(folder: Path) -> None:
    """Excitations, forces and the elbow's angle over three periods."""
    scene = wm.load(NAME)
    motion = run(scene, 6.0)
    store(folder / f"{NAME}.h5", scene, motion)
    shown = motion.window(2.4)
    figure, axes = panels(3, 1, 7, 6, sharex=True)
    for i, name in enumerate(shown.muscle_names):
        color, style = COLORS[0 if name.startswith("rB") else 1], ("-", "--", ":")[i % 3]
        label = name.removeprefix("r")
        axes[0].plot(shown.time, shown.muscle_activation[:, i], style, color=color, label=label)
        axes[1].plot(shown.time, shown.muscle_force[:, i], style, color=color)
    axes[2].plot(shown.time, np.degrees(angle(shown, "rElbow", Y)), color=COLORS[2])
    axes[0].set(ylabel="activation", title="Activations: biceps blue, triceps orange")
    axes[1].set(ylabel="force (N)", title="Muscle forces")
    axes[2].set(ylabel="angle (deg)", xlabel="time (s)", title="Right elbow flexion")
    axes[0].legend(ncols=6, loc="upper right", fontsize=7)
    draw(folder / f"{NAME}.png", figure, "Elbow, open loop (report, fig. 9)")


if __name__ == "__main__":
    main(experiment)
