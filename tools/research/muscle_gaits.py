"""How the shipped walks on muscles hold up, with rigid and with compliant tendons.

For docs/explanation/muscles.md.

python tools/research/muscle_gaits.py        table in Markdown: survivors of perturbed runs, speed, median time of falls
"""

from __future__ import annotations

import msgspec
import numpy as np
import warp as wp

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.core.status import Status

RUNS = (  # scene, runs, duration s, noise of the root's velocity m/s
    ("walk56", 1, 60.0, 0.0),
    ("walk56", 20, 30.0, 0.01),
    ("walk56", 32, 10.0, 0.1),
    ("walk56_human", 20, 10.0, 0.05),
    ("walk44_but_hips", 8, 20.0, 0.01),
    ("walk50_but_back", 8, 20.0, 0.01),
    ("legs28", 8, 20.0, 0.01),
    ("jog56", 8, 20.0, 0.01),
    ("wang2012", 12, 20.0, 0.01),
)
LEGACY = (("walk56_legacy", "1.18"), ("walk44_legacy", "1.7"))  # median of the original's falls, s
SEED = 3


def rollout_of(name: str, runs: int, duration: float, noise: float, tendon: str = "") -> wm.Rollout:
    """Perturbed runs of a scene, to their end."""
    scene = msgspec.structs.replace(wm.load(name), duration=duration)
    if tendon:
        scene = msgspec.structs.replace(scene, muscle_model=msgspec.structs.replace(scene.muscle_model, tendon=tendon))
    rollout = wm.Rollout(scene, runs, "cpu", record=[0])
    rollout.reset(noise, SEED)
    rollout.run()
    return rollout


def main() -> None:
    """Print the tables."""
    wp.config.log_level = wp.LOG_WARNING
    print("| scene | runs | velocity noise, m/s | rigid: upright, speed | compliant: upright, speed |")
    print("|---|---|---|---|---|")
    for name, runs, duration, noise in RUNS:
        cells = []
        for tendon in ("rigid", "compliant"):
            rollout = rollout_of(name, runs, duration, noise, tendon)
            upright = int((rollout.status() == Status.COMPLETED).sum())
            controller = rollout.scene.controller
            assert controller is not None
            speed = wm.measure(rollout.recording(), *controller.feet).speed_forward
            fall = float(np.median(rollout.end_time()))
            cells.append(f"{upright}, {speed:.2f} m/s" if upright else f"0, falls at {fall:.1f} s")
        print(f"| `{name}` | {runs} x {duration:g} s | {noise:g} | {' | '.join(cells)} |", flush=True)
    print("\n| scene | median fall of 20 runs | original |\n|---|---|---|")
    for name, original in LEGACY:
        fall = np.median(rollout_of(name, 20, 5.0, 0.01).end_time())
        print(f"| `{name}` | {fall:.2f} s | {original} s |", flush=True)


if __name__ == "__main__":
    run_script(main)
