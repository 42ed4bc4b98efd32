"""Accelerations at the start by weight and by each muscle alone, here and in OpenSim: a table for the manual.

    python tools/opensim_single_muscles.py ThoracoscapularShoulder.osim arm26.osim

Nothing moves, so that neither velocities nor steps matter, and loops may hold the bodies: what differs is a muscle's
tension or where its path pulls. OpenSim's acceleration of a coordinate is compared where its speed is the rate of its
value, which it is not in a joint of a scapula. `pip install opensim` brings OpenSim 4.6.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np
import typer
import warp as wp
from free_runs import START, Floats, excited, show_table
from opensim_free_runs import rest
from opensim_oracle import with_process
from opensim_posed import Posed

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.scene import Scene
from warpmuscle.simulation.rollout import Rollout

STEP = 1.0e-5  # s, of ours
SAME = 1.0e-9  # rad/s or m/s
NEAR, SMALL = 0.01, 1.0  # of the greatest acceleration by the muscle; rad/s^2, by which loops may give way
COLUMNS = ("model", "coordinates", "weight, apart", "muscles", "within 1 % or 1 rad/s2", "others")


def theirs(file: Path) -> tuple[list[str], list[str], Floats, Floats]:
    """Names of coordinates (K,) and muscles (M,), accelerations (M + 1, K), by weight first, and tensions (M,), N."""
    posed = Posed(file)
    model, state, muscles = posed.model, posed.state, posed.muscles
    rest(model, state)
    rows, tensions = [], []
    for only in (None, *muscles):
        now = posed.opensim.State(state)
        for muscle in muscles:
            muscle.setAppliesForce(now, only is not None and muscle.getName() == only.getName())
        model.realizeAcceleration(now)
        rows.append([one.getAccelerationValue(now) for one in posed.coordinates])
        if only is not None:
            tensions.append(only.getTendonForce(now))
    kept = [k for k, same in enumerate(rates_are_speeds(posed)) if same]
    found = np.array(rows)[:, kept]
    found[1:] -= found[0]
    return [posed.names[k] for k in kept], [muscle.getName() for muscle in muscles], found, np.array(tensions)


def rates_are_speeds(posed: Posed) -> list[bool]:
    """Whether the speed of each coordinate is the rate of its value, at speeds that are drawn; not of locked ones."""
    state, free = posed.opensim.State(posed.state), [not one.getLocked(posed.state) for one in posed.coordinates]
    for k, speed in enumerate(np.random.default_rng(1).uniform(0.5, 1.0, len(free))):
        if free[k]:
            posed.coordinates[k].setSpeedValue(state, float(speed))
    posed.model.realizeVelocity(state)
    rates = state.getQDot().to_numpy()[posed.place]
    speeds = [one.getSpeedValue(state) for one in posed.coordinates]
    return [bool(one and abs(rate - speed) < SAME) for one, rate, speed in zip(free, rates, speeds, strict=True)]


def ours_by(scene: Scene, muscle: str | None) -> tuple[dict[str, float], float]:
    """Accelerations from rest, by the names of speeds, with one muscle or none, and its tension, N."""
    own = scene.character
    alone = {} if muscle is None else {muscle: own.muscles[muscle]}
    scene = msgspec.structs.replace(scene, character=msgspec.structs.replace(own, muscles=alone))
    values = {name: np.full(2, START) for name in alone}
    rollout = Rollout(excited(scene, np.array([0.0, 1.0]), values, 1.0, STEP), 1, "cpu")
    rollout.step()
    found = rollout.state.accelerations.numpy()[0].astype(float)
    tension = float(rollout.state.muscles.force.numpy()[0, 0]) if alone else 0.0
    return dict(zip(rollout.speed_names, found.tolist(), strict=True)), tension


def row(file: Path) -> str:
    """A row of the table."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        scene = wm.load(file, hard_points=True)
    names, muscles, expected, tensions = with_process(theirs, file)
    weight, _ = ours_by(scene, None)
    shared = [name for name in names if name in weight]
    expected = expected[:, [names.index(name) for name in shared]]
    base = np.array([weight[name] for name in shared])
    far: list[str] = []
    for k, muscle in enumerate(muscles):
        found, tension = ours_by(scene, muscle)
        ours = np.array([found[name] for name in shared]) - base
        ours *= tensions[k] / tension if tension > 0.0 else 1.0  # what the muscle pulls with is compared elsewhere
        off, most = np.abs(ours - expected[k + 1]).max(), np.abs(expected[k + 1]).max()
        if off > max(NEAR * most, SMALL):
            far.append(f"{muscle} {off:.2g} of {most:.2g}")
    weight_off = f"{np.abs(base - expected[0]).max():.1g} of {np.abs(expected[0]).max():.2g}"
    near = len(muscles) - len(far)
    return f"| {file.stem} | {len(shared)} | {weight_off} | {len(muscles)} | {near} | {', '.join(far[:4])} |"


def main(
    models: Annotated[list[Path], typer.Argument(help="Files of the models.")],
    output: Annotated[Path | None, typer.Option("-o", help="File for the table.")] = None,
) -> None:
    """Compare."""
    wp.config.log_level = wp.LOG_WARNING
    show_table(COLUMNS, (row(file) for file in models), output)


if __name__ == "__main__":
    run_script(main)
