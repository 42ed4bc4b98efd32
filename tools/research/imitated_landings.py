"""Where in its cycle the left foot of an imitated gait comes down to the ground on which the right one stands.

For docs/tutorials/learn.md.

python tools/research/imitated_landings.py gait2392_arms_feet.toml --speed 1.25 --tilt 13 --norm "Pinzone 2014"

A foot that is to land at 0 % and is above the other one until later lands late, with every joint where it should be.
Where it is far below the other one, that has left the ground.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from msgspec.structs import replace

from warpmuscle.cli.ending import run_script
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.formats import scene_of
from warpmuscle.learning import EpisodeBatch
from warpmuscle.learning.imitation import BINS, Gait
from warpmuscle.learning.imitation.pelvis import orientation_of
from warpmuscle.learning.imitation.people import poses_over
from warpmuscle.learning.imitation.table import gait_at
from warpmuscle.scene.anatomy import foot_bodies
from warpmuscle.scene.geometry import lowest_point
from warpmuscle.simulation.rollout import Rollout

AROUND = np.arange(-8, 13)  # % of the cycle about the landing


def hanging(gait: Gait, rollout: Rollout) -> Floats:
    """How far the left foot is above the right one about its landing, mm."""
    bins = AROUND * BINS // 100 % BINS
    poses = poses_over(gait.coordinate[bins], rollout, orientation_of(gait.up[bins]))
    character = rollout.numeric.character
    left, right = (
        lowest_point(character, {body: poses[body] for body in foot_bodies(character, foot)})
        for foot in rollout.numeric.feet or ()
    )
    return 1000.0 * np.asarray(left - right)


def main(
    task: Path,
    speed: Annotated[list[float] | None, typer.Option(help="m/s, wanted.")] = None,
    tilt: Annotated[list[float] | None, typer.Option(help="deg, by which the pelvis leans.")] = None,
    norm: Annotated[str | None, typer.Option(help="Whose legs; the task's if not given.")] = None,
) -> None:
    """Print heights of the left foot, mm, about the landing."""
    scene = scene_of(str(task))
    if scene.learning is None or scene.learning.imitation is None:
        raise Error(f"{task}: nothing is imitated")
    print(f"| m/s | degrees | mm at {', '.join(map(str, AROUND))} % |\n|---|---|---|")
    imitation = scene.learning.imitation
    legs = imitation if norm is None else replace(imitation, norm=norm)
    for lean in tilt or [imitation.pelvis_tilt]:
        asked = replace(scene.learning, imitation=replace(legs, pelvis_tilt=lean))
        batch = EpisodeBatch(scene, 1, "cpu", asked)
        assert batch.gait is not None
        for wanted in speed or [1.25]:
            heights = hanging(gait_at(batch.gait, asked, batch.rollout, wanted), batch.rollout)
            print(f"| {wanted:g} | {lean:g} | {' '.join(f'{one:.0f}' for one in heights)} |", flush=True)


if __name__ == "__main__":
    run_script(main)
