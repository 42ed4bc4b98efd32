"""Instance-steps per second of the fused step, in all and by stage, against MuJoCo (C) on the same character.

    python tools/bench_step.py                                   one CPU core, as a ratio to MuJoCo in the same run
    python tools/bench_step.py --muscles                         the same for a character that muscles drive
    python tools/bench_step.py --device cuda:0 --instances 1024,5120,65536
    python tools/bench_step.py --json bench.json

Both sides simulate the walk from the scene's initial state over the same time again and again. MuJoCo steps the
exported character with its feet on the ground but without a controller, its muscles at a constant excitation; we step
it with ours. The ratio is to its implicitfast integrator, which the export asks for, and to its cheaper Euler one.
Steps of instances that have failed do not count. For muscles, the cost of compliant tendons is measured against that
of rigid ones, all else equal. How the time of a stage is found is said in `bench_gpu.py`.
"""

from __future__ import annotations

import json
import platform
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
import typer
import warp as wp
from stage_times import StageTimes

from warpmuscle.cli.ending import run_script
from warpmuscle.formats import load, mjcf
from warpmuscle.model.muscles import driven
from warpmuscle.scene import Scene
from warpmuscle.simulation.rollout import Rollout

EXCITATION = 0.05  # of MuJoCo's muscles
Run = Callable[[], int]  # makes steps and returns how many


def best_rate(run: Run, repeats: int, clock: Callable[[], float] = time.perf_counter) -> float:
    """Steps per second of the fastest of several runs of a function that returns how many it made."""
    rates = []
    for _ in range(repeats):
        begin = clock()
        steps = run()
        rates.append(steps / (clock() - begin))
    return max(rates)


def prepared(scene: Scene, instances: int, device: str, seconds: float) -> tuple[Rollout, Run]:
    """A rollout on one CPU thread or a GPU, and a function that runs it over `seconds` from the start."""
    rollout = Rollout(scene, instances, device, threads=1)

    def run() -> int:
        rollout.reset()
        rollout.run(seconds)
        wp.synchronize()
        return steps

    steps = 0
    run()
    steps = int(rollout.state.step.numpy().sum())
    return rollout, run


def mujoco_runner(scene: Scene, seconds: float, integrator: str) -> Run:
    """A function that makes the steps in MuJoCo from the initial state."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(mjcf.dumps(scene, up="y"))
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    data = mujoco.MjData(model)
    count = round(seconds / scene.time_step)

    def run() -> int:
        mujoco.mj_resetDataKeyframe(model, data, 0)
        data.ctrl[:] = EXCITATION
        mujoco.mj_step(model, data, nstep=count)
        return count

    run()
    return run


def rates_and_ratio(ours: Run, other: Run, repeats: int, device: str = "cpu") -> tuple[float, float, float]:
    """Steps per second of both, and the median of their ratio over runs in turn.

    On a CPU seconds are those of the processor, so that other work on the machine changes little.
    """
    clock = time.process_time if device == "cpu" else time.perf_counter
    pairs = [(best_rate(ours, 1, clock), best_rate(other, 1, clock)) for _ in range(repeats)]
    a, b = np.max(pairs, axis=0).tolist()
    return a, b, float(np.median([a / b for a, b in pairs]))


def stage_times(rollout: Rollout, seconds: float, repeats: int) -> dict[str, float]:
    """Time of each stage by a step of one instance, microseconds (on a GPU: by a step of the whole batch)."""
    times = StageTimes(rollout, 0.0).split(round(seconds / rollout.scene.time_step), repeats)
    return {name: time / (rollout.instances if rollout.device.is_cpu else 1) for name, time in times.items()}


def tendons_ratio(scene: Scene, instances: int, device: str, seconds: float, repeats: int) -> float:
    """Time of a step with compliant tendons over that with rigid ones."""
    runs = []
    for tendon in ("rigid", "compliant"):
        model = msgspec.structs.replace(scene.muscle_model, tendon=tendon, legacy=False, ideal=False)
        runs.append(prepared(msgspec.structs.replace(scene, muscle_model=model), instances, device, seconds)[1])
    return rates_and_ratio(runs[0], runs[1], repeats, device)[2]


def figures_of(scene: Scene, instances: int, device: str, seconds: float, repeats: int, stages: bool) -> dict[str, Any]:
    """All figures of a batch size."""
    rollout, ours = prepared(scene, instances, device, seconds)
    figures: dict[str, Any] = {}
    if device == "cpu":
        for integrator, suffix in (("Euler", "_euler"), ("implicitfast", "")):
            names = ("steps_per_second", f"mujoco_steps_per_second{suffix}", f"ratio{suffix}")
            peer = mujoco_runner(scene, seconds, integrator)
            figures.update(zip(names, rates_and_ratio(ours, peer, repeats), strict=True))
    else:
        figures["steps_per_second"] = best_rate(ours, repeats)
    if driven(scene, rollout.names).muscles:
        figures["muscles"] = rollout.model.muscles.count
        figures["compliant_over_rigid"] = tendons_ratio(scene, instances, device, seconds, repeats)
    if stages:
        figures["stage_microseconds"] = stage_times(rollout, seconds, repeats)
    return figures


def show(instances: int, figures: dict[str, Any]) -> None:
    """Print the figures of a batch size."""
    print(f"{instances:7d} instances: {figures['steps_per_second'] / 1e6:9.3f} million steps/s", end="")
    if "ratio" in figures:
        print(f", {figures['ratio']:.1f} times MuJoCo ({figures['ratio_euler']:.1f} with Euler's method)", end="")
    print()
    if "muscles" in figures:
        print(f"          {figures['muscles']} muscles, compliant / rigid = {figures['compliant_over_rigid']:.2f}")
    for name, value in figures.get("stage_microseconds", {}).items():
        print(f"          {name:26s}{value:9.3f} us", flush=True)


def main(
    scene: Annotated[list[str] | None, typer.Option(help="Scene or file, see `load`; once for each file.")] = None,
    muscles: Annotated[bool, typer.Option(help="By default a scene with muscles: walk56 instead of fwalk.")] = False,
    device: Annotated[str, typer.Option(help="cpu for one core, or cuda:0.")] = "cpu",
    instances: Annotated[str, typer.Option(help="Batch sizes, separated by commas.")] = "",
    seconds: Annotated[float, typer.Option(help="Simulated time of a run.")] = 0.5,
    repeats: Annotated[int, typer.Option(help="Runs, of which the fastest counts.")] = 7,
    stages: Annotated[bool, typer.Option(help="Also time the stages.")] = True,
    json_path: Annotated[Path | None, typer.Option("--json", help="File for the figures.")] = None,
) -> None:
    """Time the fused step."""
    wp.config.log_level = wp.LOG_WARNING
    loaded = load(*(scene or ["walk56" if muscles else "fwalk"]), ignored=[])
    sizes = [int(n) for n in (instances or ("64" if device == "cpu" else "1024,4096,5120,16384,65536")).split(",")]
    figures: dict[str, Any] = {"scene": loaded.name, "device": device, "machine": platform.processor(), "sizes": {}}
    for n in sizes:
        figures["sizes"][n] = figures_of(loaded, n, device, seconds, repeats, stages)
        show(n, figures["sizes"][n])
    if json_path is not None:
        json_path.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    run_script(main)
