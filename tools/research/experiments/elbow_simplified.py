"""Ideal muscles on the elbows do what torques would (Bergmann 2017, section 7.1).

For docs/explanation/muscles.md.

python tools/research/experiments/elbow_simplified.py [--folder FOLDER]
"""

from pathlib import Path

import numpy as np
from common import COLORS, angle, axis_in_world, draw, main, on_torques, panels, run, store

import warpmuscle as wm

NAME, Y = "elbow_simplified", (0.0, 1.0, 0.0)


def experiment(folder: Path) -> None:
    """Elbow angles and torques on muscles and on torques, and their greatest differences over 10 s."""
    scene = wm.load(NAME)
    muscles, torques = run(scene, 10.0), run(on_torques(scene), 10.0)
    store(folder / f"{NAME}.h5", scene, muscles, torques)
    figure, axes = panels(2, 2, 9, 5, sharex="col")
    for row, joint in zip(axes, ("lElbow", "rElbow"), strict=True):
        k = muscles.joint_names.index(joint)
        for motion, style, color, label in ((torques, "-", COLORS[1], "torque"), (muscles, "--", COLORS[0], "muscles")):
            shown = motion.window(8.0)
            row[0].plot(shown.time, np.degrees(angle(shown, joint, Y)), style, color=color, label=label)
            about = axis_in_world(shown, f"{joint[0]}Lowerarm", Y)
            torque = np.sum(shown.joint_torque[:, k] * about, axis=1)
            row[1].plot(shown.time, torque, style, color=color, label=label)
        worst = np.abs(angle(muscles, joint, Y) - angle(torques, joint, Y)).max()
        row[0].set(ylabel="angle (deg)", title=f"{joint}: greatest difference {worst:.1e} rad in 10 s")
        row[1].set(ylabel="torque (N m)", title=f"{joint}: torque about the joint's axis")
    axes[0, 0].legend()
    for panel in axes[1]:
        panel.set_xlabel("time (s)")
    draw(folder / f"{NAME}.png", figure, "Simplified model: ideal muscles against torques (report, section 7.1)")
    every = np.abs(_all_angles(muscles) - _all_angles(torques)).max()
    print(f"greatest difference of any joint's orientation: {every:.2e} rad")


def _all_angles(motion: wm.Recording) -> np.ndarray:
    """Vector parts of all joints' orientations, twice: small differences are angles."""
    q = motion.joint_orientation
    return 2.0 * q[..., :3] * np.sign(q[..., 3:])


if __name__ == "__main__":
    main(experiment)
