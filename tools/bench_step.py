"""Instance-steps per second of the fused step, in all and by stage, against MuJoCo (C) on the same character.

    python tools/bench_step.py                                   one CPU core, as a ratio to MuJoCo in the same run
    python tools/bench_step.py --muscles                         the same for a character that muscles drive
    python tools/bench_step.py --device cuda:0 --instances 1024,5120,65536
    python tools/bench_step.py --json bench.json

Both sides simulate the walk from the scene's initial state over the same time again and again. MuJoCo steps the
exported character with its feet on the ground but without a controller, its muscles at a constant excitation; we step
it with ours. The ratio is to its implicitfast integrator, which the export asks for, and to its cheaper Euler one.
Steps of instances that have failed do not count. For muscles, the cost of compliant tendons is measured against that
of rigid ones, all else equal.
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

from warpmuscle.formats import load, mjcf
from warpmuscle.kernels import structs
from warpmuscle.kernels.dynamics import acceleration_stage, inertia_stage
from warpmuscle.kernels.integration import integrate_stage
from warpmuscle.kernels.kinematics import kinematics_stage
from warpmuscle.kernels.lanes import capacity_of, slots_of, synchronize, work_at, work_memory
from warpmuscle.kernels.muscle_stage import MuscleKind, muscle_stage_of, no_muscles
from warpmuscle.kernels.objective import effort_stage
from warpmuscle.kernels.simbicon import advance_phase, targets_stage, torques_stage
from warpmuscle.kernels.spatial import symmetric
from warpmuscle.kernels.step import MAX_REGISTERS, foot_force_stage, module_options
from warpmuscle.kernels.structs import Model, Record, State, Work
from warpmuscle.muscles import driven, muscle_kind
from warpmuscle.rollout import Rollout
from warpmuscle.scene import Scene

STAGES = ("kinematics", "targets", "torques", "inertia", "inertia and acceleration", "muscles")
REPEATED = 4  # extra runs of a stage, so that its time stands out from the noise
EXCITATION = 0.05  # of MuJoCo's muscles
Run = Callable[[], int]  # makes steps and returns how many


def best_rate(run: Run, repeats: int) -> float:
    """Steps per second of the fastest of several runs of a function that returns how many it made."""
    rates = []
    for _ in range(repeats):
        begin = time.perf_counter()
        steps = run()
        rates.append(steps / (time.perf_counter() - begin))
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

    model = mujoco.MjModel.from_xml_string(mjcf.dumps(scene))
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


def rates_and_ratio(ours: Run, other: Run, repeats: int) -> tuple[float, float, float]:
    """Steps per second of both, and the median of their ratio over runs in turn."""
    pairs = [(best_rate(ours, 1), best_rate(other, 1)) for _ in range(repeats)]
    a, b = np.max(pairs, axis=0).tolist()
    return a, b, float(np.median([a / b for a, b in pairs]))


@wp.struct
class Kept:
    """What a muscle stage replaces."""

    torque: wp.array2d[wp.vec3]
    stiffness: wp.array2d[symmetric]


@wp.func
def keep(instance: int, lane: int, lanes: int, model: Model, work: Work, kept: Kept):
    """Put it by."""
    for i in range(lane, model.body_count, lanes):
        kept.torque[instance, i] = work.torque[i]
        kept.stiffness[instance, i] = work.stiffness[i]
    synchronize()


@wp.func
def restore_torque(instance: int, lane: int, lanes: int, model: Model, work: Work, kept: Kept):
    """Take back what the next repetition reads."""
    for i in range(lane, model.body_count, lanes):
        work.torque[i] = kept.torque[instance, i]
    synchronize()


@wp.func
def restore_stiffness(instance: int, lane: int, lanes: int, model: Model, work: Work, kept: Kept):
    """Take back the rest."""
    for i in range(lane, model.body_count, lanes):
        work.stiffness[i] = kept.stiffness[instance, i]
    synchronize()


def stage_kernel(capacity: int, lanes: int, block_dim: int, muscles: MuscleKind | None) -> Any:
    """A step like the fused one whose stages that may be repeated run 1 + repeat[stage] times.

    Repetitions of the muscle stage work on a muscle state of their own, so that they do not change the motion.
    """
    per_block, slots = max(block_dim // lanes, 1), slots_of(capacity)
    memory = work_memory(capacity, per_block)
    muscle_stage = muscle_stage_of(muscles) if muscles is not None else no_muscles

    @wp.kernel(
        module="unique",
        enable_backward=False,
        cuda_max_registers=MAX_REGISTERS,
        module_options=module_options(block_dim),
    )
    def repeated(
        steps: int, model: Model, state: State, spare: State, record: Record, buffer: wp.uint64,
        repeat: wp.array[int], kept: Kept,
    ):  # fmt: skip
        i, lane = wp.tid()
        work = work_at(memory(i % per_block, buffer), capacity, slots)
        for _ in range(steps):
            for _k in range(1 + repeat[0]):
                kinematics_stage(i, lane, lanes, model, state, work)
            for _k in range(1 + repeat[1]):
                targets_stage(i, lane, lanes, model, state, work)
            for _k in range(1 + repeat[2]):
                torques_stage(i, lane, lanes, model, state, work)
            effort_stage(i, lane, lanes, model, state, work)
            if repeat[5] > 0:
                synchronize()
                keep(i, lane, lanes, model, work, kept)
                for _k in range(repeat[5]):
                    muscle_stage(i, lane, lanes, -1, model, spare, record, work)
                    restore_torque(i, lane, lanes, model, work, kept)
                restore_stiffness(i, lane, lanes, model, work, kept)
            muscle_stage(i, lane, lanes, -1, model, state, record, work)
            synchronize()
            for _k in range(1 + repeat[3] + repeat[4]):
                inertia_stage(i, lane, lanes, model, state, work)
                if _k >= repeat[3]:
                    acceleration_stage(i, lane, lanes, model, work)
            integrate_stage(i, lane, lanes, model, state, work)
            if lane == 0:
                foot_force_stage(i, model, state, work)
                advance_phase(i, model, state)
                state.step[i] = state.step[i] + 1
            synchronize()

    return repeated


def spare_state(state: State) -> State:
    """The same state with muscles of its own."""
    spare, spare.muscles = structs.State(), structs.MuscleState()
    for name in structs.State.vars:
        if name != "muscles":
            setattr(spare, name, getattr(state, name))
    for name in structs.MuscleState.vars:
        setattr(spare.muscles, name, wp.clone(getattr(state.muscles, name)))
    return spare


def stage_times(rollout: Rollout, seconds: float, repeats: int) -> dict[str, float]:
    """Time of each stage by a step of one instance, microseconds (on a GPU: by a step of the whole batch)."""
    scene, device, bodies = rollout.scene, rollout.device, len(rollout.names.bodies)
    assert scene.controller is not None
    found = driven(scene, rollout.names)
    kind = None if found.by_torque_alone else muscle_kind(scene.muscle_model)
    count, dim = round(seconds / scene.time_step), (rollout.instances, rollout.lanes)
    kernel = stage_kernel(capacity_of(bodies), rollout.lanes, rollout.block_dim, kind)
    buffer = wp.zeros(100_000, dtype=float, device=device)
    kept, spare = Kept(), spare_state(rollout.state)
    kept.torque = wp.zeros((rollout.instances, bodies), dtype=wp.vec3, device=device)
    kept.stiffness = wp.zeros((rollout.instances, bodies), dtype=symmetric, device=device)

    def runner(repeat: list[int]) -> Run:
        extra = wp.array(repeat, dtype=int, device=device)
        inputs = [count, rollout.model, rollout.state, spare, Record(), wp.uint64(buffer.ptr), extra, kept]

        def run() -> int:
            rollout.reset()
            wp.launch(kernel, dim=dim, inputs=inputs, device=device, block_dim=rollout.block_dim)
            wp.synchronize()
            return count * (rollout.instances if device.is_cpu else 1)

        run()
        return run

    names = [name for name in STAGES if name != "muscles" or kind is not None]
    runs = [runner([REPEATED * int(name == timed) for name in STAGES]) for timed in ["", *names]]
    rates = [[best_rate(run, 1) for run in runs] for _ in range(repeats)]  # in turn, so that all share quiet moments
    base, *extended = (1e6 / np.max(rates, axis=0)).tolist()
    times = {"all": base} | {name: (time - base) / REPEATED for name, time in zip(names, extended, strict=True)}
    times["rest"] = base - sum(time for name, time in times.items() if name not in ("all", "inertia"))
    return times


def tendons_ratio(scene: Scene, instances: int, device: str, seconds: float, repeats: int) -> float:
    """Time of a step with compliant tendons over that with rigid ones."""
    runs = []
    for tendon in ("rigid", "compliant"):
        model = msgspec.structs.replace(scene.muscle_model, tendon=tendon, legacy=False, ideal=False)
        runs.append(prepared(msgspec.structs.replace(scene, muscle_model=model), instances, device, seconds)[1])
    return rates_and_ratio(runs[0], runs[1], repeats)[2]


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
    typer.run(main)
