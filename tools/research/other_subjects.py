"""How near markers and a generic model come to subjects of other shapes, whose angles and moments are known.

For docs/how-to/recordings-to-muscles.md.

Subjects are drawn: OpenSim scales each body of a known walker by factors of its own along three axes, alike left and
right, and its markers with them, to another mass; coordinates are those of the known walk, markers where OpenSim has
them then. Each body keeps its share of the mass, as `wm.scale` takes it to, unless `--masses` says otherwise. OpenSim
and reference data are needed.

python tools/research/other_subjects.py
python tools/research/other_subjects.py --spread 0.15 --marker-error 0.003 --masses
"""

from __future__ import annotations

import os
import warnings
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np
import typer

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.inverse.dynamics import Moments, inverse_dynamics
from warpmuscle.inverse.files import angle_names, read_coordinates
from warpmuscle.inverse.loads import read_loads
from warpmuscle.inverse.trial import Coordinates, Markers

DATA = Path(os.environ.get("WARPMUSCLE_REFERENCE_DATA", "../shared/data")) / "inverse/synthetic_walk"
SIZES = 0.06  # standard deviation of a whole subject's size
MASSES = (60.0, 100.0)  # kg
EVERY = 2  # frames
LEGS = ("hip_", "knee_", "ankle_")


def subject(path: Path, seed: int, spread: float, error: float, masses: bool) -> tuple[Any, float]:
    """OpenSim's model of a subject, also written into a file, and its mass, kg."""
    import opensim

    random = np.random.default_rng(seed)
    model = opensim.Model(str(DATA / "subject01/subject01.osim"))
    state = model.initSystem()
    factors: dict[str, Any] = {}
    scales, size = opensim.ScaleSet(), 1.0 + SIZES * random.normal()
    for k in range(model.getBodySet().getSize()):
        name = model.getBodySet().get(k).getName()
        own = factors.setdefault(name.replace("_l", "_r"), size * (1.0 + spread * random.uniform(-1.0, 1.0, 3)))
        scale = opensim.Scale()
        scale.setSegmentName(name)
        scale.setScaleFactors(opensim.Vec3(*own))
        scale.setApply(True)
        scales.cloneAndAppend(scale)
    mass = float(random.uniform(*MASSES))
    model.scale(state, scales, not masses, mass)
    model.initSystem()
    markers = model.updMarkerSet()
    for k in range(markers.getSize()):
        place = markers.get(k).get_location()
        markers.get(k).set_location(opensim.Vec3(*[place[axis] + error * random.normal() for axis in range(3)]))
    model.printToXML(str(path))
    return model, mass


def walked(model: Any, motion: Coordinates) -> Markers:
    """Where OpenSim has the markers of a model in a motion."""
    state = model.initSystem()
    markers, coordinates = model.getMarkerSet(), model.getCoordinateSet()
    positions = np.zeros((len(motion.times), markers.getSize(), 3))
    for row, values in enumerate(motion.values):
        for name, value in zip(motion.names, values, strict=True):
            coordinates.get(name).setValue(state, float(value), False)
        model.assemble(state)
        model.realizePosition(state)
        for k in range(markers.getSize()):
            place = markers.get(k).getLocationInGround(state)
            positions[row, k] = [place[axis] for axis in range(3)]
    names = tuple(markers.get(k).getName() for k in range(markers.getSize()))
    return Markers(names, motion.times, positions)


def off(found: Moments, truth: Moments) -> dict[str, float]:
    """Root mean squares of differences of moments of the legs, parts of their peaks."""
    names = [one for one in truth.names[truth.residuals :] if one.startswith(LEGS) and not one.endswith("beta")]
    return {
        one: float(np.sqrt(np.mean((found.of(one) - truth.of(one)) ** 2)) / np.abs(truth.of(one)).max())
        for one in names
    }


def main(
    subjects: Annotated[int, typer.Option(min=1, help="How many.")] = 10,
    seed: Annotated[int, typer.Option(help="Of the first one.")] = 1,
    spread: Annotated[float, typer.Option(help="By which a body's three sizes differ from the subject's.")] = 0.2,
    marker_error: Annotated[float, typer.Option(help="m, standard deviation of places of markers on bodies.")] = 0.0,
    masses: Annotated[bool, typer.Option("--masses", help="Bodies weigh as their volumes do.")] = False,
) -> None:
    """Print a line a subject, and the worst of all."""
    warnings.simplefilter("ignore")
    known = wm.load(DATA / "subject01/subject01.osim", ignored=[])
    recorded = read_coordinates(DATA / "subject01/coordinates.sto", known, degrees=False)
    motion = Coordinates(recorded.names, recorded.times[::EVERY], recorded.values[::EVERY])
    loads, worst = read_loads(DATA / "subject01/grf.mot"), [0.0, 0.0]
    for number in range(seed, seed + subjects):
        with TemporaryDirectory() as folder:
            path = Path(folder) / "subject.osim"
            model, mass = subject(path, number, spread, marker_error, masses)
            markers = walked(model, motion)
            scene = wm.load(path, ignored=[])
            fitted = wm.scale(DATA / "unscaled_generic.osim", markers, mass=mass).scene
            found = wm.inverse_kinematics(fitted, markers).coordinates
            turned = [name for name in motion.names if name in angle_names(scene) and name in found.names]
            far = {one: float(np.degrees(np.sqrt(np.mean((found.of(one) - motion.of(one)) ** 2)))) for one in turned}
            moments = off(inverse_dynamics(fitted, found, loads), inverse_dynamics(scene, motion, loads))
        angle, moment = max(far, key=lambda one: far[one]), max(moments, key=lambda one: moments[one])
        worst = [max(worst[0], far[angle]), max(worst[1], moments[moment])]
        print(f"subject {number}, {mass:.0f} kg: angles within {far[angle]:.2f} degrees RMS ({angle}), moments of the "
              f"legs within {moments[moment]:.1%} of the peak RMS ({moment})", flush=True)  # fmt: skip
    print(f"all: {worst[0]:.2f} degrees, {worst[1]:.1%}")


if __name__ == "__main__":
    run_script(main)
