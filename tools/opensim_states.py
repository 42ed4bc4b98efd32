"""Our accelerations in states of OpenSim's free runs, to find why runs come apart: a table for the manual.

    python tools/opensim_states.py Rajagopal2016.osim MoBL_ARMS.osim --start deviation=0.1 --states 25

OpenSim moves a model as in `opensim_free_runs.py`. In some states of that run, with its activations and fibres, our
step accelerates the coordinates, too. What differs is told as it is; after OpenSim's accelerations are made the rates
of its velocities (`opensim_drift.py`); and after the moments are taken out that its paths round several surfaces have
about joints that they do not cross. Models with loops are left out: their coordinates depend on each other, and the
mass matrix does not say so. `pip install opensim` brings OpenSim 4.6.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
import warp as wp
from free_runs import Floats, drawn, excited, show_table
from opensim_drift import put_right
from opensim_free_runs import begun, started_each
from opensim_oracle import with_process
from opensim_ours import Ours
from opensim_posed import Posed, members

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.scene import Scene
from warpmuscle.scene.muscles import is_cable
from warpmuscle.simulation.rollout import Rollout

ACCURACY = 1.0e-6
STEP = 1.0e-4  # s, of ours
MOVE = 1.0e-6  # of differences
COLUMNS = ("model", "states", "accelerations up to", "apart: 90 %, worst", "with rates of velocities",
    "without moments about joints not crossed", "tension, of f_max", "length")  # fmt: skip


@dataclass
class States:
    """OpenSim's states (n,), K coordinates, I independent ones and M muscles."""

    names: list[str]
    independent: list[int]
    muscles: list[str]
    time: Floats
    q: Floats  # (n, K)
    speed: Floats  # (n, K)
    acceleration: Floats  # (n, I)
    put_right: Floats  # (n, I) to be added, so that accelerations are the rates of velocities
    mass: Floats  # (n, I, I)
    arm: Floats  # (n, M, I) m, of some muscles, otherwise 0
    activation: Floats  # (n, M)
    fibre: Floats  # (n, M) m
    fibre_speed: Floats  # (n, M) m/s
    tension: Floats  # (n, M) N
    length: Floats  # (n, M) m


def states_of(file: Path, times: Floats, values: dict[str, Floats], moments: Floats, several: set[str]) -> States:
    """States of OpenSim's run, up to where it gives up.

    Args:
        several: muscles whose moment arms are wanted.
    """
    posed = Posed(file)
    model, state, manager = begun(file, times, values, ACCURACY)
    coordinates = members(model.getCoordinateSet())
    muscles = [muscle for muscle in members(model.getMuscles()) if muscle.appliesForce(state)]
    rows: list[tuple[Any, ...]] = []
    for moment in moments:
        try:
            now = manager.integrate(float(moment)) if moment > 0.0 else state
            model.realizeAcceleration(now)
        except RuntimeError:
            break
        q, speed, acceleration = (
            np.array([getattr(one, ask)(now) for one in coordinates])
            for ask in ("getValue", "getSpeedValue", "getAccelerationValue")
        )
        asks = ("getActivation", "getFiberLength", "getFiberVelocity", "getTendonForce", "getLength")
        of_muscles = [np.array([getattr(one, ask)(now) for one in muscles]) for ask in asks]
        along, matrix = posed._along(q), posed.opensim.Matrix()
        posed.bare.getMatterSubsystem().calcM(posed.bare_state, matrix)
        mass = along.T @ matrix.to_numpy() @ along
        lacking = along.T @ put_right(posed, q, speed, acceleration)[0]
        posed.put(posed.state, posed.coordinates, q)
        posed.model.realizePosition(posed.state)
        arm = np.zeros((len(muscles), len(posed.independent)))
        for m, muscle in enumerate(posed.muscles):
            if muscle.getName() in several:
                arm[m] = [muscle.computeMomentArm(posed.state, posed.coordinates[k]) for k in posed.independent]
        right = -np.linalg.solve(mass, lacking)
        rows.append((moment, q, speed, acceleration[posed.independent], right, mass, arm, *of_muscles))
    names = [muscle.getName() for muscle in muscles]
    independent = [int(k) for k in posed.independent]
    return States(posed.names, independent, names, *(np.array(part) for part in zip(*rows, strict=True)))


def ours_at(scene: Scene, found: States, times: Floats, values: dict[str, Floats], ours: Ours) -> tuple[Floats, Floats]:
    """Accelerations of the independent coordinates (n, I) and tensions (n, M), N, of our step in OpenSim's states."""
    count, rates = len(found.time), ours.rates(found.q)
    rollout = Rollout(excited(scene, times, values, float(times[-1]) + 1.0, STEP), count, "cpu")
    state, simulated = rollout.state, list(rollout.structure.actuation.muscles)
    own = [k for k, name in enumerate(simulated) if name in found.muscles]
    column = [found.muscles.index(simulated[k]) for k in own]
    speeds = np.einsum("nsi,ni->ns", rates, found.speed[:, found.independent])
    gained = np.zeros((count, len(simulated)), dtype=np.float32)  # by activations in the step
    for _ in range(2):
        state.coordinates.assign(ours.places(found.q).astype(np.float32))
        state.speeds.assign(speeds.astype(np.float32))
        state.accelerations.zero_()
        state.step.assign(np.maximum(1, np.round(found.time / STEP)).astype(np.int32))
        level = state.muscles.activation.numpy().copy()
        level[:, own] = found.activation[:, column]
        level -= gained
        state.muscles.activation.assign(level)
        if state.muscles.fibre_length.shape == level.shape:
            for array, back in ((state.muscles.fibre_length, 1.0), (state.muscles.previous_fibre_length, 2.0)):
                fibre = array.numpy().copy()
                fibre[:, own] = (found.fibre - back * STEP * found.fibre_speed)[:, column]
                array.assign(fibre)
        rollout.step()
        gained = state.muscles.activation.numpy() - level
    ends = [ours.rates(found.q + way * MOVE * found.speed) for way in (-1.0, 1.0)]
    drift = np.einsum("nsi,ni->ns", (ends[1] - ends[0]) / (2.0 * MOVE), found.speed[:, found.independent])
    alone = state.accelerations.numpy() - drift
    tension = np.full(found.tension.shape, np.nan)
    tension[:, column] = state.muscles.force.numpy()[:, own]
    found_ones = [np.linalg.lstsq(rate, one, rcond=None)[0] for rate, one in zip(rates, alone, strict=True)]
    return np.array(found_ones), tension


def row(file: Path, seconds: float, count: int, seed: int) -> str:
    """A row of the table."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        scene = wm.load(file, hard_points=True)
    if scene.character.constraints:
        return f"| {file.stem} | has loops | | | | | | |"
    every = scene.character.muscles
    times, values = drawn([name for name, one in every.items() if not is_cable(one)], seconds, seed)
    several = {name for name, one in every.items() if len(one.wraps) > 1}
    found = with_process(states_of, file, times, values, np.linspace(0.0, seconds, count + 1), several)
    ours = Ours(scene, found.names, found.independent)
    mine, tension = ours_at(scene, found, times, values, ours)
    columns = [ours.muscles.index(name) for name in found.muscles]
    crossed = (np.abs(ours.paths(found.q, 0.0 * found.q)[2][:, columns]) > 0.0).any(axis=0)
    moment = np.einsum("nmi,nm->ni", np.where(crossed, 0.0, found.arm), found.tension)
    spurious = np.linalg.solve(found.mass, moment[:, :, None])[:, :, 0]
    right = found.acceleration + found.put_right
    cells = []
    for expected in (found.acceleration, right, right - spurious):
        off = np.abs(mine - expected).max(axis=1)
        cells.append(f"{np.quantile(off, 0.9):.2g}, {off.max():.2g}")
    f_max = np.array([float(every[name].f_max) for name in found.muscles])  # type: ignore[arg-type]
    pulls = np.nanmax(np.abs(tension - found.tension) / f_max)
    length = np.abs(ours.lengths(found.q)[:, columns] - found.length).max()
    most = np.abs(found.acceleration).max()
    ends = [f"{pulls:.0e}", f"{length:.0e} m"]
    return f"| {file.stem} | {len(found.time)} | {most:.2g} | {' | '.join(cells + ends)} |"


def main(
    models: Annotated[list[Path], typer.Argument(help="Files of the models.")],
    seconds: Annotated[float, typer.Option(help="Of motion.")] = 0.5,
    states: Annotated[int, typer.Option(help="In which accelerations are compared.")] = 25,
    seed: Annotated[int, typer.Option(help="Of the excitations.")] = 1,
    start: Annotated[list[str] | None, typer.Option(help="COORDINATE=VALUE to start at, rad or m.")] = None,
    output: Annotated[Path | None, typer.Option("-o", help="File for the table.")] = None,
) -> None:
    """Compare."""
    wp.config.log_level = wp.LOG_WARNING
    rows = started_each(models, start or [], lambda file: row(file, seconds, states, seed))
    show_table(COLUMNS, rows, output)


if __name__ == "__main__":
    run_script(main)
