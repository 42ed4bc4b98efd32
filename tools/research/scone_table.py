"""Whether SCONE's scenarios walk here: as they are, with parameters of theirs, and after short searches.

    .venv/bin/python tools/research/scone_table.py FOLDER --seeds 20

FOLDER has the scenarios, models and .par files of SCONE.

For docs/how-to/scone.md.
"""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path

from warpmuscle.core.status import Status
from warpmuscle.formats.load import load
from warpmuscle.optimization.best_scene import best_scene
from warpmuscle.optimization.optimize import optimize
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.simulation.rollout import Rollout

AS_THEY_ARE = (  # scenario, and parameters that were found for it
    ("benchmark_H0914_config.scone", "benchmark_H0914_230119.H0914.GH2010.D30.par"),
    ("Gait_-_H0914_-_Hyfydy.scone", "ResultH0914Gait10.par"),
    ("Gait_-_H0914_-_Hyfydy.scone", "Result.H0914.GH2010v8.S10W-572.par"),
    ("Gait_-_H0914_-_Hyfydy.scone", ""),
    ("Gait_-_H0918_-_Hyfydy.scone", ""),
)
SEARCHED = ("Gait_-_H0914_-_Hyfydy.scone", "Gait_-_H0918_-_Hyfydy.scone")


def scene_of(folder: Path, scenario: str, parameters: str = "") -> Scene:
    """A scenario with the best values of a .par file."""
    files = [folder / scenario, *([folder / parameters] if parameters else [])]
    return load(*files, ignored=[])


def walked(scene: Scene) -> tuple[str, float]:
    """How a run of a scene ended, and how far it walked a second, m/s."""
    rollout = Rollout(scene, device="cpu", record=[0])
    rollout.run()
    return Status(int(rollout.status()[0])).name.lower(), speed_of(rollout.recording(0))


def speed_of(motion: Recording) -> float:
    """How far the centre of mass came, over the time, m/s."""
    return float((motion.com[-1, 2] - motion.com[0, 2]) / motion.time[-1])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--candidates", type=int, default=500)
    parser.add_argument("--speeds", type=float, nargs="*", default=[1.0])
    chosen = parser.parse_args()
    warnings.simplefilter("ignore")
    print("| scenario | parameters | ended | m/s |\n|---|---|---|---|")
    for scenario, parameters in AS_THEY_ARE:
        ended, speed = walked(scene_of(chosen.folder, scenario, parameters))
        print(f"| {scenario} | {parameters or 'its own starts'} | {ended} | {speed:.2f} |", flush=True)
    print("\n| scenario | wanted m/s | seed | ended | m/s | cost |\n|---|---|---|---|---|---|")
    for scenario in SEARCHED:
        for wanted in chosen.speeds:
            for seed in range(1, chosen.seeds + 1):
                scene = scene_of(chosen.folder, scenario)
                scene.objective.target_speed = wanted
                result = optimize(scene, chosen.candidates, seed, "cpu", search="cma", sigma=0.005, threads=1)
                ended, speed = walked(best_scene(result)[0])
                print(
                    f"| {scenario} | {wanted:g} | {seed} | {ended} | {speed:.2f} | {result.best.cost:.3f} |", flush=True
                )


if __name__ == "__main__":
    main()
