"""Which OpenSim models of a folder load, and how closely they agree with OpenSim 4.6: a table for the manual.

    python tools/model_table.py FOLDER --poses 200 --beyond 50 -o table.md

Each model that loads is compared by `opensim_agreement.py` in random poses inside the ranges of its coordinates and in
some beyond them by up to a quarter of a range. The columns are the part of path lengths within 1e-5 m, that of moment
arms within 1e-4 m, and the worst of mass matrix and inverse dynamics over their scale. Others have the reason.
"""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer
import warp as wp
from opensim_agreement import compare

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Scene
from warpmuscle.scene.topology import followed_drivers, topology

BEYOND = 0.25  # of each range
WAYS = ("path length", "moment arm", "mass matrix", "inverse dynamics")
COLUMNS = (
    "model",
    "bodies",
    "coordinates",
    "muscles",
    *(f"{way}, inside" for way in WAYS),
    "path length, moment arm beyond",
)


@dataclass
class Row:
    """A model, and what is to be said of it."""

    name: str
    scene: Scene | None
    inside: dict[str, dict[str, Any]]
    outside: dict[str, dict[str, Any]]
    reason: str = ""

    def text(self) -> str:
        """The row of the table."""
        if self.scene is None:
            return f"| {self.name} | | | | {self.reason} | | | | |"
        names, muscles = topology(self.scene.character), len(self.scene.character.muscles)
        followed = len(followed_drivers(self.scene.character, names))
        speeds = f"{names.speeds}" + (f", {followed} of them followed from afar" if followed else "")
        cells = [_cell(self.inside, way) for way in WAYS]
        outside = f"{_cell(self.outside, WAYS[0])}, {_cell(self.outside, WAYS[1])}"
        return f"| {self.name} | {len(names.bodies)} | {speeds} | {muscles} | {' | '.join(cells)} | {outside} |"


def _cell(measures: dict[str, dict[str, Any]], way: str) -> str:
    if way not in measures:
        return "-"
    one = measures[way]
    return f"{100.0 * one['within']:.2f} %" if way in WAYS[:2] else f"{one['worst']:.0e}"


def row_of(file: Path, poses: int, beyond: int) -> Row:
    """Load a model and compare it."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = wm.load(file)
    except SceneError as error:
        return Row(file.stem, None, {}, {}, error.message)
    sides = []
    for count, part in ((poses, 0.0), (beyond, BEYOND)):
        measures: list[dict[str, Any]] = []
        if count:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                measures = compare(file, count, 1, 0, False, part)["measures"]
        sides.append({one["name"]: one for one in measures})
    return Row(file.stem, scene, *sides)


def main(
    folder: Annotated[Path, typer.Argument(help="Folder of models.")],
    poses: Annotated[int, typer.Option(help="Random poses inside the ranges.")] = 200,
    beyond: Annotated[int, typer.Option(help="Random poses beyond them.")] = 50,
    output: Annotated[Path | None, typer.Option("-o", help="File for the table.")] = None,
) -> None:
    """Make the table."""
    wp.config.log_level = wp.LOG_WARNING
    lines = [f"| {' | '.join(COLUMNS)} |", "|---" * len(COLUMNS) + "|"]
    for file in sorted(folder.glob("*.osim")):
        lines.append(row_of(file, poses, beyond).text())
        print(lines[-1], flush=True)
        if output is not None:
            part = output.with_suffix(".part")
            part.write_text("\n".join(lines) + "\n")
            os.replace(part, output)


if __name__ == "__main__":
    run_script(main)
