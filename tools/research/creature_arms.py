"""Moment arms of the muscles that searches found for the creature `walker`, beside those of OpenSim's gait2392.

For docs/how-to/creatures.md.

warpmuscle example creatures
python tools/research/creature_arms.py walker.toml walker_found.toml    more files: the range of several searches
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import typer

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.creatures.build import creature_scene, read_creature
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import at_start
from warpmuscle.studies.moment_arms import moment_arms

SAMPLES = 21


class Joint(NamedTuple):
    """A joint of both models, and the angles of walking about it."""

    theirs: str
    axis: int  # of the ball joint
    sign: float  # by which their angles are ours; those of balls are about x of the body as ours are
    range: tuple[float, float]  # rad, ours: positive swings a hanging limb backwards


JOINTS = {
    "lHip": Joint("hip_l", 0, 1.0, (-0.5, 0.25)),
    "lKnee": Joint("knee_angle_l", 0, -1.0, (0.05, 1.1)),
    "lAnkle": Joint("ankle_angle_l", 0, -1.0, (-0.2, 0.3)),
}
GROUPS = {
    "GLU": ("glut_max1", "glut_max2", "glut_max3"),
    "HFL": ("iliacus", "psoas"),
    "HAM": ("semimem", "semiten", "bifemlh"),
    "RF": ("rect_fem",),
    "VAS": ("vas_med", "vas_int", "vas_lat"),
    "GAS": ("med_gas", "lat_gas"),
    "SOL": ("soleus",),
    "TA": ("tib_ant",),
}
Arms = dict[tuple[str, str], np.ndarray]  # by muscle and joint, m, over the angles; positive swings backwards


def angles(joint: Joint) -> np.ndarray:
    """Over which arms are compared, rad."""
    return np.linspace(*joint.range, SAMPLES)


def of_walker(scene: Scene) -> Arms:
    """Of the muscles of the left leg."""
    found = {}
    for name, joint in JOINTS.items():
        arms = moment_arms(scene, name, 0, angles(joint))
        for k, muscle in enumerate(arms.muscles):
            found[muscle.removeprefix("l"), name] = arms.arm[:, k]
    return found


def of_gait2392() -> Arms:
    """Of its groups of muscles, means by strength."""
    scene = at_start(wm.load("gait2392_walk"))
    strength = {name: float(muscle.f_max) for name, muscle in scene.character.muscles.items()}  # type: ignore[arg-type]
    found = {}
    for name, joint in JOINTS.items():
        arms = moment_arms(scene, joint.theirs, joint.axis, joint.sign * angles(joint))
        for group, members in GROUPS.items():
            columns = [arms.muscles.index(f"{one}_l") for one in members if f"{one}_l" in arms.muscles]
            if columns:
                weights = [strength[arms.muscles[k]] for k in columns]
                found[group, name] = joint.sign * np.average(arms.arm[:, columns], axis=1, weights=weights)
    return found


def main(
    creature: Annotated[Path, typer.Argument(help="description, in which muscles are placed badly")],
    found: Annotated[list[Path], typer.Argument(help="scenes or results of searches")],
) -> None:
    """Print a table, mm: means over the angles of walking."""
    begins = of_walker(at_start(creature_scene(read_creature(creature))))
    searches = [of_walker(at_start(wm.load(path))) for path in found]
    people = of_gait2392()
    print("| muscle | joint | where a search begins, mm | found, mm | gait2392, mm |\n|---|---|---|---|---|")
    same, off = [], []
    for (muscle, joint), theirs in people.items():
        if (muscle, joint) not in begins:
            continue
        ours = [1e3 * one[muscle, joint].mean() for one in searches]
        wanted = 1e3 * theirs.mean()
        shown = f"{ours[0]:.0f}" if len(ours) == 1 else f"{min(ours):.0f} to {max(ours):.0f}"
        print(
            f"| {muscle} | {joint.removeprefix('l').lower()} | {1e3 * begins[muscle, joint].mean():.0f} | {shown} |"
            f" {wanted:.0f} |"
        )
        same += [one * wanted > 0.0 for one in ours]
        off.append((abs(1e3 * begins[muscle, joint].mean() - wanted), np.mean([abs(one - wanted) for one in ours])))
    before, after = np.mean(off, axis=0)
    print(f"\nthe same side: {sum(same)} of {len(same)}; mean difference {before:.0f} mm before, {after:.0f} mm after")


if __name__ == "__main__":
    run_script(main)
