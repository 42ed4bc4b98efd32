"""Where the time of the fused step goes on a GPU, and what its kernels take of it; beside MuJoCo Warp if installed.

    python tools/bench_gpu.py                                    everything, about 2 min, into tools/bench_gpu.json
    python tools/bench_gpu.py --kinds rigid --lanes 8 --no-peer  the walk on 56 muscles with rigid tendons only
    python tools/bench_gpu.py --stage-instances ""               totals only
    python tools/bench_gpu.py --device cpu --instances 64 --stage-instances 64 --json trial.json    without a GPU

- Totals are those of `Rollout.run` with the kernel that searches run, without the reset before it, for all batch sizes
  and lanes.
- Stages are those of the production kernel with a clock that is read as each of them ends: the time of a step is
  divided as the ticks of all instances are. So a stage has what it waits for others on its multiprocessor. Recording
  is what the production kernel takes longer if up to 5120 instances are recorded at 100 Hz.
- Registers, stack, shared memory and occupancy are what the CUDA driver says of the compiled kernels.
- Instances start with different velocities, so that they do not all take the same branches.
- MuJoCo Warp steps the exported character, its muscles at a constant excitation and without a controller, by a CUDA
  graph of one step. The ratio is that of the first kind with muscles, at the lanes of the stages.

All kernels are compiled before anything is timed, each in a process of its own.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any

import msgspec
import typer
import warp as wp
from fastest_run import fastest_run
from gpu_resources import resources
from mujoco_warp_peer import peer_rate
from stage_times import StageTimes

from warpmuscle.cli.ending import run_script
from warpmuscle.formats import load
from warpmuscle.scene import Scene
from warpmuscle.simulation.rollout import Rollout, find_device

KINDS = ("torques", "rigid", "compliant")
RECORDED = 5120
MANY = 65536  # instances, of which a run takes as long as is wanted
PEER = "peer"
JSON = Path(__file__).with_suffix(".json")
Figures = dict[str, Any]


def numbers(text: str) -> list[int]:
    """Whole numbers separated by commas."""
    return [int(word) for word in text.split(",") if word]


def show(title: str, figures: Figures) -> None:
    """Print figures on a line."""
    print(f"{title:28s}" + ", ".join(f"{name} {value:.5g}" for name, value in figures.items()), flush=True)


def attempt(what: str, function: Callable[..., Any], *arguments: Any) -> Any:
    """The function's result, or {} and a message, so that one failure does not cost the other figures."""
    try:
        return function(*arguments)
    except Exception as error:
        print(f"{what}: {type(error).__name__}: {error}", file=sys.stderr, flush=True)
        return {}


def scene_of(kind: str, torques: str, muscles: str, seconds: float) -> Scene:
    """The scene that torques drive, or the one that muscles with rigid or compliant tendons do, of a duration."""
    scene = load(torques if kind == "torques" else muscles, ignored=[])
    if kind != "torques":
        model = msgspec.structs.replace(scene.muscle_model, tendon=kind, legacy=False, ideal=False)
        scene = msgspec.structs.replace(scene, muscle_model=model)
    return msgspec.structs.replace(scene, duration=seconds)


@dataclass
class Bench:
    """What is measured, and how."""

    scenes: dict[str, Scene]
    device: Any
    noise: float
    repeats: int
    figures: Figures = field(default_factory=dict)

    def rollout(self, kind: str, lanes: int, instances: int, **options: Any) -> Rollout:
        """A batch of a kind."""
        return Rollout(self.scenes[kind], instances, str(self.device), lanes=lanes, threads=1, **options)

    def timed(self, rollout: Rollout) -> tuple[float, int]:
        """Time of the fastest of several runs, s, and the steps that a run makes."""
        return fastest_run(rollout, self.repeats, self.noise), int(rollout.state.step.numpy().sum())

    def total(self, kind: str, lanes: int, instances: int) -> Figures:
        """Rate of a batch, and time of a step of all of it; small ones run longer, so that their start counts less."""
        scene, longer = self.scenes[kind], min(max(MANY / instances, 1.0), 10.0)
        scene = msgspec.structs.replace(scene, duration=scene.duration * (1.0 if self.device.is_cpu else longer))
        rollout = Rollout(scene, instances, str(self.device), lanes=lanes, threads=1)
        seconds, steps = self.timed(rollout)
        return {"million_steps_per_second": steps / seconds / 1e6, "step_microseconds": 1e6 * seconds / rollout.steps}

    def stages(self, kind: str, lanes: int, instances: int, seconds: float) -> Figures:
        """Microseconds of the stages of a step of the whole batch."""
        rollout = self.rollout(kind, lanes, instances)
        split: Figures = StageTimes(rollout, self.noise).split(round(seconds / rollout.scene.time_step), self.repeats)
        plain = self.timed(rollout)[0] / rollout.steps
        recording = self.rollout(kind, lanes, instances, record=range(min(instances, RECORDED)))
        split["recording"] = 1e6 * (self.timed(recording)[0] / rollout.steps - plain)
        return split | {"production kernel": 1e6 * plain}

    def resources(self, kind: str, lanes: int, timed: bool) -> Figures:
        """What a kernel takes of the GPU."""
        rollout = self.rollout(kind, lanes, 1)
        kernel = StageTimes(rollout, 0.0).kernel if timed else rollout._launcher.kernel().kernel
        wp.load_module(kernel.module, self.device, block_dim=rollout.block_dim)
        return resources(kernel, self.device, rollout.block_dim, lanes)

    def compile(self, case: str) -> None:
        """Compile the kernels of a case, such as rigid-8 or rigid-8-timed, into Warp's cache by using them."""
        if case == PEER:
            peer_rate(self.peer_scene, 1, str(self.device), 2)
            return
        kind, lanes, *timed = case.split("-")
        rollout = self.rollout(kind, int(lanes), 1)
        if timed:
            StageTimes(rollout, 0.0).split(1, 1)
        else:
            rollout.run(rollout.scene.time_step)
        wp.synchronize()

    @property
    def peer_scene(self) -> Scene:
        """The first scene with muscles, if any."""
        return max(self.scenes.values(), key=lambda scene: len(scene.character.muscles) > 0)

    def peer(self, instances: int, case: str) -> Figures:
        """Rate of MuJoCo Warp, and ours of a case in it, if it has been measured."""
        steps = round(self.peer_scene.duration / self.peer_scene.time_step)
        rate = peer_rate(self.peer_scene, instances, str(self.device), steps) / 1e6
        ours = self.figures.get("totals", {}).get(case, {}).get("million_steps_per_second")
        return {"million_steps_per_second": rate} | ({"ratio": ours / rate} if ours else {})

    def put(self, part: str, title: str, function: Callable[..., Any], *arguments: Any) -> None:
        """Measure figures, print them and keep them under part and title."""
        found = attempt(f"{part}, {title}", function, *arguments)
        self.figures.setdefault(part, {})[title] = found
        if found:
            show(title, found)


def compile_all(cases: list[str], arguments: list[str]) -> dict[str, Any]:
    """Processes that compile one case each, as futures by case; they share Warp's cache with this one."""
    pool = ThreadPoolExecutor(os.cpu_count())
    command = [sys.executable, str(Path(__file__)), *arguments, "--only-compile"]
    futures = {case: pool.submit(subprocess.run, [*command, case], stdout=subprocess.DEVNULL) for case in cases}
    pool.shutdown(wait=False)
    return futures


def cases_of(kinds: list[str], lanes: list[int], few: int, stages: bool) -> dict[tuple[str, int, bool], str]:
    """Names of kernels by kind, lanes and whether they are timed by stage, which those of few lanes are."""
    rows = [(kind, n, False) for kind in kinds for n in lanes]
    rows += [(kind, few, True) for kind in kinds if stages]
    return {row: f"{row[0]}-{row[1]}" + "-timed" * row[2] for row in rows}


def main(
    torques: Annotated[str, typer.Option(help="Scene that torques drive.")] = "fwalk",
    muscles: Annotated[str, typer.Option(help="Scene that muscles drive.")] = "walk56",
    device: Annotated[str, typer.Option(help="cuda:0, ...; cpu for a trial.")] = "cuda:0",
    kinds: Annotated[str, typer.Option(help="Of torques, rigid and compliant.")] = ",".join(KINDS),
    instances: Annotated[str, typer.Option(help="Batch sizes of the totals.")] = "1024,4096,5120,16384,65536",
    lanes: Annotated[str, typer.Option(help="Lanes of the totals.")] = "4,8,16,32",
    stage_instances: Annotated[str, typer.Option(help="Batch sizes of the stages.")] = "5120,65536",
    stage_lanes: Annotated[int, typer.Option(help="Lanes of the stages.")] = 8,
    seconds: Annotated[
        float, typer.Option(help="Motion of a run for the totals, up to ten times as long for fewer.")
    ] = 0.1,
    stage_seconds: Annotated[float, typer.Option(help="Motion of a run for the stages.")] = 0.05,
    repeats: Annotated[int, typer.Option(help="Runs, of which the fastest counts.")] = 2,
    noise: Annotated[float, typer.Option(help="Of the starting velocities, m/s.")] = 0.1,
    peer: Annotated[bool, typer.Option(help="Also time MuJoCo Warp, if installed.")] = True,
    json_path: Annotated[Path, typer.Option("--json", help="File for the figures.")] = JSON,
    only_compile: Annotated[str, typer.Option(hidden=True)] = "",
) -> None:
    """Measure, print, and write the figures as JSON."""
    wp.config.log_level = wp.LOG_WARNING
    started, found, wanted = time.perf_counter(), find_device(device), kinds.split(",")
    scenes = {kind: scene_of(kind, torques, muscles, seconds) for kind in wanted}
    bench = Bench(scenes, found, noise, repeats)
    if only_compile:
        return bench.compile(only_compile)
    counts, stage_counts = numbers(instances), numbers(stage_instances)
    many, few = ([1], 1) if found.is_cpu else (numbers(lanes), stage_lanes)
    of_totals = sorted({*many, few}) if stage_counts else many
    cases = cases_of(wanted, of_totals if counts else [], few, bool(stage_counts))
    with_peer = peer and find_spec("mujoco_warp") is not None and not found.is_cpu
    options = [
        "--torques",
        torques,
        "--muscles",
        muscles,
        "--device",
        device,
        "--kinds",
        kinds,
        "--seconds",
        str(seconds),
    ]
    compiling = {} if found.is_cpu else compile_all([PEER] * with_peer + list(cases.values()), options)
    for case in set(compiling) - {PEER}:
        compiling[case].result()
    bench.figures |= {"device": found.name, "noise": noise, "compiled_seconds": time.perf_counter() - started}

    def save() -> None:
        bench.figures["seconds"] = time.perf_counter() - started
        json_path.write_text(json.dumps(bench.figures, indent=1) + "\n")

    for row, case in cases.items() if not found.is_cpu else ():
        bench.put("kernels", case, bench.resources, *row)
    save()
    for kind in wanted:
        for n in stage_counts:
            bench.put("stage_microseconds", f"{kind}-{few} x {n}", bench.stages, kind, few, n, stage_seconds)
            save()
    for kind, n_lanes, timed in cases:
        for n in counts if not timed else ():
            bench.put("totals", f"{kind}-{n_lanes} x {n}", bench.total, kind, n_lanes, n)
        save()
    if with_peer:
        compiling[PEER].result()
        first = next((kind for kind in wanted if kind != "torques"), wanted[0])
        for n in counts:
            bench.put("mujoco_warp", str(n), bench.peer, n, f"{first}-{few} x {n}")
            save()
    print(f"{bench.figures['seconds']:.0f} s in all, {bench.figures['compiled_seconds']:.0f} s of it compilation")


if __name__ == "__main__":
    run_script(main)
