"""How closely scenes made of MuJoCo models agree with MuJoCo, as a table for the manual; without contact and limits.

    python tools/mujoco_agreement.py FOLDER/myohand.xml FOLDER/myolegs.xml --poses 200 -o table.md

Poses are drawn within the ranges of joints, with speeds and activations. Columns: the greatest difference of path
lengths, moment arms and forces of muscles (over f_max), and of accelerations over the greatest of each coordinate.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from mujoco_ours import computed
from mujoco_poses import Floats, NotCompared, Oracle

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import Ignored

COLUMNS = ("model", "bodies", "coordinates", "muscles", "length, m", "moment arm, m", "force", "acceleration")
LISTED = 3


def row(path: Path, count: int, seed: int) -> str:
    """A row of the table."""
    lost: list[Ignored] = []
    try:
        scene = wm.load(path, ignored=lost)
    except SceneError as error:
        return f"| {path.stem} | | | | {error} | | | |"
    try:
        oracle = Oracle(path)
    except NotCompared as error:
        return f"| {path.stem} | {len(scene.character.bodies)} | | {len(scene.character.muscles)} | {error} | | | |"
    oracle.keep(set(scene.character.muscles))
    found = oracle.poses(count, seed)
    length, _, arm, force, acceleration = computed(scene, found)
    f_max = np.array([float(scene.character.muscles[name].f_max) for name in found.muscles])  # type: ignore[arg-type]
    most = np.maximum(np.abs(found.acceleration).max(axis=0), 1e-9)
    known = np.isfinite(force)
    off = {
        "length": np.abs(length - found.length),
        "arm": np.abs(arm - found.arm),
        "force": np.where(known, np.abs(force - found.force) / f_max, 0.0),
        "acceleration": np.abs(acceleration - found.acceleration) / most,
    }
    for name, values in off.items():
        worst(name, values, found.names if name == "acceleration" else found.muscles)
    cells = [f"{values.max(initial=0.0):.1g}" for values in off.values()]
    sizes = [len(scene.character.bodies), len(found.names), len(found.muscles)]
    return f"| {path.stem} | {' | '.join(map(str, sizes))} | {' | '.join(cells)} |"


def worst(name: str, values: Floats, labels: list[str]) -> None:
    """Say where the greatest differences are."""
    flat = values if values.ndim == 2 else values.max(axis=2)
    by_label = flat.max(axis=0)
    for k in np.argsort(-by_label)[:LISTED]:
        print(f"  {name}: {labels[k]} {by_label[k]:.2g}, in the median {np.median(flat[:, k]):.2g}")


def main(
    models: list[Path],
    poses: Annotated[int, typer.Option(help="drawn states of each model")] = 200,
    seed: int = 1,
    output: Annotated[Path | None, typer.Option("-o", help="file of the table")] = None,
) -> None:
    """Compare models, and write a table."""
    warnings.simplefilter("ignore")
    lines = [f"| {' | '.join(COLUMNS)} |", "|" + "---|" * len(COLUMNS)]
    for path in models:
        lines.append(row(path, poses, seed))
        print(lines[-1], flush=True)
    if output is not None:
        output.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    run_script(main)
