"""Simulated seconds a second on one CPU core: ours, and OpenSim's forward simulation of the same model beside it.

    python tools/bench_opensim.py gait2392_millard2012muscle.osim arm26.osim --seconds 0.2 --step 0.0005 --step 0.001

Both start where the model says, with muscles in equilibrium and one constant excitation of all muscles; joint limits
and ground of ours are off unless the model has them. OpenSim (`pip install opensim`) integrates with its default
method and an accuracy of 1e-4, 1e-5 and whatever else is asked for, ours with the scene's time step or those given,
for many instances on one thread. Time is that of the processor, so that others who use it do not count. What both come
to is compared in the joint that differs most: OpenSim fits its steps to its accuracy, so choose ours by what they cost
of it.
"""

from __future__ import annotations

import itertools
import os
import time
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
import typer
import warp as wp
from opensim_oracle import with_process
from opensim_posed import excite

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.scene import Excitation, Failure, Scene
from warpmuscle.simulation.rollout import Rollout


def theirs(model: Path, seconds: float, excitation: float, accuracy: float) -> tuple[float, dict[str, float]]:
    """Processor time, s, and the coordinates at the end."""
    import opensim

    opensim.Logger.setLevelString("off")
    made = opensim.Model(str(model))
    excite(made, lambda _: opensim.Constant(excitation))
    state = made.initSystem()
    muscles = made.getMuscles()
    for k in range(muscles.getSize()):
        muscles.get(k).setActivation(state, excitation)
    made.equilibrateMuscles(state)
    manager = opensim.Manager(made)
    manager.setIntegratorAccuracy(accuracy)
    manager.setWriteToStorage(False)
    manager.setPerformAnalyses(False)
    manager.initialize(state)
    began = time.process_time()
    end = manager.integrate(seconds)
    spent = time.process_time() - began
    coordinates = made.getCoordinateSet()
    every = (coordinates.get(k) for k in range(coordinates.getSize()))
    return spent, {coordinate.getName(): coordinate.getValue(end) for coordinate in every}


def scene_of(model: Path, seconds: float, excitation: float, step: float) -> Scene:
    """The scene with the same excitation of all its muscles, which nothing ends early; a step of 0 is the scene's."""
    scene = wm.load(model)
    muscles = {
        name: msgspec.structs.replace(muscle, excitation=Excitation([0.0], [excitation]))
        for name, muscle in scene.character.muscles.items()
    }
    character = msgspec.structs.replace(scene.character, muscles=muscles)
    given = msgspec.structs.replace(scene.muscle_model, initial_activation=excitation)
    never = Failure(com_height=0.0, heading=0.0)
    return msgspec.structs.replace(
        scene,
        character=character,
        duration=seconds,
        failure=never,
        muscle_model=given,
        actuation=scene.actuation,
        time_step=step or scene.time_step,
    )


def ours(scene: Scene, instances: int) -> tuple[float, dict[str, float], list[str]]:
    """Processor time, s, of all instances, the coordinates at the end, and how they ended."""
    rollout = Rollout(scene, instances, "cpu", record=[0], record_rate=1.0 / scene.duration)
    rollout.advance(1)
    rollout.reset()
    began = time.process_time()
    rollout.run()
    spent = time.process_time() - began
    q = rollout.state.coordinates.numpy()[0]
    names = rollout.recording().coordinate_names
    return spent, dict(zip(names, map(float, q), strict=True)), sorted({str(s) for s in rollout.status()})


def main(
    models: Annotated[list[Path], typer.Argument(help="Files of the models.")],
    seconds: Annotated[float, typer.Option(help="Simulated time.")] = 0.2,
    excitation: Annotated[float, typer.Option(help="Of all muscles.")] = 0.05,
    instances: Annotated[int, typer.Option(help="Of ours.")] = 16,
    accuracy: Annotated[list[float] | None, typer.Option(help="Of OpenSim's integrator.")] = None,
    step: Annotated[list[float] | None, typer.Option(min=0, help="Ours, s; 0: the scene's.")] = None,
) -> None:
    """Measure."""
    os.environ["OMP_NUM_THREADS"] = "1"
    wp.config.log_level = wp.LOG_WARNING
    print("| model | ours, s/s | OpenSim's accuracy | OpenSim, s/s | ratio | farthest apart at the end |")
    print("|---|---|---|---|---|---|")
    for model, own_step in itertools.product(models, step or [0.0]):
        scene = scene_of(model, seconds, excitation, own_step)
        spent, end, status = ours(scene, instances)
        rate = instances * seconds / spent
        for goal in accuracy or [1e-4, 1e-5]:
            other, there = with_process(theirs, model, seconds, excitation, goal)
            both: list[Any] = [(abs(end[name] - there[name]), name) for name in end if name in there]
            apart, name = max(both, default=(float("nan"), "none"))
            print(
                f"| {model.stem} | {rate:.3g} ({', '.join(status)}, step {scene.time_step:g} s) | {goal:g} "
                f"| {seconds / other:.3g} | {rate * other / seconds:.1f} | {apart:.3g} {name} |", flush=True,
            )  # fmt: skip


if __name__ == "__main__":
    np.seterr(all="ignore")
    run_script(main)
