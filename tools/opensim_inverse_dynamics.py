"""Whether OpenSim's inverse dynamics of an exported motion, on the model that it came from, gives our joint torques.

    warpmuscle simulate gait2392_walk --rate 1000 --set duration=4 -o walk.h5
    python tools/opensim_inverse_dynamics.py walk.h5 gait2392_millard2012muscle.osim
    python tools/opensim_inverse_dynamics.py walk.h5 gait2392_millard2012muscle.osim --spline --lowpass 80

The motion and the ground forces are exported, OpenSim 4.6 (`pip install opensim`) solves for the generalised forces,
and these are compared with the recorded torques: differences over the peak of each torque. Speeds are the recorded
ones, accelerations those of the steps that begin with each frame, which follow from the speeds. Both become rates of
OpenSim's coordinates by exporting where each frame would be a little later and a little before.

With `--spline` OpenSim's own tool differentiates a spline through the coordinates as they were recorded. Over the steps
of an impact accelerations jump, which no spline follows; so coordinates, ground forces, moments and torques may be
filtered alike before, as those of measured motions are, by a Butterworth filter of fourth order without a delay.
Every step has to be recorded: ground forces are then those of the simulation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from opensim_oracle import with_process
from scipy.signal import butter, filtfilt

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.core.pose import about, conjugate, from_rotation_vector, multiply, normalized, rotate
from warpmuscle.formats import sto
from warpmuscle.formats.external_loads import write_loads
from warpmuscle.optimization.best_scene import scene_in
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.topology import topology
from warpmuscle.studies.ground_loads import GroundLoad, ground_loads, step_accelerations
from warpmuscle.studies.inverse_dynamics import body_points

Floats = NDArray[np.float64]
RATE_TIME = 1.0e-3  # s, over which coordinates change for their rates
BOTH_WAYS = 0.802  # by which the cut-off of a filter of second order that runs both ways is less than that of one


@dataclass(frozen=True)
class Agreement:
    """How far OpenSim's torque of a coordinate is from ours, over the peak of ours."""

    coordinate: str
    peak: float  # N m
    median: float
    most: float  # 95 % of all frames are below it
    worst: float


def filtered(values: Floats, rate: float, cutoff: float) -> Floats:
    """Values (F, ...) without what is faster than a frequency, Hz; as they are if it is 0."""
    if cutoff == 0.0:
        return values
    b, a = butter(2, cutoff / (0.5 * rate) / BOTH_WAYS)
    return np.asarray(filtfilt(b, a, values, axis=0, padlen=min(300, len(values) - 1)))


def moved(motion: Recording, scene: Scene, accelerations: Floats, time: float) -> Recording:
    """The motion where each of its frames would be after so many seconds of its speeds and these accelerations, (F, S).

    So rates of coordinates of any kind, such as angles in place of a ball joint's turn, follow from differences.
    """
    names = topology(scene.character)
    recorded = np.asarray(motion.coordinate, np.float64)
    move = time * np.asarray(motion.speed, np.float64) + 0.5 * time**2 * accelerations
    found = np.zeros(recorded.shape)
    for number in range(len(names.bodies)):
        q, by = names.coordinates_of(number), move[:, names.speeds_of(number)]
        before = recorded[:, q]
        if number == 0 and before.shape[1] == 7:
            found[:, q.start : q.start + 3] = before[:, :3] + by[:, :3]
            found[:, q.start + 3 : q.stop] = multiply(from_rotation_vector(by[:, 3:]), normalized(before[:, 3:]))
        elif before.shape[1] == 4 and by.shape[1] == 3:
            found[:, q] = multiply(normalized(before), from_rotation_vector(by))
        else:
            found[:, q] = before + by
    places = body_points(scene, found)
    turns = [places[name][1] for name in names.bodies]
    relative = [multiply(conjugate(turns[names.parents[k]]), turns[k]) for k in range(1, len(turns))]
    return replace(
        motion, coordinate=found, root_position=places[names.bodies[0]][0], root_orientation=turns[0],
        joint_orientation=np.stack(relative, axis=1), body_orientation=np.stack(turns, axis=1),
    )  # fmt: skip


def along(motion: Recording, scene: Scene, torque_of: Floats, angles: dict[str, Floats]) -> dict[str, Floats]:
    """Torques (F, J, 3) on children along the coordinates of a model, (F,) each, N m.

    Args:
        angles: coordinates (F,) by name, rad.
    """
    assert scene.opensim is not None
    found: dict[str, Floats] = {}
    for number, name in enumerate(motion.joint_names):
        joint, torque = scene.character.joints[name], torque_of[:, number]
        parent = np.asarray(motion.body_orientation[:, motion.body_names.index(joint.parent)], np.float64)
        given = joint.axes or [one.axis for one in joint.rotations[:1]]
        axes = [np.broadcast_to(normalized(np.array(axis, float)), torque.shape) for axis in given]
        coordinates: tuple[str, ...] = (name,)
        if name in scene.opensim.balls:
            ball = scene.opensim.balls[name]
            coordinates = ball.names
            middle = np.cross(axes[0], axes[1]) * (-1.0 if ball.turned_round else 1.0)
            first = about(axes[0][0], angles[coordinates[0]])
            second = multiply(first, about(middle[0], angles[coordinates[1]]))
            axes = [axes[0], rotate(first, middle), rotate(second, axes[1])]
        for coordinate, axis in zip(coordinates, axes, strict=True):
            found[coordinate] = np.sum(rotate(parent, axis) * torque, axis=1)
    return found


def solved(model: str, folder: str, time: tuple[float, float]) -> None:
    """OpenSim's InverseDynamicsTool with the motion and loads of a folder, into `forces.sto` there."""
    import opensim

    opensim.Logger.setLevelString("error")
    tool, without = opensim.InverseDynamicsTool(), opensim.ArrayStr()
    without.append("Muscles")
    loaded = opensim.Model(model)
    loaded.initSystem()
    tool.setModel(loaded)
    tool.setCoordinatesFileName(f"{folder}/motion.mot")
    tool.setExternalLoadsFileName(f"{folder}/ground.xml")
    tool.setStartTime(time[0])
    tool.setEndTime(time[1])
    tool.setExcludedForces(without)
    tool.setLowpassCutoffFrequency(-1.0)
    tool.setResultsDir(folder)
    tool.setOutputGenForceFileName("forces.sto")
    tool.run()


def from_rates(model: str, folder: str) -> tuple[list[str], Floats]:
    """Coordinates and generalised forces (F, K) of OpenSim's InverseDynamicsSolver.

    Speeds and accelerations are differences between the motion in a folder and those `RATE_TIME` before and after each
    of its frames, see `moved`; the loads are there, too.
    """
    import opensim

    opensim.Logger.setLevelString("error")
    loaded, vector = opensim.Model(model), opensim.Vector.createFromMat
    loaded.updForceSet().clearAndDestroy()
    loaded.updControllerSet().clearAndDestroy()
    loads = opensim.ExternalLoads(f"{folder}/ground.xml", True)
    loaded.addModelComponent(loads)
    state = loaded.initSystem()
    tables = [table(Path(folder) / name)[1:] for name in ("motion.mot", "before.mot", "after.mot")]
    members = loaded.getCoordinateSet()
    coordinates = [members.get(k) for k in range(members.getSize())]
    places, own = [], [""] * len(coordinates)
    for coordinate in coordinates:
        rest, value = state.getQ().to_numpy().copy(), coordinate.getValue(state)
        coordinate.setValue(state, value + 0.25, False)
        places.append(int(np.argmax(np.abs(state.getQ().to_numpy() - rest))))
        coordinate.setValue(state, value, False)
        own[places[-1]] = coordinate.getName()

    def in_state_order(names: list[str], values: Floats) -> Floats:
        q = np.zeros((len(values), len(coordinates)))
        for coordinate, place in zip(coordinates, places, strict=True):
            column = values[:, names.index(coordinate.getName())]
            q[:, place] = np.radians(column) if coordinate.getMotionType() == 1 else column
        return q

    q, before, after = (in_state_order(*one) for one in tables)
    time, forces, solver = tables[0][1][:, 0], np.zeros_like(q), opensim.InverseDynamicsSolver(loaded)
    for k in range(len(time)):
        state.setTime(time[k])
        state.setQ(vector(q[k]))
        state.setU(vector((after[k] - before[k]) / (2.0 * RATE_TIME)))
        loaded.realizeVelocity(state)
        forces[k] = solver.solve(state, vector((after[k] - 2.0 * q[k] + before[k]) / RATE_TIME**2)).to_numpy()
    return own, forces


def table(file: Path) -> tuple[str, list[str], Floats]:
    """Head, names and values of a file of OpenSim's."""
    head, _, body = file.read_text().partition("endheader")
    lines = body.strip().splitlines()
    return head, lines[0].split("\t"), np.array([[float(word) for word in line.split()] for line in lines[1:]])


def compare(motion: Recording, scene: Scene, model: Path, cutoff: float, skip: float, spline: bool) -> list[Agreement]:
    """The agreement of all torques but for so many seconds at both ends."""
    accelerations = step_accelerations(motion, float(scene.time_step))  # type: ignore[arg-type]
    if accelerations is None:
        raise SystemExit(f"not every step is recorded: simulate with --rate {1.0 / float(scene.time_step):g}")  # type: ignore[arg-type]
    rate = 1.0 / float(np.median(np.diff(motion.time)))
    loads = ground_loads(motion, scene)
    with TemporaryDirectory() as folder:
        file = Path(folder) / "motion.mot"
        around = [] if spline else [("after", RATE_TIME), ("before", -RATE_TIME)]
        for name, later in [*around, ("motion", 0.0)]:
            sto.write(moved(motion, scene, accelerations, later), scene, file.with_stem(name))
            head, names, values = table(file.with_stem(name))
            rows = ["\t".join(names), *_lines(values[:, :1], filtered(values[:, 1:], rate, cutoff))]
            file.with_stem(name).write_text(head + "endheader\n" + "\n".join(rows) + "\n")
        angles = {name: np.radians(column) for name, column in zip(names, values.T, strict=True)}
        ours = along(motion, scene, -np.asarray(motion.joint_torque, np.float64), angles)
        write_loads([_filtered(one, rate, cutoff) for one in loads], motion.time, file.with_name("ground.mot"))
        if spline:
            with_process(solved, str(model), folder, (float(motion.time[0]), float(motion.time[-1])))
            _, columns, theirs = table(file.with_name("forces.sto"))
            theirs_of = {
                name.rpartition("_")[0]: column for name, column in zip(columns[1:], theirs.T[1:], strict=True)
            }
            time = theirs[:, 0]
        else:
            columns, theirs = with_process(from_rates, str(model), folder)
            theirs_of, time = dict(zip(columns, theirs.T, strict=True)), motion.time
    kept = (time > motion.time[0] + skip) & (time < motion.time[-1] - skip)
    found = []
    for name, torque in ours.items():
        mine = np.interp(time, motion.time, filtered(torque, rate, cutoff))[kept]
        peak = float(np.abs(mine).max())
        off = np.abs(theirs_of[name][kept] - mine) / peak
        found.append(Agreement(name, peak, *(float(np.quantile(off, part)) for part in (0.5, 0.95, 1.0))))
    return found


def _lines(*columns: Floats) -> list[str]:
    """Rows of a table in full precision."""
    return ["\t".join(format(x, ".17g") for x in row) for row in np.concatenate(columns, axis=1)]


def _filtered(load: GroundLoad, rate: float, cutoff: float) -> GroundLoad:
    """A load with its moment about the origin, which a filter keeps true, instead of its centre of pressure."""
    moment = np.cross(load.point, load.force) + load.torque
    parts = [filtered(part, rate, cutoff) for part in (load.force, moment)]
    return replace(load, force=parts[0], point=np.zeros_like(load.point), torque=parts[1])


def main(
    result: Annotated[Path, typer.Argument(help="HDF5 file with a motion of which every step is recorded.")],
    model: Annotated[Path, typer.Argument(help="The model of OpenSim that its scene was made of.")],
    spline: Annotated[bool, typer.Option("--spline", help="By OpenSim's tool, through a spline.")] = False,
    lowpass: Annotated[float, typer.Option(min=0, help="Hz, of the filter of everything; 0: none.")] = 0.0,
    skip: Annotated[float, typer.Option(min=0, help="Seconds at both ends that do not count.")] = 0.3,
) -> None:
    """Compare."""
    content = wm.read(result)
    found = compare(content.replays[0], scene_in(content), model, lowpass, skip, spline)
    print("| torque | peak, N m | median | 95 % | worst |\n|---|---|---|---|---|")
    for one in found:
        parts = " | ".join(f"{100.0 * part:.2f} %" for part in (one.median, one.most, one.worst))
        print(f"| {one.coordinate} | {one.peak:.1f} | {parts} |")


if __name__ == "__main__":
    run_script(main)
