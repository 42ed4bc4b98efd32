"""Instance-steps per second of the fused step, in all and by stage, against MuJoCo (C) on the same character.

    python tools/bench_step.py                                   one CPU core, as a ratio to MuJoCo in the same run
    python tools/bench_step.py --device cuda:0 --instances 1024,5120,65536
    python tools/bench_step.py --json bench.json

Both sides simulate the walk from the scene's initial state over the same time again and again. MuJoCo steps the
exported character with its feet on the ground but without a controller; we step it with ours.
"""

from __future__ import annotations

import json
import platform
import time
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
import warp as wp

from warpmuscle.formats import load, mjcf
from warpmuscle.kernels.dynamics import acceleration_stage, inertia_stage
from warpmuscle.kernels.integration import integrate_stage
from warpmuscle.kernels.kinematics import kinematics_stage
from warpmuscle.kernels.lanes import capacity_of, slots_of, work_address, work_at
from warpmuscle.kernels.objective import effort_stage
from warpmuscle.kernels.simbicon import advance_phase, targets_stage, torques_stage
from warpmuscle.kernels.step import foot_force_stage, module_options
from warpmuscle.kernels.structs import Model, State
from warpmuscle.rollout import Rollout
from warpmuscle.scene import Scene

STAGES = ("kinematics", "targets", "torques", "inertia", "inertia and acceleration")
REPEATED = 4  # extra runs of a stage, so that its time stands out from the noise


def best_rate(work: Any, steps: int, repeats: int) -> float:
    """Steps per second of the fastest of several runs of a function that makes `steps` of them."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return steps / min(times)


def prepared(scene: Scene, instances: int, device: str, seconds: float) -> tuple[Rollout, Any]:
    """A rollout on one CPU thread or a GPU, and a function that runs it over `seconds` from the start."""
    rollout = Rollout(scene, instances, device, threads=1)

    def work() -> None:
        rollout.reset()
        rollout.run(seconds)
        wp.synchronize()

    work()
    return rollout, work


def mujoco_runner(scene: Scene, seconds: float) -> tuple[int, Any]:
    """Number of steps, and a function that makes them in MuJoCo from the initial state."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(mjcf.dumps(scene))
    data = mujoco.MjData(model)
    count = round(seconds / scene.time_step)

    def work() -> None:
        mujoco.mj_resetDataKeyframe(model, data, 0)
        mujoco.mj_step(model, data, nstep=count)

    work()
    return count, work


def stage_kernel(capacity: int, lanes: int, block_dim: int) -> Any:
    """A step like the fused one whose stages that may be repeated run 1 + repeat[stage] times."""
    per_block, slots = max(block_dim // lanes, 1), slots_of(capacity)
    address = work_address(capacity, per_block)

    @wp.kernel(module="unique", enable_backward=False, module_options=module_options(block_dim))
    def repeated(steps: int, model: Model, state: State, buffer: wp.uint64, repeat: wp.array[int]):
        i, lane = wp.tid()
        work = work_at(address(i % per_block, buffer), capacity, slots)
        for _ in range(steps):
            for _k in range(1 + repeat[0]):
                kinematics_stage(i, lane, lanes, model, state, work)
            for _k in range(1 + repeat[1]):
                targets_stage(i, lane, lanes, model, state, work)
            for _k in range(1 + repeat[2]):
                torques_stage(i, lane, lanes, model, state, work)
            effort_stage(i, lane, lanes, model, state, work)
            for _k in range(1 + repeat[3] + repeat[4]):
                inertia_stage(i, lane, lanes, model, state, work)
                if _k >= repeat[3]:
                    acceleration_stage(i, lane, lanes, model, work)
            integrate_stage(i, lane, lanes, model, state, work)
            if lane == 0:
                foot_force_stage(i, model, state, work)
                advance_phase(i, model, state)
                state.step[i] = state.step[i] + 1

    return repeated


def stage_times(rollout: Rollout, seconds: float, repeats: int) -> dict[str, float]:
    """Time of each stage by a step of one instance, microseconds (on a GPU: by a step of the whole batch)."""
    scene, device = rollout.scene, rollout.device
    capacity, count = capacity_of(len(rollout.names.bodies)), round(seconds / rollout.scene.time_step)
    kernel = stage_kernel(capacity, rollout.lanes, rollout.block_dim)
    buffer = wp.zeros(100_000, dtype=float, device=device)
    instance_steps = count * (rollout.instances if device.is_cpu else 1)

    def timed(repeat: list[int]) -> float:
        extra = wp.array(repeat, dtype=int, device=device)

        def work() -> None:
            rollout.reset()
            inputs = [count, rollout.model, rollout.state, wp.uint64(buffer.ptr), extra]
            dim = (rollout.instances, rollout.lanes)
            wp.launch(kernel, dim=dim, inputs=inputs, device=device, block_dim=rollout.block_dim)
            wp.synchronize()

        work()
        return 1e6 / best_rate(work, instance_steps, repeats)

    assert scene.controller is not None
    base = timed([0] * len(STAGES))
    times = {"all": base}
    for i, name in enumerate(STAGES):
        times[name] = (timed([REPEATED * int(k == i) for k in range(len(STAGES))]) - base) / REPEATED
    times["rest"] = base - sum(times[name] for name in STAGES if name != "inertia")
    return times


def main(
    scene: Annotated[str, typer.Option(help="Shipped scene or TOML file.")] = "fwalk",
    device: Annotated[str, typer.Option(help="cpu for one core, or cuda:0.")] = "cpu",
    instances: Annotated[str, typer.Option(help="Batch sizes, separated by commas.")] = "",
    seconds: Annotated[float, typer.Option(help="Simulated time of a run.")] = 0.5,
    repeats: Annotated[int, typer.Option(help="Runs, of which the fastest counts.")] = 7,
    stages: Annotated[bool, typer.Option(help="Also time the stages.")] = True,
    json_path: Annotated[Path | None, typer.Option("--json", help="File for the figures.")] = None,
) -> None:
    """Time the fused step."""
    wp.config.log_level = wp.LOG_WARNING
    loaded = load(scene)
    on_cpu = device == "cpu"
    sizes = [int(n) for n in (instances or ("64" if on_cpu else "1024,4096,5120,16384,65536")).split(",")]
    count = round(seconds / loaded.time_step)
    figures: dict[str, Any] = {"scene": loaded.name, "device": device, "machine": platform.processor(), "sizes": {}}
    for n in sizes:
        rollout, ours = prepared(loaded, n, device, seconds)
        entry: dict[str, Any] = {}
        if on_cpu:
            peer_count, peer = mujoco_runner(loaded, seconds)
            pairs = [(best_rate(ours, n * count, 1), best_rate(peer, peer_count, 1)) for _ in range(repeats)]
            entry["steps_per_second"], entry["mujoco_steps_per_second"] = np.max(pairs, axis=0).tolist()
            entry["ratio"] = float(np.median([a / b for a, b in pairs]))
        else:
            entry["steps_per_second"] = best_rate(ours, n * count, repeats)
        if stages:
            entry["stage_microseconds"] = stage_times(rollout, seconds, repeats)
        figures["sizes"][n] = entry
        print(f"{n:7d} instances: {entry['steps_per_second'] / 1e6:9.3f} million steps/s", end="")
        print(f", {entry['ratio']:.1f} times MuJoCo" if on_cpu else "", flush=True)
        for name, value in entry.get("stage_microseconds", {}).items():
            print(f"          {name:26s}{value:9.3f} us")
    if json_path is not None:
        json_path.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    typer.run(main)
