"""One pair of muscles an elbow, or three pairs each asked for the whole torque (Bergmann 2017, section 7.4).

For docs/explanation/muscles.md.

python tools/research/experiments/muscle_groups.py [--folder FOLDER]
"""

from pathlib import Path

import numpy as np
from common import COLORS, angle, draw, main, on_torques, panels, run, store, target

import warpmuscle as wm

NAME, Y = "muscle_groups", (0.0, 1.0, 0.0)


def experiment(folder: Path) -> None:
    """The right elbow on torques, on one pair and on three pairs of muscles."""
    groups, pair = wm.load(NAME), wm.load("moment_arm_angle")
    motions = {
        "torque": run(on_torques(pair), 6.0),
        "one pair": run(pair, 6.0),
        "three pairs": run(groups, 6.0),
    }
    store(folder / f"{NAME}.h5", groups, *motions.values())
    figure, axes = panels(1, 2, 9, 3.4)
    for (name, motion), color in zip(motions.items(), COLORS, strict=False):
        shown = motion.window(3.5)
        k = shown.joint_names.index("rElbow")
        flexion = angle(shown, "rElbow", Y)
        axes[0].plot(shown.time, np.degrees(flexion), color=color, label=name)
        axes[1].plot(shown.time, np.linalg.norm(shown.joint_torque[:, k], axis=1), color=color, label=name)
        print(f"{name}: flexion {np.degrees(flexion.min()):.1f} to {np.degrees(flexion.max()):.1f} degrees")
    axes[0].plot(shown.time, np.degrees(target(shown, "rElbow", Y)), ":", color="#404040", label="target")
    axes[0].set(title="Right elbow flexion", ylabel="angle (deg)", xlabel="time (s)")
    axes[1].set(title="Magnitude of its torque", ylabel="torque (N m)", xlabel="time (s)")
    axes[0].legend(fontsize=7, ncols=2, loc="lower left")
    draw(folder / f"{NAME}.png", figure, "Several muscles on one degree of freedom (report, section 7.4)")


if __name__ == "__main__":
    main(experiment)
