"""Free runs of MuJoCo models beside MuJoCo's own steps, with drawn excitations: a table for the manual.

    python tools/mujoco_free_runs.py FOLDER/myoelbow_2dof6muscles.xml --seconds 0.5 -o table.md

All muscles are excited along straight lines between drawn knots, from the same start, without contact, limits and dry
friction. MuJoCo integrates with its own step and with a shorter one, and what these differ by is what a comparison can
tell. Where equalities couple joints, MuJoCo lets them give way a little.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Annotated

import msgspec
import mujoco
import numpy as np
import typer
import warp as wp
from free_runs import FRAMES, START, Floats, differences, drawn, excited, show_table
from mujoco_poses import NotCompared, Oracle

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Scene
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.rollout import Rollout

SHORT = 1.0e-4  # s, MuJoCo's shorter step
COLUMNS = ("model", "muscles", "coordinates", "farthest apart", "at 0.1 s", "MuJoCo's own step and 0.1 ms")


def theirs(
    oracle: Oracle, start: Floats, times: Floats, values: dict[str, Floats], step: float, moments: Floats
) -> Floats:
    """MuJoCo's free coordinates (n, F) at some times, from where they start."""
    model = oracle.model
    model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_EQUALITY)
    model.opt.timestep = step
    data = mujoco.MjData(model)
    places = [int(model.jnt_qposadr[joint]) for joint in oracle.free]
    data.qpos[places] = start
    for joint, value in oracle.held.items():
        data.qpos[model.jnt_qposadr[joint]] = value
    for joint, (driver, coefficients) in oracle.follows.items():
        q = start[oracle.free.index(driver)]
        data.qpos[model.jnt_qposadr[joint]] = np.polynomial.Polynomial(coefficients)(q)
    acts = [int(model.actuator_actadr[k]) for k in oracle.muscles]
    data.act[acts] = START
    found, count = np.zeros((len(moments), len(places))), 0
    for number, moment in enumerate(moments):
        while count < round(moment / step):
            data.ctrl[oracle.muscles] = [np.interp(count * step, times, line) for line in values.values()]
            mujoco.mj_step(model, data)
            count += 1
        found[number] = data.qpos[places]
    return found


def ours(scene: Scene, seconds: float, names: list[str]) -> tuple[Floats, Floats]:
    """Times (n,) and free coordinates (n, F) of the scene, by names of joints."""
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=FRAMES / seconds)
    rollout.run()
    tree = topology(scene.character)
    places = [tree.coordinates_of(tree.body_of_joint(name)).start for name in names]
    recording = rollout.recording()
    return np.asarray(recording.time, dtype=float), rollout.recorded("coordinates")[0].astype(float)[:, places]


def prepared(scene: Scene, times: Floats, values: dict[str, Floats], seconds: float, step: float) -> Scene:
    """The scene with these excitations, without ground and limits."""
    joints = {
        name: msgspec.structs.replace(joint, limit_stiffness=0.0, limit_damping=0.0)
        for name, joint in scene.character.joints.items()
    }
    bare = msgspec.structs.replace(
        scene,
        character=msgspec.structs.replace(scene.character, joints=joints),
        ground=msgspec.structs.replace(scene.ground, stiffness=0.0),
    )
    return excited(bare, times, values, seconds, step)


def row(path: Path, seconds: float, step: float, seed: int) -> str:
    """A row of the table."""
    try:
        scene, oracle = wm.load(path), Oracle(path)
    except (SceneError, NotCompared) as error:
        return f"| {path.stem} | | | {error} | | |"
    if oracle.roots:
        return f"| {path.stem} | | | loads; a body that falls freely is not compared | | |"
    own = float(oracle.model.opt.timestep)
    oracle.keep(set(scene.character.muscles))
    names = [oracle.reference.name("joint", joint) for joint in oracle.free]
    muscles = [oracle.model.actuator(k).name or f"actuator{k}" for k in oracle.muscles]
    times, values = drawn(muscles, seconds, seed)
    moments, here = ours(prepared(scene, times, values, seconds, step), seconds, names)
    coarse, fine = (theirs(oracle, here[0], times, values, length, moments) for length in (own, SHORT))
    cells = differences(np.abs(here - fine), fine, names, moments)
    cells += [f"{np.abs(coarse - fine).max():.1g} ({1000 * own:g} ms)"]
    return f"| {path.stem} | {len(muscles)} | {len(names)} | {' | '.join(cells)} |"


def main(
    models: Annotated[list[Path], typer.Argument(help="Files of the models.")],
    seconds: Annotated[float, typer.Option(help="Of motion.")] = 0.5,
    step: Annotated[float, typer.Option(help="Ours, s.")] = 2.0e-4,
    seed: Annotated[int, typer.Option(help="Of the excitations.")] = 1,
    output: Annotated[Path | None, typer.Option("-o", help="File for the table.")] = None,
) -> None:
    """Compare."""
    wp.config.log_level = wp.LOG_WARNING
    warnings.simplefilter("ignore")
    show_table(COLUMNS, (row(path, seconds, step, seed) for path in models), output)


if __name__ == "__main__":
    run_script(main)
