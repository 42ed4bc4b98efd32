"""How long tendons of MuJoCo's models are once warpmuscle has read and written them: the largest differences.

    python tools/mujoco_written.py myosuite/simhive/myo_sim/*/myo*.xml --poses 20

Each model is loaded, written as MJCF and compiled by MuJoCo again. Both are posed at random within the ranges of their
joints, with the joints that equalities couple where these say, and the tendons of actuators are compared.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Annotated

import mujoco
import numpy as np
import typer

from warpmuscle.cli.ending import run_script
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, mjcf

UNLIMITED = (-0.5, 0.5)  # rad or m, of joints without a range


def pose(model: mujoco.MjModel, random: np.random.Generator) -> dict[str, float]:
    """Values of hinges and slides by name, those that are coupled as the equalities say."""
    names = [model.joint(number).name for number in range(model.njnt)]
    scalar = [number for number in range(model.njnt) if model.jnt_type[number] >= int(mujoco.mjtJoint.mjJNT_SLIDE)]
    limits = {k: model.jnt_range[k] if model.jnt_limited[k] else UNLIMITED for k in scalar}
    found = {names[k]: float(random.uniform(*limits[k])) for k in scalar}
    start = {names[k]: float(model.qpos0[model.jnt_qposadr[k]]) for k in scalar}
    for k in np.flatnonzero(model.eq_type == int(mujoco.mjtEq.mjEQ_JOINT)):
        own, other = names[model.eq_obj1id[k]], model.eq_obj2id[k]
        x = found[names[other]] - start[names[other]] if other >= 0 else 0.0
        found[own] = start[own] + float(np.polynomial.Polynomial(model.eq_data[k, :5])(x))
    return found


def put(model: mujoco.MjModel, data: mujoco.MjData, values: dict[str, float]) -> None:
    """Pose a model; a turn or shift of a coupled joint has the name of that joint before its own."""
    for number in range(model.njnt):
        name = model.joint(number).name
        known = next((one for one in (name, name.rpartition("_")[0]) if one in values), None)
        if known is not None:
            data.qpos[model.jnt_qposadr[number]] = values[known]
    mujoco.mj_forward(model, data)


def lengths(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, float]:
    """Lengths of the tendons of actuators, m, by name of the actuator."""
    on_tendon = np.flatnonzero(model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_TENDON))
    return {model.actuator(int(k)).name: float(data.ten_length[model.actuator_trnid[k, 0]]) for k in on_tendon}


def main(
    files: Annotated[list[Path], typer.Argument(help="Models of MuJoCo.")],
    poses: Annotated[int, typer.Option(min=1, help="Of each.")] = 20,
    seed: Annotated[int, typer.Option(help="Of the poses.")] = 1,
) -> None:
    """Print a line for each model."""
    print("| model | tendons | worst, m |\n|---|---|---|")
    for file in files:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                again = mujoco.MjModel.from_xml_string(mjcf.dumps(load(file, ignored=[])))
        except (SceneError, ValueError) as error:
            print(f"| {file.stem} | | {str(error).splitlines()[0]} |")
            continue
        first = mujoco.MjModel.from_xml_path(str(file))
        data, other, random = mujoco.MjData(first), mujoco.MjData(again), np.random.default_rng(seed)
        worst, count = 0.0, 0
        for _ in range(poses):
            values = pose(first, random)
            put(first, data, values)
            put(again, other, values)
            ours = lengths(again, other)
            both = [(length, ours[name]) for name, length in lengths(first, data).items() if name in ours]
            count = len(both)
            worst = max([worst, *(abs(one - two) for one, two in both)])
        print(f"| {file.stem} | {count} | {worst:.0e} |", flush=True)


if __name__ == "__main__":
    run_script(main)
