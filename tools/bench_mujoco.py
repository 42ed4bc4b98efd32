"""Steps a second of models of MuJoCo here and in MuJoCo's C, in one run, with muscles excited and without contact.

    python tools/bench_mujoco.py FOLDER/myohand.xml FOLDER/myolegs.xml --instances 5120 --device cuda:0
    python tools/bench_mujoco.py FOLDER/myohand.xml FOLDER/myolegs.xml --instances 5120 --device cuda:0 --warp

MuJoCo takes one step after the other on one core, a batch here as many at once as it has instances. Each is measured
several times, of which the best counts. With `--warp`, MuJoCo Warp steps as many instances on the same device, too
(`pip install mujoco-warp`).
"""

from __future__ import annotations

import os
import time
import warnings
from pathlib import Path
from typing import Annotated

import msgspec
import mujoco
import numpy as np
import typer
from bench_models import prepared
from fastest_run import fastest_run
from mujoco_warp_peer import MARGIN, rate

import warpmuscle as wm

EXCITATION = 0.5
WARM = 5  # steps before the clock starts


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
    """Steps a second of MuJoCo on one core."""
    model, data = excited(path)
    mujoco.mj_step(model, data, WARM)
    start, steps = time.perf_counter(), 0
    while time.perf_counter() - start < seconds:
        mujoco.mj_step(model, data, 10)
        steps += 10
    return steps / (time.perf_counter() - start)


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
    warp: Annotated[bool, typer.Option("--warp", help="Measure MuJoCo Warp, too.")] = False,
) -> None:
    """Compare the rates of models."""
    warnings.simplefilter("ignore")
    print(f"{os.cpu_count()} cores, {device}, MuJoCo {mujoco.__version__}; steps a second")
    print(f"| model | muscles | MuJoCo, one core | {instances} instances | times |\n|---|---|---|---|---|")
    for path in models:
        theirs = np.max([mujoco_rate(path, 1.0) for _ in range(runs)])
        ours = our_rate(path, instances, seconds, device, runs)
        muscles = len(wm.load(path, ignored=[]).character.muscles)
        print(f"| {path.stem} | {muscles} | {theirs:.3g} | {ours:.3g} | {ours / theirs:.2g} |", flush=True)
        if warp:
            peer = max(warp_rate(path, instances, seconds, device) for _ in range(runs))
            print(f"  MuJoCo Warp, {instances} instances: {peer:.3g}, times {ours / peer:.2g}", flush=True)


if __name__ == "__main__":
    typer.run(main)
