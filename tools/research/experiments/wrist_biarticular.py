"""Muscles across two joints, three synchronisations of their targets, three treatments of pushing (report, figs 11-12).

For docs/explanation/muscles.md.

python tools/research/experiments/wrist_biarticular.py [--folder FOLDER]
"""

from copy import deepcopy
from pathlib import Path

import msgspec
import numpy as np
from common import COLORS, angle, draw, main, on_torques, panels, run, store

import warpmuscle as wm

NAME, Y, Z = "wrist_biarticular", (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
TARGETS = {  # of the wrist over the phase, rad; the elbow's goes from -0.1 to 1 and back
    "synchronised": [-0.5, 0.5, -0.5],
    "shifted": [0.0, 0.5, -0.5, 0.0],
    "opposed": [0.5, -0.5, 0.5],
}
PHASES = {3: [0.0, 0.5, 1.0], 4: [0.0, 0.25, 0.75, 1.0]}
TREATMENTS = ("keep", "drop", "clip")


def variant(scene: wm.Scene, wrist: list[float], negative: str) -> wm.Scene:
    """The scene with another target of the wrist and another treatment of pushing contributions."""
    scene = deepcopy(scene)
    assert scene.controller is not None
    component = scene.controller.states[0].trajectories["rWrist"].components[0]
    component.phase, component.angle = PHASES[len(wrist)], list(wrist)
    model = msgspec.structs.replace(scene.muscle_model, negative=negative)
    return msgspec.structs.replace(scene, muscle_model=model)


def experiment(folder: Path) -> None:
    """Elbow and wrist on torques and on biarticular muscles: a row a synchronisation, a column a treatment."""
    scene = wm.load(NAME)
    motions = []
    figure, axes = panels(3, 3, 11, 7, sharex=True, sharey=True)
    for row, (name, wrist) in zip(axes, TARGETS.items(), strict=True):
        reference = run(on_torques(variant(scene, wrist, "keep")), 6.0)
        motions.append(reference)
        for panel, negative in zip(row, TREATMENTS, strict=True):
            muscles = run(variant(scene, wrist, negative), 6.0)
            motions.append(muscles)
            agreement = []  # of elbow and wrist with what torques do
            for joint, axis, color in (("rElbow", Y, COLORS[0]), ("rWrist", Z, COLORS[1])):
                for motion, style in ((reference, ":"), (muscles, "-")):
                    shown = motion.window(3.5)
                    label = f"{joint[1:]}, {'torque' if style == ':' else 'muscles'}"
                    panel.plot(shown.time, angle(shown, joint, axis), style, color=color, label=label)
                turns = [angle(motion.window(3.5), joint, axis) for motion in (reference, muscles)]
                agreement.append(np.corrcoef(*turns)[0, 1])
            panel.set_title(f"{name}, {negative}: r = {agreement[0]:.2f}, {agreement[1]:.2f}")
            print(
                f"{name:13s}{negative:6s}correlation with torques: elbow {agreement[0]:5.2f}, wrist {agreement[1]:5.2f}"
            )
        row[0].set_ylabel("angle (rad)")
    axes[0, 0].legend(fontsize=7, ncols=2)
    for panel in axes[-1]:
        panel.set_xlabel("time (s)")
    store(folder / f"{NAME}.h5", scene, *motions)
    draw(folder / f"{NAME}.png", figure, "One muscle across elbow and wrist (report, figs 11-12)")


if __name__ == "__main__":
    main(experiment)
