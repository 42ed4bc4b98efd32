"""A muscle whose moment arm is not along the joint's axis loses torque (Bergmann 2017, fig. 10).

For docs/explanation/muscles.md.

python tools/research/experiments/moment_arm_angle.py [--folder FOLDER]
"""

from copy import deepcopy
from pathlib import Path

import numpy as np
from common import COLORS, angle, axis_in_world, draw, main, panels, run, store, target

import warpmuscle as wm

NAME, Y = "moment_arm_angle", (0.0, 1.0, 0.0)
SHIFTS = (0.0, 0.03, 0.08)  # m, of the muscles along the elbow's axis


def shifted(scene: wm.Scene, shift: float) -> wm.Scene:
    """The scene with the muscles of the right arm moved along the elbow's axis, which turns their moment arms."""
    scene = deepcopy(scene)
    for muscle in (scene.character.muscles[name] for name in ("rBIC", "rTRI")):
        for point in muscle.path:
            x, y, z = (float(number) for number in point.position)
            point.position = (x, y + shift, z)
    return scene


def experiment(folder: Path) -> None:
    """Desired and muscle torque about the elbow's axis and the angle reached, for three placements of the muscles."""
    scene = wm.load(NAME)
    motions = [run(shifted(scene, shift), 6.0) for shift in SHIFTS]
    store(folder / f"{NAME}.h5", scene, *motions)
    figure, axes = panels(1, 3, 11, 3.4)
    for shift, color, motion in zip(SHIFTS, COLORS, motions, strict=False):
        shown = motion.window(3.5)
        k = shown.joint_names.index("rElbow")
        about = axis_in_world(shown, "rLowerarm", Y)
        desired = -np.sum(shown.joint_torque_desired[:, k] * about, axis=1)
        torque = -np.sum(shown.joint_torque[:, k] * about, axis=1)
        whole = np.linalg.norm(shown.joint_torque[:, k], axis=1)
        turn = np.degrees(np.arccos(min(np.abs(torque).sum() / whole.sum(), 1.0)))
        label = f"{1e3 * shift:.0f} mm, {turn:.0f} degrees"
        axes[0].plot(shown.time, desired, color=color, label=label)
        axes[1].plot(shown.time, torque, color=color)
        flexion = np.degrees(angle(shown, "rElbow", Y))
        axes[2].plot(shown.time, flexion, color=color)
        print(
            f"{label} between moment arm and axis: greatest feedback torque {desired.max():.2f} N m, "
            f"of the muscles {torque.max():.2f} N m, flexion {flexion.max():.1f} degrees"
        )
    axes[2].plot(shown.time, np.degrees(target(shown, "rElbow", Y)), ":", color="#404040", label="target")
    axes[0].set(title="Feedback torque", ylabel="torque (N m)")
    axes[1].set(title="Torque of the muscles", ylabel="torque (N m)")
    axes[2].set(title="Elbow flexion", ylabel="angle (deg)")
    axes[0].legend(fontsize=7)
    axes[2].legend(fontsize=7)
    for panel in axes:
        panel.set_xlabel("time (s)")
    draw(folder / f"{NAME}.png", figure, "Angle between moment arm and joint axis (report, fig. 10)")


if __name__ == "__main__":
    main(experiment)
