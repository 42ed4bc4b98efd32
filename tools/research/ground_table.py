"""How near measured walks run forward on the ground of a simulation, from excitations of muscles alone.

For docs/how-to/run-a-recording-on-the-ground.md.

python tools/research/ground_table.py            the folder that WARPMUSCLE_REFERENCE_DATA names
python tools/research/ground_table.py --figure docs/pictures/ground_forces.png
"""

from __future__ import annotations

import os
import time
import warnings
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from warpmuscle.cli.ending import run_script
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.files import read_coordinates
from warpmuscle.inverse.loads import read_loads
from warpmuscle.inverse.tracking.track import track
from warpmuscle.inverse.tracking.tracked import Tracked

DATA = Path(os.environ.get("WARPMUSCLE_REFERENCE_DATA", "../shared/data"))
WALKS = {  # model, coordinates, loads, begin and end, whether reserves act
    "18 muscles": (
        "opensim_walk/cmc/subject01_metabolics.osim", "opensim_walk/cmc/walk_subject_Kinematics_q.sto",
        "opensim_walk/subject01_walk_grf.xml", (0.6, 2.0), True,
    ),
    "92 muscles": (
        "inverse/static_optimization_92/subject01_simbody_adjusted_StaticOp.osim",
        "inverse/static_optimization_92/subject01_walk1_Kinematics.sto",
        "inverse/static_optimization_92/foot_floor_loads.xml", (None, None), True,
    ),
    "80 muscles": (
        "inverse/synthetic_walk/subject01/subject01.osim", "inverse/synthetic_walk/subject01/coordinates.sto",
        "inverse/synthetic_walk/subject01/grf.mot", (None, None), True,
    ),
}  # fmt: skip
WALKS["80 muscles, second subject"] = (
    *(path.replace("subject01", "subject02") for path in WALKS["80 muscles"][:3]), (None, None), True,
)  # fmt: skip
WALKS["92 muscles, no reserves"] = (*WALKS["92 muscles"][:4], False)


def followed(name: str, device: str | None) -> tuple[Tracked, float]:
    """A walk on the ground, and the CPU time that it took, s."""
    model, motion, loads, (begin, end), reserves = WALKS[name]
    body = BodyModel(DATA / model, device)
    recorded = read_coordinates(DATA / motion, body.scene, False if "synthetic" in motion else None)
    start = time.process_time()
    found = track(
        body, recorded, read_loads(DATA / loads), filter=6.0, begin=begin, end=end, ground=True, reserves=reserves
    )
    assert isinstance(found, Tracked)
    return found, time.process_time() - start


def tell(name: str, found: Tracked, took: float) -> None:
    """Figures of a walk."""
    turns = [k for k, unit in enumerate(found.units) if unit == "rad"]
    order = sorted(turns, key=lambda k: -found.rms[k])
    print(f"{name}: {found.times[-1] - found.times[0]:.2f} s in {took:.0f} s of CPU time, lost: {found.lost}")
    print("  angles, RMS, degrees:", ", ".join(f"{found.names[k]} {np.degrees(found.rms[k]):.2f}" for k in order))
    acting = [k for k in np.argsort(-found.greatest_effort) if found.greatest_effort[k] > 0.05]
    shown = [
        f"{found.names[k]} {found.greatest_effort[k]:.1f} (RMS {np.sqrt(np.mean(found.effort[:, k] ** 2)):.1f})"
        for k in acting
    ]
    print("  acted beside muscles, N m or N:", ", ".join(shown) or "nothing")
    assert found.ground is not None
    for side, word in enumerate(("left", "right")):
        own, plates = found.ground.force[:, side], found.ground.plates[:, side]
        alike = [np.corrcoef(own[:, k], plates[:, k])[0, 1] for k in (1, 2)]
        off = found.ground.force_error[side]
        print(f"  {word} foot: up {off[1]:.0f} N RMS from plates (correlation {alike[0]:.2f}, greatest "
              f"{own[:, 1].max():.0f} and {plates[:, 1].max():.0f} N), forward {off[2]:.0f} N ({alike[1]:.2f}), "
              f"aside {off[0]:.0f} N")  # fmt: skip
    print(f"  lifted by {1000 * found.ground.lift.min():.0f} to {1000 * found.ground.lift.max():.0f} mm; belt "
          f"{abs(found.ground.belt[2]):.2f} m/s")  # fmt: skip


def draw(runs: dict[str, Tracked], path: Path) -> None:
    """Forces of the ground and of plates, by walk and foot."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(len(runs), 2, figsize=(8.0, 2.6 * len(runs)), sharey=True, squeeze=False)
    for row, (name, one) in zip(axes, runs.items(), strict=True):
        assert one.ground is not None
        for side, word in enumerate(("left foot", "right foot")):
            for axis, color, what in ((1, "#2f69cf", "up"), (2, "#c0562b", "forward")):
                row[side].plot(one.times[1:], one.ground.plates[:, side, axis], color=color, alpha=0.35, lw=3)
                row[side].plot(one.times[1:], one.ground.force[:, side, axis], color=color, label=what)
            row[side].set_title(f"{name}, {word}", fontsize=9)
            row[side].set_xlabel("s")
        row[0].set_ylabel("N")
    axes[0][0].legend(frameon=False, fontsize=8)
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def main(
    figure: Annotated[Path | None, typer.Option(help="Picture of the forces, .png.")] = None,
    only: Annotated[str, typer.Option(help="Of walks whose names have this in them.")] = "",
    device: Annotated[str | None, typer.Option(help="cpu, cuda:0, ...")] = None,
) -> None:
    """Follow the walks, and print how near they come."""
    warnings.simplefilter("ignore")
    runs = {}
    for name in WALKS:
        if only in name:
            runs[name], took = followed(name, device)
            tell(name, runs[name], took)
    if figure is not None:
        draw({name: one for name, one in runs.items() if "no reserves" not in name}, figure)


if __name__ == "__main__":
    run_script(main)
