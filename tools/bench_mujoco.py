"""Steps a second of models of MuJoCo here and in MuJoCo's C, in one run, with muscles excited and without contact.

    python tools/bench_mujoco.py FOLDER/myohand.xml FOLDER/myolegs.xml --instances 5120 --device cuda:0
    python tools/bench_mujoco.py FOLDER/myohand.xml --instances 4096 --device cuda:0 --threads 16 --warp

MuJoCo takes one step after the other on one core, a batch here as many at once as it has instances. Each is measured
several times, of which the best counts. With `--threads`, MuJoCo also steps several instances at once on so many
threads (`mujoco.rollout`). With `--warp`, MuJoCo Warp steps as many instances on the same device, too
(`pip install mujoco-warp`). All take the model's own time step.
"""

from __future__ import annotations

import os
import time
import warnings
from pathlib import Path
from typing import Annotated

import msgspec
import mujoco
import mujoco.rollout
import numpy as np
import typer
from bench_models import prepared
from fastest_run import fastest_run
from mujoco_warp_peer import MARGIN, rate

import warpmuscle as wm
from warpmuscle.cli.ending import run_script

EXCITATION = 0.5
WARM = 5  # steps before the clock starts
LEAST = 1.0  # s, for which MuJoCo's steps are counted
RUNS_A_THREAD = 4  # of MuJoCo's, side by side


def excited(path: Path) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A model without contact at its first keyframe, its muscles excited."""
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    data.ctrl[:] = EXCITATION
    return model, data


def mujoco_rate(path: Path, seconds: float) -> float:
    """Steps a second of MuJoCo on one core, over the same motion again and again."""
    model, data = excited(path)
    start, steps = mujoco.MjData(model), max(round(seconds / model.opt.timestep), 1)
    mujoco.mj_copyData(start, model, data)
    mujoco.mj_step(model, data, WARM)
    took = made = 0.0
    while took < LEAST:
        mujoco.mj_copyData(data, model, start)
        begin = time.perf_counter()
        mujoco.mj_step(model, data, steps)
        took, made = took + time.perf_counter() - begin, made + steps
    return made / took


def threads_rate(path: Path, seconds: float, threads: int) -> float:
    """Steps a second of MuJoCo on several threads, each with instances of its own."""
    model, data = excited(path)
    steps, count = max(round(seconds / model.opt.timestep), 1), RUNS_A_THREAD * threads
    whole = int(mujoco.mjtState.mjSTATE_FULLPHYSICS)
    start = np.zeros(mujoco.mj_stateSize(model, whole))
    mujoco.mj_getState(model, data, start, whole)
    control = np.full((count, steps, model.nu), EXCITATION)
    with mujoco.rollout.Rollout(nthread=threads) as pool:
        places = [mujoco.MjData(model) for _ in range(threads)]
        pool.rollout(model, places, np.tile(start, (count, 1)), control[:, :WARM])
        begin = time.perf_counter()
        pool.rollout(model, places, np.tile(start, (count, 1)), control)
        return count * steps / (time.perf_counter() - begin)


def our_rate(path: Path, instances: int, seconds: float, device: str, runs: int) -> float:
    """Steps a second of a batch, all instances together, as `bench_models.py` measures it."""
    step = wm.load(path, ignored=[]).time_step
    scene = prepared(str(path), seconds, step, ball_joints=False)
    scene.ground = msgspec.structs.replace(scene.ground, stiffness=0.0)
    rollout = wm.Rollout(scene, instances, device)
    took = fastest_run(rollout, runs, 0.1)
    return float(rollout.end_time().sum()) / step / took


def warp_rate(path: Path, instances: int, seconds: float, device: str) -> float:
    """Steps a second of MuJoCo Warp, all instances together."""
    model, data = excited(path)
    steps = max(round(seconds / model.opt.timestep), 1)
    rows = 0
    for _ in range(steps):
        mujoco.mj_step(model, data)
        rows = max(rows, data.nefc)
    model, data = excited(path)
    return rate(model, data, instances, device, steps, 1, MARGIN * rows + 1)


def main(
    models: list[Path],
    instances: Annotated[int, typer.Option(min=1)] = 256,
    seconds: Annotated[float, typer.Option(min=0.001, help="motion of the batch")] = 0.2,
    device: str = "cpu",
    runs: Annotated[int, typer.Option(min=1, help="of which the best counts")] = 3,
    threads: Annotated[int, typer.Option(min=1, help="of MuJoCo's, besides one")] = 1,
    warp: Annotated[bool, typer.Option("--warp", help="Measure MuJoCo Warp, too.")] = False,
) -> None:
    """Compare the rates of models."""
    warnings.simplefilter("ignore")
    print(f"{os.cpu_count()} cores, {device}, MuJoCo {mujoco.__version__}; steps a second")
    print(f"| model | muscles | MuJoCo, one core | {instances} instances | times |\n|---|---|---|---|---|")
    for path in models:
        theirs = np.max([mujoco_rate(path, seconds) for _ in range(runs)])
        ours = our_rate(path, instances, seconds, device, runs)
        muscles = len(wm.load(path, ignored=[]).character.muscles)
        print(f"| {path.stem} | {muscles} | {theirs:.3g} | {ours:.3g} | {ours / theirs:.2g} |", flush=True)
        if threads > 1:
            several = max(threads_rate(path, seconds, threads) for _ in range(runs))
            print(f"  MuJoCo, {threads} threads: {several:.3g}, times {ours / several:.2g}", flush=True)
        if warp:
            peer = max(warp_rate(path, instances, seconds, device) for _ in range(runs))
            print(f"  MuJoCo Warp, {instances} instances: {peer:.3g}, times {ours / peer:.2g}", flush=True)


if __name__ == "__main__":
    run_script(main)
