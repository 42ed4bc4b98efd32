"""Why an ankle carries what it carries: its moment over the gait cycle, and how far ahead of it the ground pushes.

For docs/tutorials/learn.md.

warpmuscle simulate gait2392_arms_like_people.toml --policy gait2392_arms_like_people.h5 --command speed=1.25 \
    --rate 1000 --set duration=12 -o walks.h5
python tools/research/ankle_lever.py walks.h5

Means of both sides. The moment of muscles and stops stands beside one that knows nothing of them: it follows from where
and how hard the ground pushes, and from weight and accelerations of the foot, as inverse dynamics has it. The lever is
from the ankle to the centre of pressure, along the walk. Every step has to be recorded.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import typer

from warpmuscle.cli.ending import run_script
from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.pose import conjugate, rotate
from warpmuscle.gait.cycles import PERCENT, body_weight, over_strides, steady_strides
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.gait.joint_moments import PEOPLE, from_people, leg_moments
from warpmuscle.optimization.best_scene import scene_in
from warpmuscle.results.recording import Recording
from warpmuscle.results.result import read
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import leg_joints
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.topology import subtree
from warpmuscle.studies.ground_loads import ground_loads
from warpmuscle.studies.inverse_dynamics import body_points

SETTLED = 4.0  # s, before which nothing counts
AVERAGED = 15  # frames, over which accelerations are smoothed
TOUCHES = 30.0  # N, from which on a foot has a lever
SHOWN = (4, 8, 12, 20, 28, 32, 36, 40, 44, 48, 52, 56)  # % of the cycle
NAME = "Ankle moment"


class Ankle(NamedTuple):
    """What is known of one ankle in F frames."""

    moment: Floats  # N m/kg, by ground, weight and accelerations; of plantarflexors positive
    lever: Floats  # cm, NaN in the air
    force: Floats  # body weights, vertical


def ankle(recording: Recording, scene: Scene, side: int) -> Ankle:
    """One ankle, from outside."""
    joint = scene.character.joints[leg_joints(scene, side)[2]]
    place = body_points(scene, np.asarray(recording.coordinate, float))[joint.child][0]
    bodies = sorted(subtree(scene.character, joint.child))
    moment, force, pushed = (np.zeros((recording.frames, 3)) for _ in range(3))
    for load in ground_loads(recording, scene):
        if load.body in bodies:
            moment += np.cross(load.point - place, load.force) + load.torque
            force += load.force
            pushed += load.point * load.force[:, 1:2]
    step = float(np.diff(recording.time).mean())
    gravity = np.array([0.0, -first_number(scene.gravity), 0.0])
    for name in bodies:
        at = np.asarray(recording.position_of(name), float)
        rate = np.gradient(np.gradient(at, step, axis=0), step, axis=0)
        smooth = np.stack([np.convolve(one, np.ones(AVERAGED) / AVERAGED, "same") for one in rate.T], axis=1)
        moment += np.cross(at - place, first_number(scene.character.bodies[name].mass) * (gravity - smooth))
    turned = recording.body_orientation[:, recording.body_names.index(joint.parent)]
    about = -rotate(conjugate(turned), moment)[:, 0] / body_mass(scene.character)
    gone = recording.com_velocity.mean(axis=0) * [1.0, 0.0, 1.0]
    ahead = (pushed / np.maximum(force[:, 1:2], TOUCHES) - place) @ (gone / np.linalg.norm(gone))
    lever = np.where(force[:, 1] > TOUCHES, 100.0 * ahead, np.nan)
    return Ankle(np.asarray(about), lever, force[:, 1] / body_weight(scene))


def main(file: Annotated[Path, typer.Argument()]) -> None:
    """Print the table."""
    result = read(file, replay=0)
    scene, motion = at_start(scene_in(result)), result.replays[0].window(SETTLED)
    cycles, own = steady_strides(motion, scene), leg_moments(motion, scene)[NAME]
    seen = [ankle(motion, scene, side) for side in range(len(SIDES))]

    def of_sides(values: list[Floats]) -> list[Floats]:
        return [
            over_strides(motion.time, one, cycles[side]).mean(axis=0) for one, side in zip(values, SIDES, strict=True)
        ]

    muscles, outside = of_sides([own[side] for side in SIDES]), of_sides([one.moment for one in seen])
    levers, forces = of_sides([one.lever for one in seen]), of_sides([one.force for one in seen])
    people = PEOPLE[NAME].mean(PERCENT)
    print("% of the cycle | moment of muscles, N m/kg | from outside | people | lever, cm | force, body weights")
    for percent in SHOWN:
        row = [float(np.mean([curve[percent] for curve in one])) for one in (muscles, outside, levers, forces)]
        print(f"{percent} | {row[0]:.2f} | {row[1]:.2f} | {people[percent]:.2f} | {row[2]:.1f} | {row[3]:.2f}")
    print(f"from people: {from_people(NAME, muscles):.2f} SD by muscles, {from_people(NAME, outside):.2f} from outside")


if __name__ == "__main__":
    run_script(main)
