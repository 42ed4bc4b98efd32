"""Whether static optimisation finds OpenSim's activations of a motion, and which of both is nearer to the optimum.

    python tools/opensim_static_optimization.py Rajagopal2016.osim walk.mot --loads loads.xml --filter 6 --every 5

OpenSim 4.6 (`pip install opensim`) runs its StaticOptimization. What that asks of its optimiser in each frame is put
together anew from OpenSim's own functions: which accelerations every actuator makes at full activation, and which are
wanted. The least sum of squares is then found exactly, as a bounded least-squares problem (scipy, BVLS), which both
answers are compared with: the greatest difference of a muscle's activation in each frame. Told as well are the reserves
that OpenSim's answer would need for balance beyond those that it has.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from warpmuscle.cli.ending import run_script
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.files import read_coordinates
from warpmuscle.inverse.loads import read_loads
from warpmuscle.inverse.muscle_groups import groups_of
from warpmuscle.inverse.static_optimization import static_optimization

Floats = NDArray[np.float64]
STRONG = 1000.0  # N or N m, of reserves of coordinates without muscles, which change no activation
UNBOUND = 1.0e6


@dataclass(frozen=True)
class Problem:
    """What OpenSim asks of its optimiser in one frame: activations x of M muscles, all else made by reserves.

    Attributes:
        muscle, reserve: (C, M) and (C, R) accelerations by a unit of each. wanted: (C,) accelerations. strength: (R,).
        low, high: (M,) bounds.
    """

    muscle: Floats
    reserve: Floats
    wanted: Floats
    strength: Floats
    low: Floats
    high: Floats

    def reserves(self, activation: Floats) -> Floats:
        """Activations (R,) of the reserves that balance these of the muscles."""
        return np.asarray(np.linalg.solve(self.reserve, self.wanted - self.muscle @ activation))

    def optimum(self) -> Floats:
        """Activations (M,) of least sum of squares."""
        count = len(self.low)
        rows = np.concatenate([np.eye(count), np.linalg.solve(self.reserve, self.muscle)])
        target = np.concatenate([np.zeros(count), np.linalg.solve(self.reserve, self.wanted)])
        return np.asarray(
            lsq_linear(rows, target, (self.low, self.high), method="bvls", tol=1e-13, max_iter=5000).x, np.float64
        )

    def cost(self, activation: Floats) -> float:
        """Sum of squares of activations and of the reserves that balance them."""
        return float(np.sum(activation**2) + np.sum(self.reserves(activation) ** 2))


def write_reserves(strengths: Mapping[str, float], path: Path) -> None:
    """A set of actuators, one a coordinate, with their strengths, N m or N."""
    import opensim

    found = opensim.ForceSet()
    for name, strength in strengths.items():
        one = opensim.CoordinateActuator(name)
        one.setName(f"{name}_reserve")
        one.setOptimalForce(strength)
        one.setMinControl(-UNBOUND)
        one.setMaxControl(UNBOUND)
        found.cloneAndAppend(one)
    found.printToXML(str(path))


def analyze(
    model: Path, motion: Path, loads: Path | None, reserves: Path, analyses: Sequence[Any], times: tuple[float, float],
    folder: Path, cutoff: float = -1.0,
) -> None:  # fmt: skip
    """OpenSim's AnalyzeTool with some analyses of a motion, whose files come into a folder.

    Args:
        times: s, the first and the last. cutoff: Hz, of its low-pass of coordinates; -1 for none.
    """
    import opensim

    tool, files = opensim.AnalyzeTool(), opensim.ArrayStr()
    tool.setName("tool")
    tool.setModelFilename(str(model.resolve()))
    tool.setCoordinatesFileName(str(motion.resolve()))
    if loads is not None:
        tool.setExternalLoadsFileName(str(loads.resolve()))
    files.append(str(reserves))
    tool.setForceSetFiles(files)
    tool.setReplaceForceSet(False)
    tool.setInitialTime(times[0])
    tool.setFinalTime(times[1])
    tool.setLowpassCutoffFrequency(cutoff)
    tool.setResultsDir(str(folder))
    for one in analyses:
        one.setStartTime(times[0])
        one.setEndTime(times[1])
        tool.updAnalysisSet().cloneAndAppend(one)
    tool.printToXML(str(folder / "setup.xml"))
    opensim.AnalyzeTool(str(folder / "setup.xml")).run()


def table(path: Path) -> tuple[Floats, list[str], Floats]:
    """Times, names and values of a file of OpenSim's."""
    import opensim

    found = opensim.TimeSeriesTable(str(path))
    return np.array(found.getIndependentColumn()), list(found.getColumnLabels()), found.getMatrix().to_numpy()


class Asked:
    """OpenSim's static optimisation of a motion, frame by frame."""

    def __init__(self, model: Path, loads: Path | None, reserves: Path, states: Path) -> None:
        """Args: states: what AnalyzeTool's StatesReporter has written of all of the motion."""
        import opensim

        self.model, self._tool = opensim.Model(str(model)), opensim.AnalyzeTool()
        if loads is not None:
            self._tool.createExternalLoads(str(loads.resolve()), self.model)
        forces = opensim.ForceSet(str(reserves))
        for k in range(forces.getSize()):
            self.model.updForceSet().cloneAndAppend(forces.get(k))
        self.state = self.model.initSystem()
        self.model.setAllControllersEnabled(False)
        self.times, self.names, self.values = table(states)
        self.spline = opensim.GCVSplineSet(5, opensim.Storage(str(states)))
        actuators, muscles = self.model.getActuators(), self.model.getMuscles()
        self.actuators = [opensim.ScalarActuator.safeDownCast(actuators.get(k)) for k in range(actuators.getSize())]
        self.muscles = {one.getName(): one for one in (muscles.get(k) for k in range(muscles.getSize()))}
        coordinates = self.model.getCoordinateSet()
        every = [coordinates.get(k) for k in range(coordinates.getSize())]
        self.free = [one for one in every if not one.isConstrained(self.state)]

    def _accelerations(self) -> Floats:
        self.model.realizeAcceleration(self.state)
        return np.array([one.getAccelerationValue(self.state) for one in self.free])

    def _place(self, time: float) -> None:
        """Put the model where the motion is."""
        import opensim

        row = int(np.argmin(np.abs(self.times - time)))
        names = self.model.getStateVariableNames()
        given = opensim.Vector(names.getSize(), 0.0)
        for k in range(names.getSize()):
            if names.get(k) in self.names:
                given.set(k, float(self.values[row, self.names.index(names.get(k))]))
        self.state.setTime(time)
        self.model.setStateVariableValues(self.state, given)
        self.model.assemble(self.state)

    def at(self, time: float) -> Problem:
        """What is asked at a time."""
        self._place(time)
        speeds = [f"/{one.getName()}/speed" for one in self.free]
        columns = [next(k for k, name in enumerate(self.names) if name.endswith(speed)) for speed in speeds]
        wanted = np.array(
            [self.spline.evaluate(self.spline.getIndex(self.names[k]), 1, time) for k in columns], np.float64
        )
        for one in self.actuators:
            one.overrideActuation(self.state, False)
        self.model.realizeVelocity(self.state)
        most = np.array([
            self.muscles[one.getName()].calcInextensibleTendonActiveFiberForce(self.state, 1.0)
            if one.getName() in self.muscles else one.getOptimalForce() for one in self.actuators
        ])  # fmt: skip
        for one in self.actuators:
            one.overrideActuation(self.state, True)
            one.setOverrideActuation(self.state, 0.0)
        rest, made = self._accelerations(), np.zeros((len(self.free), len(most)))
        for k, one in enumerate(self.actuators):
            one.setOverrideActuation(self.state, float(most[k]))
            made[:, k] = self._accelerations() - rest
            one.setOverrideActuation(self.state, 0.0)
        names = [one.getName() for one in self.actuators]
        muscle = [names.index(name) for name in self.muscles]
        reserve = [names.index(f"{one.getName()}_reserve") for one in self.free]
        bounds = [[one.get_min_control(), one.get_max_control()] for one in self.muscles.values()]
        low, high = np.array(bounds).T
        return Problem(made[:, muscle], made[:, reserve], wanted - rest, most[reserve], low, high)


def compared(name: str, one: Floats, other: Floats, muscles: Sequence[str]) -> str:
    """A row of the table: greatest differences (F, M) of frames, and the muscle that differs most."""
    off = np.abs(one - other)
    frames = off.max(axis=1)
    return f"| {name} | {np.median(frames):.4f} | {frames.max():.4f} | {muscles[int(np.argmax(off.max(axis=0)))]} |"


def main(
    model: Annotated[Path, typer.Argument(help="Model of OpenSim.")],
    motion: Annotated[Path, typer.Argument(help="Coordinates, .mot or .sto.")],
    loads: Annotated[Path | None, typer.Option(help="External loads, .xml.")] = None,
    filter: Annotated[float | None, typer.Option(metavar="HZ", help="Cut-off of a low-pass.")] = None,
    every: Annotated[int, typer.Option(min=1, help="Take only every Nth frame.")] = 1,
    begin: Annotated[float, typer.Option(help="First time, s.")] = -np.inf,
    end: Annotated[float, typer.Option(help="Last time, s.")] = np.inf,
    reserve: Annotated[float, typer.Option(help="N m, of reserves where muscles act.")] = 1.0,
) -> None:
    """Compare OpenSim's activations, ours and the optimum of what OpenSim is asked."""
    import opensim

    opensim.Logger.setLevelString("off")
    body = BodyModel(model, "cpu", model_forces=True)
    recorded = read_coordinates(motion, body.scene)
    times = recorded.times[(recorded.times >= begin) & (recorded.times <= end)]
    pulled = {body.map.coordinate_of(speed) for speed in groups_of(body).coordinates}
    strengths = {name: reserve if name in pulled else STRONG for name in body.map.names}
    cutoff = -1.0 if filter is None else filter
    with TemporaryDirectory() as place:
        folder = Path(place)
        write_reserves(strengths, folder / "reserves.xml")
        given = model, motion, loads, folder / "reserves.xml"
        states = opensim.StatesReporter()
        states.setName("states")
        analyze(*given, [states], (float(recorded.times[0]), float(recorded.times[-1])), folder, cutoff)
        optimised = opensim.StaticOptimization()
        optimised.setName("optimised")
        optimised.setStepInterval(every)
        analyze(*given, [optimised], (float(times[0]), float(times[-1])), folder, cutoff)
        at, names, values = table(folder / "tool_optimised_activation.sto")
        asked = Asked(model, loads, folder / "reserves.xml", folder / "tool_states_states.sto")
        problems = [asked.at(float(time)) for time in at]
    found = static_optimization(
        body, recorded, None if loads is None else read_loads(loads), filter=filter, reserve=reserve,
        times=np.clip(at, recorded.times[0], recorded.times[-1]),
    )  # fmt: skip
    muscles = list(asked.muscles)
    theirs = values[:, [names.index(name) for name in muscles]]
    ours = found.activation[:, [found.muscles.index(name) for name in muscles]]
    best = np.array([problem.optimum() for problem in problems])
    made = values[:, [names.index(f"{one.getName()}_reserve") for one in asked.free]]
    lacking = max(
        float(np.abs((one.reserves(x) - own) * one.strength).max())
        for one, x, own in zip(problems, theirs, made, strict=True)
    )
    dearer = [
        float(np.median([one.cost(x) / one.cost(y) - 1.0 for one, x, y in zip(problems, answer, best, strict=True)]))
        for answer in (theirs, ours)
    ]
    print(f"{len(at)} frames, {len(muscles)} muscles\n")
    print("| activations | median of frames | worst | muscle |\n|---|---|---|---|")
    print(compared("OpenSim's beside the optimum of what it is asked", theirs, best, muscles))
    print(compared("ours beside that", ours, best, muscles))
    print(compared("ours beside OpenSim's", ours, theirs, muscles))
    print(f"\nOpenSim's answers leave up to {lacking:.2g} N m or N unbalanced; cost above the least, median: "
          f"{dearer[0]:.1e} OpenSim's, {dearer[1]:.1e} ours")  # fmt: skip


if __name__ == "__main__":
    run_script(main)
