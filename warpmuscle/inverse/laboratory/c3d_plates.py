"""Loads from the force plates of a C3D file: from analog channels to forces, places and moments in ground axes."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import SignalError
from warpmuscle.core.plain_text import number_of
from warpmuscle.inverse.laboratory.axes import axes_of_c3d, to_ground
from warpmuscle.inverse.laboratory.wrench import CALIBRATED, CHANNELS, plate_axes, pressure_point, surface_wrench
from warpmuscle.inverse.trial import Loads, Plate, TrialWarning, of_file
from warpmuscle.markers.files import UNITS
from warpmuscle.synergy.c3d import C3dPlates, read_plates

LOADED = 20.0  # N through the surface, from which on a plate is stood upon
OFF = 0.25  # m beyond its edge, from which on a centre of pressure cannot be one
UPRIGHT = 0.5  # cosine of the angle between its normal and up, below which a plate is a wall
QUANTITIES = {1: "FFFLLM", 2: "FFFMMM", 3: "FFFFFFFF", 4: "FFFMMM"}  # of the channels of a kind
FORCES = {"n": 1.0, "kn": 1000.0}
MOMENTS = {prefix + length: FORCES[prefix] * UNITS[length] for prefix in FORCES for length in UNITS}


def loads_of_c3d(path: str | Path, up: str | None = None, forward: str | None = None) -> Loads | None:
    """Forces of the plates of a C3D file, whose bodies are not told, from 0 s on; None if it has no plates.

    Forces are those on the foot: of a plate that tells what the foot does to it, signs are turned. Where less than 20 N
    go through a plate, its force acts where it did at the nearest time, with all of its moment.

    Args:
        up, forward: axes of the file that these are; by default found by plates and points, see `axes_of_c3d`.

    Warns:
        TrialWarning: units that are taken for others, a baseline under load, a centre of pressure off its plate.

    Raises:
        SignalError: the file cannot be read, or a plate is of a kind that is not known, or lacks what its kind needs.
    """
    path = Path(path)
    found = read_plates(path)
    if found is None:
        return None
    if not (np.isfinite(found.rate) and found.rate > 0.0):
        raise SignalError(f"gives {found.rate:g} 1/s as the rate of its analog channels", file=path)
    if not len(found.values):
        raise SignalError("has no samples of its force plates", file=path)
    up, forward = axes_of_c3d(path, up, forward)
    turn = to_ground(up, forward)
    times = np.arange(len(found.values)) / found.rate
    plates = tuple(_plate(path, found, number, turn) for number in range(len(found.types)))
    with of_file(path):
        return Loads(times, plates)


def _plate(path: Path, found: C3dPlates, number: int, turn: Floats) -> Plate:
    """A plate in ground axes."""
    name, length = f"plate {number + 1}", _length_unit(path, found.unit)
    kind = found.types[number]
    if kind not in CHANNELS:
        raise SignalError(f"{name} is of TYPE {kind}; those of 1 to 4 are read. Give its forces by --loads", file=path)
    signals = _signals(path, found, number, name)
    corners = length * found.corners[number]
    axes = plate_axes(corners)
    if not np.isfinite(axes).all():
        raise SignalError(f"the CORNERS of {name} do not span a rectangle", file=path)
    force, moment = surface_wrench(kind, signals, length * found.origins[number])
    if not (np.isfinite(force).all() and np.isfinite(moment).all()):
        raise SignalError(f"a channel of {name} is not a finite number", file=path)
    sign = _sign(path, name, force, axes, turn[1])
    arm = np.column_stack([pressure_point(force, moment, LOADED), np.zeros(len(force))])
    _check_places(path, name, arm, force, corners)
    free = moment - np.cross(arm, force)
    point = corners.mean(axis=0) + arm @ axes
    ground = turn.T
    return Plate(name, None, sign * (force @ axes @ ground), point @ ground, sign * (free @ axes @ ground))


def _signals(path: Path, found: C3dPlates, number: int, name: str) -> Floats:
    """Channels (T, n) of a plate without their baseline, in N, N m and m."""
    kind, count = found.types[number], CHANNELS[found.types[number]]
    if len(found.channels) < count:
        raise SignalError(
            f"{name}, of TYPE {kind}, needs {number_of(count, 'channel')}, CHANNEL has {len(found.channels)}", file=path
        )
    chosen = found.channels[:count, number].astype(int) - 1
    wrong = chosen[(chosen < 0) | (chosen >= found.values.shape[1])]
    if len(wrong):
        raise SignalError(
            f"channel {wrong[0] + 1} of {name} is not there: there are "
            f"{number_of(found.values.shape[1], 'analog channel')}",
            file=path,
        )
    signals = found.values[:, chosen]
    matrix: Floats = np.eye(count)
    if kind == CALIBRATED:
        if found.matrices.shape[:2] != (count, count) or found.matrices.size < (number + 1) * count * count:
            raise SignalError(f"{name}, of TYPE {kind}, needs a CAL_MATRIX of {count} x {count}", file=path)
        matrix = found.matrices.reshape(count, count, -1)[:, :, number]
    factors = _factors(path, found, chosen, kind, name)
    return np.asarray(_without_baseline(path, found, signals, matrix, factors, name) @ matrix.T * factors)


def _without_baseline(
    path: Path, found: C3dPlates, signals: Floats, matrix: Floats, factors: Floats, name: str
) -> Floats:
    """Signals less their mean over the frames that the file names for it, unless a foot stands on the plate then."""
    first, last = found.zero
    frames = len(signals) // max(found.samples, 1)
    if not 1 <= first <= last <= frames:
        return signals
    part = slice((first - 1) * found.samples, last * found.samples)
    offset = signals[part].mean(axis=0)
    unloaded = offset @ matrix.T * factors
    through = unloaded[4:].sum() if len(unloaded) == CHANNELS[3] else unloaded[2]
    if abs(through) > LOADED:
        warnings.warn(
            f"{path}: {abs(through):.0f} N act on {name} in frames {first} to {last}, which FORCE_PLATFORM:ZERO gives "
            "for its baseline: none is taken off, so that an offset of the plate would stay in its forces",
            TrialWarning, stacklevel=5,
        )  # fmt: skip
        return signals
    return np.asarray(signals - offset)


def _factors(path: Path, found: C3dPlates, chosen: Integers, kind: int, name: str) -> Floats:
    """What channels (n,) are to be multiplied by for N, N m and m; of a plate with a matrix, after it."""
    length = _length_unit(path, found.unit)
    tables = {"F": (FORCES, 1.0), "L": (UNITS, length), "M": (MOMENTS, length)}
    factors, unknown = [], []
    for what, channel in zip(QUANTITIES[kind], chosen, strict=True):
        known, usual = tables[what]
        unit = re.sub(r"[^a-z]", "", found.units[channel].lower())
        if unit and unit not in known:
            unknown.append(found.units[channel])
        factors.append(known.get(unit, usual))
    if unknown and kind != CALIBRATED:
        warnings.warn(
            f"{path}: {name} has channels in {unknown[0]!r}, which are taken for N and N {found.unit}: if they are "
            "not, moments of all joints are wrong",
            TrialWarning, stacklevel=5,
        )  # fmt: skip
    return np.array(factors)


def _length_unit(path: Path, unit: str) -> float:
    """Metres in the unit of lengths."""
    if unit not in UNITS:
        raise SignalError(f"unit {unit!r} of its points is not known; use {', '.join(UNITS)}", file=path)
    return UNITS[unit]


def _sign(path: Path, name: str, force: Floats, axes: Floats, above: Floats) -> float:
    """1 of a plate that tells the forces on the foot, -1 of one that tells those of the foot on it."""
    upwards = float(axes[2] @ above)
    through = force[np.abs(force[:, 2]) > LOADED, 2]
    if not len(through):
        return 1.0
    if abs(upwards) < UPRIGHT:
        warnings.warn(
            f"{path}: {name} stands upright, so that it does not tell whether its forces are those on the body: they "
            "are taken for that",
            TrialWarning, stacklevel=5,
        )  # fmt: skip
        return 1.0
    return 1.0 if float(through.sum()) * upwards >= 0.0 else -1.0


def _check_places(path: Path, name: str, arm: Floats, force: Floats, corners: Floats) -> None:
    """Warn if a plate is loaded far beyond its edges for most of the time."""
    loaded = np.abs(force[:, 2]) > LOADED
    if not loaded.any():
        return
    first, second, third, _ = corners
    half = 0.5 * np.array([np.linalg.norm(first - second), np.linalg.norm(second - third)])
    beyond = (np.abs(arm[loaded, :2]) - half).max(axis=1)
    if (far := float(np.median(beyond))) > OFF:
        warnings.warn(
            f"{path}: the centre of pressure of {name} lies {far:.3g} m beyond its edge: the unit of its moments in "
            "ANALOG:UNITS, its ORIGIN or the order of its CHANNEL is wrong, and so are moments of all joints",
            TrialWarning, stacklevel=5,
        )  # fmt: skip
