"""Whether OpenSim's inverse dynamics of an exported motion, on the model that it came from, gives our joint torques.

    warpmuscle simulate gait2392_walk --rate 1000 --set duration=4 -o walk.h5
    python tools/opensim_inverse_dynamics.py walk.h5 gait2392_millard2012muscle.osim --lowpass 80

The motion and the ground forces are exported, OpenSim 4.6 (`pip install opensim`) differentiates a spline through the
motion and solves for the generalised forces, and these are compared with the recorded torques: differences over the
peak of each torque. Over the steps of an impact accelerations jump, which no spline follows; so coordinates, ground
forces, moments and torques may be filtered alike before, as those of measured motions are, by a Butterworth filter of
fourth order without a delay. Every step has to be recorded: ground forces are then those of the simulation.
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
from warpmuscle.core.pose import about, multiply, normalized, rotate
from warpmuscle.formats import sto
from warpmuscle.formats.external_loads import write_loads
from warpmuscle.optimization.best_scene import scene_in
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.topology import topology
from warpmuscle.studies.ground_loads import GroundLoad, ground_loads, step_accelerations
from warpmuscle.studies.inverse_dynamics import body_points, inverse_dynamics

Floats = NDArray[np.float64]
BOTH_WAYS = 0.802  # by which the cut-off of a filter of second order that runs both ways is less than that of one


@dataclass(frozen=True)
class Agreement:
    """How far OpenSim's torque of a coordinate is from ours, over the peak of ours."""

    coordinate: str
    peak: float  # N m
    median: float
    most: float  # 95 % of all frames are below it
    worst: float
    acted: float  # and 95 % of the torque that acted over the step


def filtered(values: Floats, rate: float, cutoff: float) -> Floats:
    """Values (F, ...) without what is faster than a frequency, Hz; as they are if it is 0."""
    if cutoff == 0.0:
        return values
    b, a = butter(2, cutoff / (0.5 * rate) / BOTH_WAYS)
    return np.asarray(filtfilt(b, a, values, axis=0, padlen=min(300, len(values) - 1)))


def acted(motion: Recording, scene: Scene, loads: list[GroundLoad]) -> Floats:
    """The torques (F, J, 3) that joints put on their children over each step, N m, world, by our inverse dynamics.

    Recorded are those at the start of a step; springs, stops and balance control that are linearised over it give way.
    """
    names, accelerations = topology(scene.character), step_accelerations(motion, float(scene.time_step))  # type: ignore[arg-type]
    assert accelerations is not None
    needed = inverse_dynamics(scene, motion.coordinate, motion.speed, accelerations)
    places, found = body_points(scene, motion.coordinate), np.zeros((motion.frames, len(names.joints), 3))
    for number, name in enumerate(names.joints, start=1):
        joint, own = scene.character.joints[name], names.bodies[number]
        carried = {number}
        for body in range(number + 1, len(names.bodies)):
            carried |= {body} if names.parents[body] in carried else set()
        force, moment = np.zeros((motion.frames, 3)), np.zeros((motion.frames, 3))
        for load in loads:
            if names.bodies.index(load.body) in carried:
                force += load.force
                moment += np.cross(load.point - places[own][0], load.force) + load.torque
        torque = needed[:, names.speeds_of(number)]
        q = np.asarray(motion.coordinate, np.float64)[:, names.coordinates_of(number)]
        moves, parent = joint_type(joint).motion(joint, q, np.zeros_like(torque)), names.bodies[names.parents[number]]
        for k, axis in enumerate(joint_type(joint).pulled_about(joint, q)):
            turning, moving, about_it = (
                rotate(places[parent][1], one) for one in (moves.turning[k], moves.moving[k], axis)
            )
            given = np.sum(turning * moment + moving * force, axis=1)
            found[:, number - 1] += about_it * (torque[:, k] - given)[:, None]
    return found


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


def table(file: Path) -> tuple[str, list[str], Floats]:
    """Head, names and values of a file of OpenSim's."""
    head, _, body = file.read_text().partition("endheader")
    lines = body.strip().splitlines()
    return head, lines[0].split("\t"), np.array([[float(word) for word in line.split()] for line in lines[1:]])


def compare(motion: Recording, scene: Scene, model: Path, cutoff: float, skip: float) -> list[Agreement]:
    """The agreement of all torques but for so many seconds at both ends."""
    if step_accelerations(motion, float(scene.time_step)) is None:  # type: ignore[arg-type]
        raise SystemExit(f"not every step is recorded: simulate with --rate {1.0 / float(scene.time_step):g}")  # type: ignore[arg-type]
    rate = 1.0 / float(np.median(np.diff(motion.time)))
    with TemporaryDirectory() as folder:
        file = Path(folder) / "motion.mot"
        sto.write(motion, scene, file)
        head, names, values = table(file)
        angles = {name: np.radians(column) for name, column in zip(names, values.T, strict=True)}
        loads = ground_loads(motion, scene)
        recorded = -np.asarray(motion.joint_torque, np.float64)
        ours, over_steps = (along(motion, scene, given, angles) for given in (recorded, acted(motion, scene, loads)))
        values[:, 1:] = filtered(values[:, 1:], rate, cutoff)
        rows = ["\t".join(names), *("\t".join(format(x, ".12g") for x in row) for row in values)]
        file.write_text(head + "endheader\n" + "\n".join(rows) + "\n")
        write_loads(
            [_filtered(one, rate, cutoff) for one in loads],
            motion.time,
            file.with_name("ground.mot"),
        )
        with_process(solved, str(model), folder, (float(motion.time[0]), float(motion.time[-1])))
        _, their_names, theirs = table(file.with_name("forces.sto"))
    kept = (theirs[:, 0] > motion.time[0] + skip) & (theirs[:, 0] < motion.time[-1] - skip)
    found = []
    for name, torque in ours.items():
        mine, over = (
            np.interp(theirs[:, 0], motion.time, filtered(given, rate, cutoff))[kept]
            for given in (torque, over_steps[name])
        )
        column = next(k for k, one in enumerate(their_names) if one in (f"{name}_moment", f"{name}_force"))
        peak = float(np.abs(mine).max())
        off = np.abs(theirs[kept, column] - mine) / peak
        parts = [float(np.quantile(off, part)) for part in (0.5, 0.95, 1.0)]
        found.append(
            Agreement(name, peak, *parts, float(np.quantile(np.abs(theirs[kept, column] - over) / peak, 0.95)))
        )
    return found


def _filtered(load: GroundLoad, rate: float, cutoff: float) -> GroundLoad:
    """A load with its moment about the origin, which a filter keeps true, instead of its centre of pressure."""
    moment = np.cross(load.point, load.force) + load.torque
    parts = [filtered(part, rate, cutoff) for part in (load.force, moment)]
    return replace(load, force=parts[0], point=np.zeros_like(load.point), torque=parts[1])


def main(
    result: Annotated[Path, typer.Argument(help="HDF5 file with a motion of which every step is recorded.")],
    model: Annotated[Path, typer.Argument(help="The model of OpenSim that its scene was made of.")],
    lowpass: Annotated[float, typer.Option(min=0, help="Hz, of the filter of everything; 0: none.")] = 80.0,
    skip: Annotated[float, typer.Option(min=0, help="Seconds at both ends that do not count.")] = 0.3,
) -> None:
    """Compare."""
    content = wm.read(result)
    found = compare(content.replays[0], scene_in(content), model, lowpass, skip)
    print("| torque | peak, N m | median | 95 % | worst | 95 %, over the step |\n|---|---|---|---|---|---|")
    for one in found:
        parts = " | ".join(f"{100.0 * part:.2f} %" for part in (one.median, one.most, one.worst, one.acted))
        print(f"| {one.coordinate} | {one.peak:.1f} | {parts} |")


if __name__ == "__main__":
    typer.run(main)
