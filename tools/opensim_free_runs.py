"""Free runs of OpenSim models beside OpenSim's Manager, with drawn excitations: a table for the manual.

    python tools/opensim_free_runs.py MoBL_ARMS.osim wrist.osim --seconds 0.5 -o table.md

All muscles are excited along straight lines between drawn knots, from the same start. OpenSim integrates with two
accuracies, and what these differ by is what a comparison can tell. Then the model moves without muscles and other
forces, if it has no loops: OpenSim's energy of our motion should stay. `pip install opensim` brings OpenSim 4.6.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import msgspec
import numpy as np
import typer
import warp as wp
from free_runs import FRAMES, START, Floats, differences, drawn, excited, show_table
from opensim_oracle import with_process
from opensim_ours import bare
from opensim_posed import coordinate_names, excite, members

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.core.errors import SceneError
from warpmuscle.core.status import Status
from warpmuscle.results.degrees_of_freedom import degrees_of_freedom
from warpmuscle.scene import Scene
from warpmuscle.scene.muscles import is_cable
from warpmuscle.simulation.rollout import Rollout

ACCURACIES = (1.0e-4, 1.0e-5)
SHORTEST = 1.0e-9  # s, least step of OpenSim's
LONGEST = 300.0  # s, of processor time for one run of OpenSim
TURN = 2.0 * np.pi  # by which angles may differ
COLUMNS = ("model", "muscles", "coordinates", "farthest apart", "at 0.1 s", "OpenSim's accuracies", "energy")


def rest(model: Any, state: Any) -> None:
    """Put a model of OpenSim together, its muscles in equilibrium at their first activation."""
    model.assemble(state)
    for muscle in members(model.getMuscles()):
        if muscle.appliesForce(state):
            muscle.setActivation(state, START)
    model.equilibrateMuscles(state)


def begun(file: Path, times: Floats, values: dict[str, Floats], accuracy: float) -> tuple[Any, Any, Any]:
    """A model of OpenSim whose muscles are excited along lines, its first state, and the Manager of its run."""
    import opensim

    opensim.Logger.setLevelString("off")
    model = opensim.Model(str(file))

    def line_of(name: str) -> Any:
        if name not in values:
            return None
        line = opensim.PiecewiseLinearFunction()
        for knot, value in zip(times, values[name], strict=True):
            line.addPoint(float(knot), float(value))
        return line

    excite(model, line_of)
    state = model.initSystem()
    rest(model, state)
    manager = opensim.Manager(model)
    manager.setIntegratorAccuracy(accuracy)
    manager.setIntegratorMinimumStepSize(SHORTEST)
    manager.setWriteToStorage(False)
    manager.setPerformAnalyses(False)
    manager.initialize(state)
    return model, state, manager


def theirs(
    file: Path, times: Floats, values: dict[str, Floats], accuracy: float, frames: Floats
) -> dict[str, list[float]]:
    """OpenSim's coordinates by name at some times, up to where it gives up."""
    model, state, manager = begun(file, times, values, accuracy)
    coordinates = members(model.getCoordinateSet())
    names = coordinate_names(coordinates)
    found: dict[str, list[float]] = {name: [] for name in names}
    for moment in frames:
        if time.process_time() > LONGEST:
            break
        try:
            now = manager.integrate(float(moment)) if moment > 0.0 else state
        except RuntimeError:
            break
        for name, one in zip(names, coordinates, strict=True):
            found[name].append(one.getValue(now))
    return found


def started(file: Path, starts: dict[str, float], folder: Path) -> Path:
    """The model with other default values of some coordinates, written by OpenSim to a file in a folder."""
    import opensim

    opensim.Logger.setLevelString("off")
    model = opensim.Model(str(file))
    for name, value in starts.items():
        model.updCoordinateSet().get(name).setDefaultValue(value)
    model.initSystem()
    model.printToXML(str(folder / file.name))
    return folder / file.name


def started_each(models: Sequence[Path], start: Sequence[str], row_of: Callable[[Path], str]) -> Iterator[str]:
    """The row of each model, which starts at COORDINATE=VALUE, rad or m, where some are given."""
    starts = {name: float(value) for name, _, value in (word.partition("=") for word in start)}
    for file in models:
        with TemporaryDirectory() as folder:
            yield row_of(with_process(started, file, starts, Path(folder)) if starts else file)


def energies(file: Path, names: list[str], q: Floats, rate: Floats) -> Floats:
    """OpenSim's kinetic and potential energy (n, 2) of a model without forces at coordinates (n, K) and their rates."""
    import opensim

    opensim.Logger.setLevelString("off")
    model = opensim.Model(str(file))
    model.updForceSet().clearAndDestroy()
    model.updControllerSet().clearAndDestroy()
    state = model.initSystem()
    all_of_them = members(model.getCoordinateSet())
    named = zip(coordinate_names(all_of_them), all_of_them, strict=True)
    ones = [(names.index(name), one) for name, one in named if name in names]
    couplers = [one for one in map(_coupler, members(model.getConstraintSet())) if one is not None]
    couplers = [one for one in couplers if one.getDependentCoordinateName() not in names]
    found = []
    for places, speeds in zip(q, rate, strict=True):
        for k, one in ones:
            if not one.getLocked(state):
                one.setValue(state, float(places[k]), False)
                one.setSpeedValue(state, float(speeds[k]))
        for one in couplers:
            _follow(model, state, one)
        model.realizeVelocity(state)
        found.append([model.calcKineticEnergy(state), model.calcPotentialEnergy(state)])
    return np.array(found)


def _coupler(constraint: Any) -> Any:
    import opensim

    return opensim.CoordinateCouplerConstraint.safeDownCast(constraint)


def _follow(model: Any, state: Any, coupler: Any) -> None:
    """Put a coordinate of OpenSim where a coupler has it: our recordings do not name what follows several ones."""
    import opensim

    independent, function = coupler.getIndependentCoordinateNames(), coupler.getFunction()
    others = [model.getCoordinateSet().get(independent.get(k)) for k in range(independent.getSize())]
    places, speed = opensim.Vector(len(others), 0.0), 0.0
    for k, one in enumerate(others):
        places[k] = one.getValue(state)
    for k, one in enumerate(others):
        by = opensim.StdVectorInt()
        by.append(k)
        speed += function.calcDerivative(by, places) * one.getSpeedValue(state)
    scale = opensim.PropertyHelper.getValueDouble(coupler.getPropertyByName("scale_factor"))
    follower = model.getCoordinateSet().get(coupler.getDependentCoordinateName())
    follower.setValue(state, scale * function.calcValue(places), False)
    follower.setSpeedValue(state, scale * speed)


def ours(scene: Scene, rate: float) -> tuple[list[str], Floats, Floats, str]:
    """Names of coordinates, times (n,), values (n, K), and how the run ended."""
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=rate)
    rollout.run()
    recording = rollout.recording()
    found = degrees_of_freedom(recording, scene)
    values = np.stack([degree.values for degree in found], axis=1)
    status = Status(int(rollout.status()[0])).name
    return [degree.name for degree in found], np.asarray(recording.time, dtype=float), values, status


def energy_drift(file: Path, scene: Scene, seconds: float, step: float) -> float:
    """The greatest change of energy of a free run without forces, over the greatest kinetic energy."""
    still = bare(scene)
    bodies = {name: msgspec.structs.replace(body, shapes=[]) for name, body in still.character.bodies.items()}
    character = msgspec.structs.replace(still.character, bodies=bodies, muscles={})
    still = excited(msgspec.structs.replace(still, character=character), np.zeros(1), {}, seconds, step)
    names, _, q, _ = ours(still, 1.0 / step)
    rate = (8.0 * (q[3:-1] - q[1:-3]) - (q[4:] - q[:-4])) / (12.0 * step)
    some = np.linspace(0, len(rate) - 1, FRAMES).astype(int)
    kinetic, potential = with_process(energies, file, names, q[2:-2][some], rate[some]).T
    total = kinetic + potential
    return float(np.abs(total - total[0]).max() / max(kinetic.max(), 1e-9))


def row(file: Path, seconds: float, step: float, seed: int, hard_points: bool = False) -> str:
    """A row of the table."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            scene = wm.load(file, hard_points=hard_points)
        except SceneError as error:
            return f"| {file.stem} | | | {error.message} | | | |"
    names = [name for name, muscle in scene.character.muscles.items() if not is_cable(muscle)]
    times, values = drawn(names, seconds, seed)
    mine, moments, q, status = ours(excited(scene, times, values, seconds, step), FRAMES / seconds)
    rough, fine = (with_process(theirs, file, times, values, accuracy, moments) for accuracy in ACCURACIES)
    shared = [name for name in mine if name in fine]
    count = min(len(moments), *(len(run[name]) for run in (rough, fine) for name in shared))
    there, coarse = (np.column_stack([run[name][:count] for name in shared]) for run in (fine, rough))
    here = q[:count, [mine.index(name) for name in shared]]
    off, own = (np.abs(one - there) for one in (here, coarse))
    off = np.minimum(off, np.abs(TURN - off))
    ended = "" if count == len(moments) else f"; OpenSim ends at {moments[count - 1]:.2g} s"
    ended += "" if status == "COMPLETED" else f"; ours {status}"
    drift = "-" if scene.character.constraints else f"{energy_drift(file, scene, seconds, step):.0e}"
    farthest, early = differences(off, there, shared, moments[:count])
    cells = [farthest + ended, early]
    cells += [f"{own.max():.1g}", drift]
    return f"| {file.stem} | {len(names)} | {len(shared)} | {' | '.join(cells)} |"


def main(
    models: Annotated[list[Path], typer.Argument(help="Files of the models.")],
    seconds: Annotated[float, typer.Option(help="Of motion.")] = 0.5,
    step: Annotated[float, typer.Option(help="Ours, s.")] = 2.0e-4,
    seed: Annotated[int, typer.Option(help="Of the excitations.")] = 1,
    start: Annotated[list[str] | None, typer.Option(help="COORDINATE=VALUE to start at, rad or m.")] = None,
    hard_points: Annotated[bool, typer.Option("--hard-points", help="As of `warpmuscle convert`.")] = False,
    output: Annotated[Path | None, typer.Option("-o", help="File for the table.")] = None,
) -> None:
    """Compare."""
    wp.config.log_level = wp.LOG_WARNING
    rows = started_each(models, start or [], lambda file: row(file, seconds, step, seed, hard_points))
    show_table(COLUMNS, rows, output)


if __name__ == "__main__":
    run_script(main)
