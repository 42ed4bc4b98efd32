"""The legs on 28 muscles, and what the left ankle's do (Bergmann 2017, figs 13-15).

For docs/explanation/muscles.md.

python tools/research/experiments/legs28.py [--folder FOLDER]
"""

from pathlib import Path

import numpy as np
from common import COLORS, angle, draw, main, panels

import warpmuscle as wm
from walking import last_stride, walk

NAME, X, Z = "legs28", (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
MUSCLES = ("lSOL", "lTA", "lIN", "lOUT")


def experiment(folder: Path) -> None:
    """The walk beside the same one on torques; the left ankle's angles, feedback torques and muscles over a stride."""
    motion = last_stride(walk(NAME, "report, fig. 13", folder))
    k = motion.joint_names.index("lAnkle")
    figure, axes = panels(2, 3, 11, 5.5)
    axes[0, 0].plot(motion.time, -angle(motion, "lAnkle", X), color=COLORS[0], label="dorsiflexion")
    axes[0, 0].plot(motion.time, angle(motion, "lAnkle", Z), color=COLORS[1], label="rotation")
    axes[0, 0].set(title="Left ankle", ylabel="angle (rad)")
    for i, (name, color) in enumerate(zip("xyz", (COLORS[0], COLORS[1], "#808080"), strict=True)):
        axes[1, 0].plot(motion.time, motion.joint_torque_desired[:, k, i], color=color, label=name)
    axes[1, 0].set(title="Feedback torque, world", ylabel="torque (N m)", xlabel="time (s)")
    f_max = {name: float(np.asarray(m.f_max)) for name, m in wm.load(NAME).character.muscles.items()}
    for panel, name in zip(axes[:, 1:].flat, MUSCLES, strict=True):
        m = motion.muscle_names.index(name)
        desired = np.minimum(motion.muscle_desired_force[:, m] / f_max[name], 1.0)
        panel.plot(motion.time, desired, ":", color=COLORS[6], label="desired")
        panel.plot(motion.time, motion.muscle_excitation[:, m], color=COLORS[1], label="excitation")
        panel.plot(motion.time, motion.muscle_activation[:, m], color=COLORS[0], label="activation")
        panel.set(title=name, ylabel="activation")
    for panel in (axes[0, 0], axes[1, 0], axes[0, 1]):
        panel.legend(fontsize=7)
    for panel in axes[1]:
        panel.set_xlabel("time (s)")
    draw(folder / f"{NAME}_ankle.png", figure, "The left ankle over a stride (report, figs 14-15)")


if __name__ == "__main__":
    main(experiment)
