"""On which ground that is not flat gaits stay upright whose controllers know nothing of it.

For docs/how-to/walk-on-uneven-ground.md.

python tools/research/terrain_table.py                     table in Markdown, 20 walks of 10 s each; minutes of one core
python tools/research/terrain_table.py fwalk mine.toml     of these scenes
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import msgspec
import numpy as np
import typer

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.scene import Scene, Terrain
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.terrain.tiles import AnyTile, Gaps, Rough, Slope, Stairs, Stones, Waves
from warpmuscle.simulation.rollout import Rollout

SCENES = ["fwalk", "bigbird_walk", "bwalk", "walk56"]
WALKS, SECONDS = 20, 10.0
BACKWARDS = ("bwalk", "back56")  # whose ground is turned round


class Ground(NamedTuple):
    """A row of the table."""

    words: str
    tile: AnyTile
    scale: float
    along: float  # m, over which the places of walks are spread


BUMPS, NEAR_BUMPS = Rough(height=1.0, spacing=0.3), Rough(height=1.0, spacing=0.1)
STAIRS = Stairs(rise=1.0, tread=0.4, count=5, start=1.5, landing=1.0)
GROUNDS = [
    *(Ground(f"bumps of {cm} cm, 30 cm apart", BUMPS, 0.01 * cm, 16.0) for cm in (1, 2, 3, 5)),
    Ground("bumps of 2 cm, 10 cm apart", NEAR_BUMPS, 0.02, 16.0),
    Ground("slope of 1 degree", Slope(np.radians(1.0)), 1.0, 1.0),
    Ground("waves of 2 cm, 2 m long", Waves(height=1.0, length=2.0), 0.02, 1.0),
    *(Ground(f"five stairs of {cm} cm up and down", STAIRS, 0.01 * cm, 1.0) for cm in (1, 3, 5)),
    Ground("trenches of 10 cm, 1 m apart, 5 cm deep", Gaps(width=0.1, depth=1.0, spacing=1.0, count=12), 0.05, 1.0),
    Ground("stones of 40 cm, 6 cm apart", Stones((0.6, 0.4), gap=0.06, depth=1.0, count=(6, 24)), 0.05, 1.0),
]  # fmt: skip


def upright(scene: Scene) -> list[int]:
    """How many of the walks do not fall, on each ground."""
    tiles = [ground.tile for ground in GROUNDS]

    def on(terrain: Terrain) -> Scene:
        return msgspec.structs.replace(scene, ground=msgspec.structs.replace(scene.ground, terrain=terrain))

    rollout = Rollout(on(Terrain(tiles)), WALKS, "cpu", threads=1)
    yaw, found = np.pi if scene.name in BACKWARDS else 0.0, []
    across = np.random.default_rng(0).uniform(-4.0, 4.0, WALKS)
    for number, ground in enumerate(GROUNDS):
        along = ground.along * np.linspace(-0.5, 0.5, WALKS)
        place = {"tile": float(number), "scale": ground.scale, "x": across, "z": along, "yaw": yaw}
        rollout.change(on(Terrain(tiles, **place)))
        rollout.reset()
        rollout.run(SECONDS)
        stands = np.isin(rollout.status(), [wm.Status.RUNNING, wm.Status.COMPLETED])
        found.append(int(stands.sum()))
    return found


def main(scenes: Annotated[list[str] | None, typer.Argument(help="Names or files.")] = None) -> None:
    """Print the table."""
    names = scenes or SCENES
    columns = []
    for name in names:
        scene = wm.load(name)
        columns.append(upright(at_start(scene)))
    print("| |", " | ".join(f"`{name}`" for name in names), "|")
    print("|---|" + "---|" * len(names))
    for row, ground in enumerate(GROUNDS):
        print(f"| {ground.words} |", " | ".join(str(column[row]) for column in columns), "|")


if __name__ == "__main__":
    run_script(main)
