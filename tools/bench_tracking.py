"""How fast simulations follow recorded motions: windows a second of many trials at once, and how far they are away.

    python tools/bench_tracking.py MODEL.osim MOTION.sto --loads LOADS.xml
    python tools/bench_tracking.py MODEL.osim MOTION.sto --loads LOADS.xml --trials 1000 --device cuda:0
    python tools/bench_tracking.py MODEL.osim MOTION.sto --loads LOADS.xml --ground

Trials are the motion again and again, each a little other than those before. The time is of the second run, kernels
being compiled; it includes the run by the excitations alone.
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from warpmuscle.cli.ending import run_script
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.files import read_coordinates
from warpmuscle.inverse.loads import read_loads
from warpmuscle.inverse.tracking.track import track
from warpmuscle.inverse.trial import Coordinates

NOISE = 0.002  # of a coordinate's range, by which trials differ


def main(
    model: Path,
    motion: Path,
    loads: Path | None = None,
    trials: int = 1,
    begin: float | None = None,
    end: float | None = None,
    filter: float | None = 6.0,
    ground: bool = False,
    device: str = "cpu",
) -> None:
    """Follow so many motions twice, and print how long the second time took."""
    body = BodyModel(model, device)
    recorded = read_coordinates(motion, body.scene)
    plates = None if loads is None else [read_loads(loads)] * trials
    random, size = np.random.default_rng(0), NOISE * np.ptp(recorded.values, axis=0)
    motions = [
        Coordinates(recorded.names, recorded.times, recorded.values + (k > 0) * size * random.normal(size=len(size)))
        for k in range(trials)
    ]
    for run in range(2):
        start = time.perf_counter()
        found = track(body, motions, plates, filter=filter, begin=begin, end=end, ground=ground)
        took = time.perf_counter() - start
        assert isinstance(found, list)
        windows = sum(len(one.excitation) for one in found)
        print(
            f"{'again' if run else 'first, with compiling'}: {took:.2f} s, {windows / took:.0f} windows/s", flush=True
        )
    turns = [k for k, unit in enumerate(found[0].units) if unit == "rad"]
    angles = np.degrees(np.stack([one.rms[turns] for one in found]))
    roots = np.stack([one.greatest_effort[: one.residuals] for one in found])
    print(f"angles, RMS: median {np.median(angles):.3f}, greatest {angles.max():.3f} degrees")
    if found[0].ground is not None:
        print("ground beside plates, RMS by foot and axis, N:", *found[0].ground.force_error.round(1).ravel())
    print(f"lost: {sum(one.lost is not None for one in found)} of {trials}; most at the root: {roots.max(axis=0)}")


if __name__ == "__main__":
    run_script(main)
