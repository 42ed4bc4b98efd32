"""Ground forces from motions alone, beside those that plates measured or that are exact.

For docs/how-to/moments-and-muscle-forces.md.

python tools/research/without_plates.py        the walks of the folder that WARPMUSCLE_REFERENCE_DATA names
"""

from __future__ import annotations

import os
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np

from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import inverse_dynamics
from warpmuscle.inverse.files import read_coordinates
from warpmuscle.inverse.loads import read_loads
from warpmuscle.inverse.trial import Coordinates, Loads, Plate
from warpmuscle.inverse.without_plates.ground_forces import ground_forces

LOADED = 100.0  # N, from which on centres of pressure are compared
EDGE = 0.05  # s at both ends that are left out
JOINTS = ("hip_flexion", "knee_angle", "ankle_angle")


class Walk(NamedTuple):
    """Files of a walk, below the folder of reference data."""

    model: str
    motion: str
    loads: str
    filter: float | None = None
    every: int = 1
    degrees: bool | None = None  # None: as the header says


SYNTHETIC, MEASURED = "inverse/synthetic_walk", "inverse/static_optimization_92"
WALKS = [
    Walk("opensim_walk/subject01.osim", "opensim_walk/ik/subject01_walk_IK.mot", "opensim_walk/subject01_walk_grf.xml",
         6.0),
    Walk(f"{MEASURED}/subject01_simbody_adjusted_StaticOp.osim", f"{MEASURED}/subject01_walk1_Kinematics.sto",
         f"{MEASURED}/foot_floor_loads.xml", every=10),
    *(Walk(f"{SYNTHETIC}/{name}/{name}.osim", f"{SYNTHETIC}/{name}/coordinates.sto", f"{SYNTHETIC}/{name}/grf.mot",
           degrees=False) for name in ("subject01", "subject02")),
]  # fmt: skip


def compare(walk: Walk, folder: Path) -> None:
    """Print the errors of a walk."""
    body = BodyModel(folder / walk.model, "cpu")
    motion = read_coordinates(folder / walk.motion, body.scene, walk.degrees)
    motion = Coordinates(motion.names, motion.times[:: walk.every], motion.values[:: walk.every])
    measured, found = read_loads(folder / walk.loads), ground_forces(body, motion, walk.filter)
    begin, end = (max(motion.times[0], measured.times[0]) + EDGE, min(motion.times[-1], measured.times[-1]) - EDGE)
    times = motion.times[(motion.times >= begin) & (motion.times <= end)]
    print(f"{walk.motion}: {len(times)} frames")
    for plate in found.plates:
        _print_forces(plate, _same(plate, found, measured, times), found, measured, times)
    moments = [inverse_dynamics(body, motion, loads, filter=walk.filter, times=times) for loads in (measured, found)]
    for name in moments[0].names:
        if name.rpartition("_")[0] in JOINTS:
            wanted, own = (one.of(name) for one in moments)
            error = np.sqrt(np.mean((own - wanted) ** 2)) / np.abs(wanted).max()
            print(f"  moment of {name}: {error:.1%} of its peak")


def _same(plate: Plate, found: Loads, measured: Loads, times: np.ndarray) -> Plate:
    """The measured plate under the same foot."""
    own = _at(plate.force, found.times, times)[:, 1]
    return min(measured.plates, key=lambda one: np.abs(_at(one.force, measured.times, times)[:, 1] - own).mean())


def _print_forces(plate: Plate, other: Plate, found: Loads, measured: Loads, times: np.ndarray) -> None:
    own, wanted = _at(plate.force, found.times, times), _at(other.force, measured.times, times)
    on = (own[:, 1] > LOADED) & (wanted[:, 1] > LOADED)
    away = (_at(plate.point, found.times, times) - _at(other.point, measured.times, times))[on]
    rms = np.sqrt(np.mean((own - wanted) ** 2, axis=0))
    for axis, word in enumerate(("forwards", "up", "to the right")):
        r = np.corrcoef(own[:, axis], wanted[:, axis])[0, 1]
        peak = np.abs(wanted[:, axis]).max()
        print(f"  {plate.name}, {word}: {rms[axis]:.0f} N, {rms[axis] / peak:.1%} of the peak, correlation {r:.3f}")
    print(f"  {plate.name}, centre of pressure: {100 * np.sqrt(np.mean(away[:, 0] ** 2)):.1f} cm forwards")


def _at(values: np.ndarray, known: np.ndarray, times: np.ndarray) -> np.ndarray:
    return np.stack([np.interp(times, known, column) for column in values.T], axis=1)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    for one in WALKS:
        compare(one, Path(os.environ.get("WARPMUSCLE_REFERENCE_DATA", "../shared/data")))
