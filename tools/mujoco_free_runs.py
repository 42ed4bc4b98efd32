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
from mujoco_poses import Floats, NotCompared, Oracle

import warpmuscle as wm
from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Excitation, Failure, Scene
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.rollout import Rollout

START, MOST = 0.05, 0.5  # excitation at first, and the most that is drawn
KNOTS, FRAMES = 3, 50
SHORT = 1.0e-4  # s, MuJoCo's shorter step
COLUMNS = ("model", "muscles", "coordinates", "farthest apart", "at 0.1 s", "MuJoCo's own step and 0.1 ms")


def drawn(count: int, seconds: float, seed: int) -> tuple[Floats, Floats]:
    """Times (KNOTS,) and excitations (count, KNOTS) at them."""
    values = np.random.default_rng(seed).uniform(0.0, MOST, (count, KNOTS))
    values[:, 0] = START
    return np.linspace(0.0, seconds, KNOTS), values


def theirs(oracle: Oracle, start: Floats, times: Floats, values: Floats, step: float, moments: Floats) -> Floats:
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
            data.ctrl[oracle.muscles] = [np.interp(count * step, times, line) for line in values]
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
    """The scene with these excitations, without ground and limits; nothing ends it early."""
    character = scene.character
    joints = {
        name: msgspec.structs.replace(joint, limit_stiffness=0.0, limit_damping=0.0)
        for name, joint in character.joints.items()
    }
    muscles = {
        name: msgspec.structs.replace(muscle, excitation=Excitation(times.tolist(), values[name].tolist()))
        if name in values else muscle
        for name, muscle in character.muscles.items()
    }  # fmt: skip
    return msgspec.structs.replace(
        scene, character=msgspec.structs.replace(character, joints=joints, muscles=muscles),
        muscle_model=msgspec.structs.replace(scene.muscle_model, initial_activation=START),
        ground=msgspec.structs.replace(scene.ground, stiffness=0.0),
        failure=Failure(com_height=0.0, heading=0.0), duration=seconds, time_step=step,
    )  # fmt: skip


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
    times, values = drawn(len(muscles), seconds, seed)
    ready = prepared(scene, times, dict(zip(muscles, values, strict=True)), seconds, step)
    moments, here = ours(ready, seconds, names)
    coarse, fine = (theirs(oracle, here[0], times, values, length, moments) for length in (own, SHORT))
    off = np.abs(here - fine)
    at, column = divmod(int(off.argmax()), len(names))
    moved = np.abs(fine - fine[0]).max()
    cells = [f"{off.max():.2g} of {moved:.2g}, {names[column]} at {moments[at]:.2f} s"]
    cells += [f"{off[moments <= 0.1 + 1e-9].max():.1g}", f"{np.abs(coarse - fine).max():.1g} ({1000 * own:g} ms)"]
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
    lines = [f"| {' | '.join(COLUMNS)} |", "|---" * len(COLUMNS) + "|"]
    for path in models:
        lines.append(row(path, seconds, step, seed))
        print(lines[-1], flush=True)
        if output is not None:
            output.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    typer.run(main)
