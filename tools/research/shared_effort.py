"""How much of the effort of a recorded walk its moments need, and how the least effort would share them among muscles.

For docs/tutorials/learn.md.

warpmuscle simulate gait2392_arms_like_people.toml --policy gait2392_arms_like_people.h5 --command speed=1.25 \
    --rate 1000 --set duration=12 -o walks.h5
python tools/research/shared_effort.py walks.h5

At 50 moments of a stride, the right leg's muscles share the same torques about hip, knee, ankle, heel and toes anew, so
that the sum of volume times squared activation is least. What a muscle can do comes from its recorded fibre: f_max by a
Gaussian of the length (Thelen 2003, J. Biomech. Eng. 125:70: exp(-(l - 1)^2/0.45)) and Hill's hyperbola of the speed,
up to 1.4 in lengthening. Passive forces are left as they are, and tendons and activation dynamics out of account.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from scipy.optimize import lsq_linear

from warpmuscle.cli.ending import run_script
from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number, first_row
from warpmuscle.core.pose import rotate
from warpmuscle.gait.cycles import steady_strides
from warpmuscle.optimization.best_scene import scene_in
from warpmuscle.results.recording import Recording
from warpmuscle.results.result import read
from warpmuscle.scene import Joint, Scene
from warpmuscle.scene.anatomy import leg
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.masses import muscle_masses
from warpmuscle.scene.parameters import at_start
from warpmuscle.simulation.stages import Stages

SETTLED, MOMENTS = 4.0, 50  # s, before which nothing counts; of the stride
FASTEST, CURVATURE, LENGTHENING = 10.0, 0.25, 1.4  # l_opt/s; of Hill's hyperbola; times f_max
LEAST, STIFF = 0.01, 30.0  # activation; weight of torques beside effort, which leaves less than 0.01 N m
SHOWN = 14  # muscles


def strengths(motion: Recording, scene: Scene, names: list[str], frame: int) -> Floats:
    """Force (M,), N, that each muscle's fibres have at full activation, along the tendon but for pennation."""
    found = []
    for name in names:
        muscle, column = scene.character.muscles[name], motion.muscle_names.index(name)
        unit = first_number(muscle.l_opt)
        length = float(motion.muscle_fibre_length[frame, column]) / unit
        speed = float(motion.muscle_fibre_velocity[frame, column]) / unit / FASTEST
        by_length = np.exp(-((length - 1.0) ** 2) / 0.45)
        shortening = max(speed, -0.95)
        by_speed = (1.0 + shortening) / (1.0 - shortening / CURVATURE) if speed < 0.0 else 0.0
        if speed >= 0.0:
            by_speed = 1.0 + (LENGTHENING - 1.0) * min(5.0 * speed, 1.0)
        found.append(first_number(muscle.f_max) * by_length * max(by_speed, 0.02))
    return np.array(found)


def axes_of(joint: Joint) -> list[Floats]:
    """Axes that a joint turns about, in its parent."""
    if joint_type(joint).quaternion:
        return list(np.eye(3))
    return [first_row(joint.axes[0]) if joint.axes else np.array([1.0, 0.0, 0.0])]


def main(file: Annotated[Path, typer.Argument()]) -> None:
    """Print both efforts, and the muscles that differ most."""
    result = read(file, replay=0)
    scene, motion = at_start(scene_in(result)), result.replays[0].window(SETTLED)
    begin, end = steady_strides(motion, scene)["right"][1]
    frames = np.searchsorted(motion.time, np.linspace(begin, end, MOMENTS, endpoint=False))
    stages = Stages(scene, len(frames), "cpu")
    stages.state.coordinates.assign(np.asarray(motion.coordinate, np.float32)[frames])
    stages.state.speeds.assign(np.asarray(motion.speed, np.float32)[frames])
    paths, every = stages.muscle_paths(), list(scene.character.muscles)
    assert scene.feet is not None
    foot = scene.feet[1]
    joints = [*leg(scene.character, foot), *(n for n, one in scene.character.joints.items() if one.parent == foot)]
    joints = [name for name in joints if name in stages.names.joints]
    crossing = {every[m] for m, j in zip(paths.muscle, paths.joint, strict=True) if stages.names.joints[j] in joints}
    names = [name for name in every if name in crossing]
    muscles = [scene.character.muscles[name] for name in names]
    volume = np.array(muscle_masses(muscles, scene.muscle_model))
    acted, least = np.zeros((2, len(frames), len(names)))
    for k, frame in enumerate(frames):
        arms = []
        for name in joints:
            joint = scene.character.joints[name]
            turned = motion.body_orientation[frame, motion.body_names.index(joint.parent)][None]
            arm = np.zeros((3, len(names)))
            for c, (m, j) in enumerate(zip(paths.muscle, paths.joint, strict=True)):
                if stages.names.joints[j] == name:
                    arm[:, names.index(every[m])] += paths.moment_arm[k, c]
            arms += [rotate(turned, axis[None])[0] @ arm for axis in axes_of(joint)]
        torque = np.array(arms) * strengths(motion, scene, names, int(frame))
        columns = [motion.muscle_names.index(name) for name in names]
        acted[k] = np.clip(motion.muscle_activation[frame, columns], LEAST, 1.0)
        weight = np.diag(np.sqrt(volume / volume.mean()))
        wanted = np.concatenate([STIFF * (torque @ acted[k]), np.zeros(len(names))])
        least[k] = lsq_linear(np.vstack([STIFF * torque, weight]), wanted, (LEAST, 1.0)).x
    effort = [float((values**2 @ volume).mean()) for values in (acted, least)]
    print(f"effort of the walk over the least that its moments need: {effort[0] / effort[1]:.2f}")
    saved = np.argsort(-np.abs((acted**2 - least**2).mean(axis=0)) * volume)[:SHOWN]
    print("muscle: mean activation of the walk in each tenth of the cycle; with the least effort")
    for m in saved:
        tenths = [" ".join(f"{one:.2f}" for one in v[:, m].reshape(10, -1).mean(axis=1)) for v in (acted, least)]
        print(f"{names[m]}: {tenths[0]}; {tenths[1]}")


if __name__ == "__main__":
    run_script(main)
