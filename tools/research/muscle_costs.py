"""What each muscle of a recorded walk spends, and when it is active.

For docs/tutorials/learn.md.

python tools/research/muscle_costs.py walks.h5 --most 20

The file is one that `warpmuscle simulate -o` wrote. Muscles of both sides are one row, by their names without `_l` and
`_r`: the cost of transport by Bhargava's formula with net work, without the body at rest, and the mean activation of
the left one in each tenth of the gait cycle.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from msgspec.structs import replace

from warpmuscle.cli.ending import run_script
from warpmuscle.core.errors import Error
from warpmuscle.gait.cycles import over_strides, steady_strides
from warpmuscle.gait.muscle_effort import muscle_power
from warpmuscle.gait.quality import gait_measures
from warpmuscle.optimization.best_scene import scene_in
from warpmuscle.results.partial_motion import motion_of
from warpmuscle.results.result import read
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.parameters import at_start

SETTLED = 3.0  # s, before which the costs do not count
SIDES = ("_l", "_r")


def rows(file: Path) -> list[tuple[float, str, list[float]]]:
    """Of every pair of muscles: J/(kg m), its name, mean activations of the left one; the costliest first."""
    result = read(file, replay=0)
    motion, scene = motion_of(result, str(file), 0), at_start(scene_in(result))
    scene = replace(scene, objective=replace(scene.objective, metabolic_model="bhargava", metabolic_work=None))
    power = muscle_power(motion, scene)[motion.time > SETTLED].mean(axis=0) / body_mass(scene.character)
    speed = gait_measures(motion, scene)["speed"]
    if speed is None or not speed > 0.0:
        raise Error(f"{file}: the motion does not go forward")
    strides, names, found = steady_strides(motion, scene)["left"], motion.muscle_names, []
    for index, name in enumerate(names):
        if not name.endswith(SIDES[0]):
            continue
        pair = [names.index(name[: -len(SIDES[0])] + side) for side in SIDES]
        curve = over_strides(motion.time, motion.muscle_activation[:, index], strides).mean(axis=0)[:100]
        found.append((float(power[pair].sum() / speed), name[:-2], curve.reshape(10, 10).mean(axis=1).tolist()))
    return sorted(found, reverse=True)


def main(file: Path, most: Annotated[int, typer.Option(help="How many rows.")] = 20) -> None:
    """Print a table."""
    found = rows(file)
    print(f"| muscle | J/(kg m), of {np.sum([cost for cost, *_ in found]):.2f} | activation in each tenth |")
    print("|---|---|---|")
    for cost, name, curve in found[:most]:
        print(f"| {name} | {cost:.2f} | {' '.join(f'{value:.2f}' for value in curve)} |")


if __name__ == "__main__":
    run_script(main)
