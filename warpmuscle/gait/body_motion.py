"""What a walk does as a whole: how its centre of mass moves, how the ground drives it, how pelvis and trunk turn."""

from __future__ import annotations

import math

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.gait.centre_of_pressure import centre_of_pressure, travel
from warpmuscle.gait.cycles import PERCENT, Strides, over_strides
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.gait.ground_force import horizontal_forces, vertical_forces
from warpmuscle.gait.joint_moments import from_people
from warpmuscle.gait.likeness import dimensionless_speed, leg_length
from warpmuscle.gait.measures import heading
from warpmuscle.gait.pelvis_and_trunk import turn_curves
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.people import van_der_zee
from warpmuscle.scene.people.pinzone import PELVIS

Found = dict[str, float | None]
# Sideways and vertical range of people's centre of mass, cm: mean and SD at two speeds, m/s (Orendurff et al. 2004,
# J. Rehabil. Res. Dev. 41:829). Between them it changes evenly, here. Means and the vertical SD are as four texts that
# cite the paper have them, to 0.1 cm; second decimals and the SD of the sway were not checked at the source.
SWAY = ((0.7, 6.99, 1.34), (1.6, 3.85, 1.41))
BOBBING = ((0.7, 2.74, 0.52), (1.6, 4.83, 0.92))
FORCE_AT_SPEED = "ground force from that at this speed"
CADENCE_AT_SPEED = "cadence from that at this speed"


def body_measures(
    recording: Recording, scene: Scene, cycles: dict[str, Strides], speed: float, cadence: float | None, normal: bool
) -> Found:
    """Measures of the body's motion and of how the ground drives it; those beside people's only of a normal walk.

    Args:
        speed: m/s. cadence: steps/min, if known.
    """
    found = centre_of_mass(recording, scene, cycles)
    if normal:
        found["sway from people"] = _beside(found.get("sway of the centre of mass"), SWAY, speed)
        found["bobbing from people"] = _beside(found.get("bobbing of the centre of mass"), BOBBING, speed)
        found |= _at_speed(recording, scene, cycles, speed, cadence)
    travels = [travel(centre) for centre in centre_of_pressure(recording, scene).values()]
    stances = np.concatenate(travels)
    found["travel of the centre of pressure"] = float(stances.mean()) if len(stances) else None
    for name, curves in turn_curves(recording, scene, cycles).items():
        found[f"{name.lower()}, range"] = float(np.mean([np.ptp(curve) for curve in curves]))
        if name in PELVIS and not name.endswith("tilt"):  # its mean depends on where markers are
            found[f"{name.lower()} from people"] = from_people(name, curves) if normal else None
    return found


def centre_of_mass(recording: Recording, scene: Scene, cycles: dict[str, Strides]) -> Found:
    """How far the centre of mass moves to and fro and up and down, cm, and extremes of the fore-aft force, weights.

    Those are of the mean curve over a side's strides, as of the vertical force.
    """
    turned, forces = heading(recording), horizontal_forces(recording, scene)
    ahead = np.stack([np.sin(turned), np.cos(turned)], axis=1)
    sway, bob, braking, driving = [], [], [], []
    for side in SIDES:
        along = []
        for begin, end in cycles[side]:
            inside = (recording.time >= begin) & (recording.time <= end)
            if np.count_nonzero(inside) < 3:
                continue
            way = np.mean(ahead[inside], axis=0)
            way /= np.linalg.norm(way)
            place = recording.com[inside].astype(float)
            across = place[:, 0] * way[1] - place[:, 2] * way[0]
            across -= np.linspace(across[0], across[-1], len(across))  # walking aside is no sway
            sway.append(np.ptp(across))
            bob.append(np.ptp(place[:, 1]))
            along.append(over_strides(recording.time, forces[side], [(begin, end)])[0] @ way)
        if along:
            braking.append(-np.mean(along, axis=0).min())
            driving.append(np.mean(along, axis=0).max())
    if not sway:
        return {}
    return {
        "sway of the centre of mass": 100.0 * float(np.mean(sway)),
        "bobbing of the centre of mass": 100.0 * float(np.mean(bob)),
        "maximum braking force": float(np.mean(braking)),
        "maximum driving force": float(np.mean(driving)),
    }


def measured_force(relative: float) -> Floats | None:
    """Vertical force of people (101,), body weights, at a dimensionless speed; None where none was measured.

    Between two measured speeds it is interpolated.
    """
    speeds = [dimensionless_speed(speed, van_der_zee.LEG_LENGTH) for speed in van_der_zee.SPEEDS]
    if not speeds[0] <= relative <= speeds[-1]:
        return None
    columns = np.array(van_der_zee.FORCE).T
    means = np.array([np.interp(relative, speeds, column) for column in columns])
    return np.asarray(np.interp(PERCENT, np.linspace(0.0, 100.0, len(means)), means))


def _at_speed(
    recording: Recording, scene: Scene, cycles: dict[str, Strides], speed: float, cadence: float | None
) -> Found:
    """How far vertical force, body weights, and cadence, %, are from those measured at the same speed."""
    length = leg_length(scene)
    relative = dimensionless_speed(speed, length)
    people = measured_force(relative)
    if people is None:
        return {FORCE_AT_SPEED: None, CADENCE_AT_SPEED: None}
    forces = vertical_forces(recording, scene)
    curves = [over_strides(recording.time, forces[side], cycles[side]).mean(axis=0) for side in SIDES]
    speeds = [dimensionless_speed(one, van_der_zee.LEG_LENGTH) for one in van_der_zee.SPEEDS]
    usual = float(np.interp(relative, speeds, van_der_zee.STRIDE_FREQUENCY))
    own = None if cadence is None else cadence / 120.0 * math.sqrt(length / van_der_zee.LEG_LENGTH)
    return {
        FORCE_AT_SPEED: float(np.mean([np.abs(curve - people)[:-1].mean() for curve in curves])),
        CADENCE_AT_SPEED: None if own is None else 100.0 * (own / usual - 1.0),
    }


def _beside(value: float | None, people: tuple[tuple[float, float, float], ...], speed: float) -> float | None:
    """Distance of a value from people's at a speed, in their SD; None at speeds that were not measured."""
    speeds, means, deviations = np.array(people).T
    if value is None or not speeds[0] <= speed <= speeds[-1]:
        return None
    return float(abs(value - np.interp(speed, speeds, means)) / np.interp(speed, speeds, deviations))
