"""How near the steps from recordings to joints are to OpenSim's published results, and to motions that are known.

For docs/how-to/moments-and-muscle-forces.md.

python tools/research/recordings_table.py        the folder that WARPMUSCLE_REFERENCE_DATA names
"""

from __future__ import annotations

import os
import warnings
from pathlib import Path

import numpy as np

import warpmuscle as wm
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import Moments, inverse_dynamics
from warpmuscle.inverse.files import angle_names, read_coordinates
from warpmuscle.inverse.loads import read_loads
from warpmuscle.inverse.reactions.joint_reactions import joint_reactions
from warpmuscle.inverse.static_optimization import static_optimization
from warpmuscle.synergy.tables import read_table

LEGS = ("hip_", "knee_", "ankle_")


def columns(path: Path) -> dict[str, np.ndarray]:
    """Columns of a table by their names."""
    table = read_table(path)
    return dict(zip(table.names, table.columns(range(len(table.names))).T, strict=True))


def measured_walk(folder: Path) -> None:
    """OpenSim's walk of 18 muscles."""
    scene = wm.load(folder / "subject01.osim", ignored=[])
    found = wm.inverse_kinematics(scene, folder / "subject01_walk.trc", setup=folder / "ik/walk_Setup_IK.xml")
    published = read_coordinates(folder / "ik/subject01_walk_IK.mot", scene)
    angles = [name for name in published.names if name in angle_names(scene)]
    far = max(np.abs(found.coordinates.of(name) - published.of(name)).max() for name in angles)
    print(f"opensim_walk, inverse kinematics: angles within {np.degrees(far):.3f} degrees of OpenSim's")
    moments = inverse_dynamics(scene, published, read_loads(folder / "subject01_walk_grf.xml"), filter=6.0)
    theirs = columns(folder / "id/subject01_walk_ID.sto")
    off = [_off(moments, name, unit, theirs) for name, unit in zip(moments.names, moments.units, strict=True)]
    print(f"opensim_walk, inverse dynamics: within {max(off):.1e} of the peak")


def _off(moments: Moments, name: str, unit: str, theirs: dict[str, np.ndarray]) -> float:
    wanted = theirs[f"{name}_{'moment' if unit == 'N m' else 'force'}"]
    own = np.interp(theirs["time"], moments.times, moments.of(name))
    return float(np.abs(own - wanted).max() / np.abs(wanted).max())


def muscles_and_joints(folder: Path) -> None:
    """OpenSim's walk of 92 muscles."""
    body = BodyModel(folder / "subject01_simbody_adjusted_StaticOp.osim", "cpu")
    motion = read_coordinates(folder / "subject01_walk1_Kinematics.sto", body.scene)
    loads = read_loads(folder / "foot_floor_loads.xml")
    theirs = columns(folder / "subject01_StaticOptimization_activation.sto")
    times = np.minimum(theirs["time"], motion.times[-1])
    found = static_optimization(body, motion, loads, times=times)
    worst = np.abs(found.activation - np.stack([theirs[name] for name in found.muscles], axis=1)).max(axis=1)
    print(f"92 muscles, activations: {np.median(worst):.4f} in the median frame, {worst.max():.4f} in the worst")
    theirs = columns(folder / "subject01_JointReaction_ReactionLoads.sto")
    times, own = np.minimum(theirs["time"], motion.times[-1]), {}
    muscles = static_optimization(body, motion, loads, times=times)
    for on, frame in (("child", "child"), ("parent", "child")):
        own |= joint_reactions(body, motion, loads, muscles, times=times, on=on, frame=frame).columns()
    for start in ("hip_r_on_femur_r_in_femur_r", "hip_r_on_pelvis_in_femur_r"):
        names = [f"{start}_f{axis}" for axis in "xyz"]
        wanted = np.stack([theirs[name] for name in names])
        off = np.abs(np.stack([own[name] for name in names]) - wanted).max() / np.abs(wanted).max()
        print(f"92 muscles, reaction of {start}: within {off:.2%} of the peak")


def known_walk(folder: Path, subject: str) -> None:
    """A synthetic walk, from the model of the subject and from the generic one."""
    at = folder / subject
    own = wm.load(at / f"{subject}.osim", ignored=[])
    mass = sum(float(body.mass) for body in own.character.bodies.values())  # that was measured: 72.84 and 76.48 kg
    fitted = wm.scale(folder / "unscaled_generic.osim", at / "markers.trc", mass=mass).scene
    truth = read_coordinates(at / "coordinates.sto", own, degrees=False)
    loads, theirs = read_loads(at / "grf.mot"), columns(at / "id.sto")
    for word, scene in (("its model", own), ("the generic model", fitted)):
        motion = wm.inverse_kinematics(scene, at / "markers.trc").coordinates
        angles = [name for name in truth.names if name in angle_names(scene) and name in motion.names]
        far = {name: np.sqrt(np.mean((motion.of(name) - truth.of(name)) ** 2)) for name in angles}
        name = max(far, key=lambda one: far[one])
        print(f"{subject}, {word}: angles within {np.degrees(far[name]):.3f} degrees RMS ({name})")
        moments = inverse_dynamics(scene, motion, loads)
        off = {one: _rms(moments, one, theirs) for one in moments.names[moments.residuals :]}
        legs = {one: value for one, value in off.items() if one.startswith(LEGS) and not one.endswith("beta")}
        most = max(legs, key=lambda one: legs[one])
        print(f"{subject}, {word}: moments of the legs within {legs[most]:.1%} of the peak RMS ({most}), "
              f"{np.median(list(legs.values())):.1%} in the median")  # fmt: skip


def _rms(moments: Moments, name: str, theirs: dict[str, np.ndarray]) -> float:
    wanted = theirs[f"{name}_moment"]
    own = np.interp(theirs["time"], moments.times, moments.of(name))
    return float(np.sqrt(np.mean((own - wanted) ** 2)) / np.abs(wanted).max())


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    data = Path(os.environ.get("WARPMUSCLE_REFERENCE_DATA", "../shared/data"))
    measured_walk(data / "opensim_walk")
    muscles_and_joints(data / "inverse/static_optimization_92")
    for person in ("subject01", "subject02"):
        known_walk(data / "inverse/synthetic_walk", person)
