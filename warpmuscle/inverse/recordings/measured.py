"""What was measured of a trial: markers beside those of the model, and forces on bodies; in memory, and in a file.

World axes of scenes in memory; in a file ground axes of OpenSim's models, as all else of a trial has there.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.core import hdf5
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ResultError
from warpmuscle.core.hdf5_writing import store
from warpmuscle.core.sequences import nearest_rows
from warpmuscle.formats.external_loads import TO_OPENSIM
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import Prepared
from warpmuscle.inverse.kinematics import Kinematics
from warpmuscle.results.result import INVERSE_FORMAT, opened_file

GROUND_AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Measured:
    """Markers and forces on bodies in F frames of a trial."""

    times: Floats  # (F,) s
    markers: tuple[str, ...]  # (K,)
    position: Floats  # (F, K, 3) m, as measured; NaN where one was not seen
    modelled: Floats  # (F, K, 3) m, those of the model
    bodies: tuple[str, ...]  # (P,) that the forces act on
    force: Floats  # (F, P, 3) N
    point: Floats  # (F, P, 3) m


def measured_of(body: BodyModel, trials: Prepared, number: int, fitted: Kinematics | None) -> Measured | None:
    """What was measured of one of some trials, in the frames that are wanted of it; None if nothing was.

    Args:
        fitted: the markers that its motion was found from, if it was.
    """
    times = np.asarray(trials.times[number])
    rows = slice(trials.starts[number], trials.starts[number + 1])
    loads = trials.loads
    acting = [k for k in range(len(loads.body)) if np.any(loads.force[rows, k])]
    if fitted is None and not acting:
        return None
    names: tuple[str, ...] = ()
    position = modelled = np.zeros((len(times), 0, 3))
    if fitted is not None:
        nearest = nearest_rows(fitted.coordinates.times, times)
        names, position = fitted.markers, fitted.measured[nearest] @ TO_OPENSIM
        modelled = fitted.modelled(nearest) @ TO_OPENSIM
    bodies = tuple(body.topology.bodies[loads.body[k]] for k in acting)
    return Measured(
        times, names, position, modelled, bodies, loads.force[rows][:, acting], loads.point[rows][:, acting]
    )


def put(group: Any, measured: Measured) -> None:
    """Store what was measured of a trial in its group, whose axis of time is there."""
    for axis, labels in (("marker", measured.markers), ("plate", measured.bodies), ("ground_axis", GROUND_AXES)):
        if axis not in group:
            store(group, axis, tuple(labels), axes=axis, description=f"names along the axis {axis}")
            group[axis].make_scale(axis)
    arrays = {
        "marker_measured": ("marker", measured.position, "m", "of markers; not a number where one was not seen"),
        "marker_modelled": ("marker", measured.modelled, "m", "of the model's markers"),
        "plate_force": ("plate", measured.force, "N", "on a body"),
        "plate_point": ("plate", measured.point, "m", "where the force acts"),
    }
    for name, (axis, values, unit, text) in arrays.items():
        if values.shape[1]:
            axes = ("time", axis, "ground_axis")
            store(group, name, values @ TO_OPENSIM.T, unit, ",".join(axes), description=text, finite=False)
            for place, scale in enumerate(axes):
                group[name].dims[place].attach_scale(group[scale])


def read_measured(path: str | Path, trial: str = "") -> Measured | None:
    """What a file of `warpmuscle inverse` says was measured of a trial; None of other files, and where nothing was.

    Args:
        trial: its name; it may be left out where the file has one trial only.

    Raises:
        ResultError: the file is damaged.
    """
    with opened_file(Path(path)) as file:
        if file.attrs.get("format") != INVERSE_FORMAT or "trials" not in file:
            return None
        trials = hdf5.member(file, "trials")
        names = list(trials)
        name = trial.replace("/", "_") if trial else names[0] if len(names) == 1 else ""
        if name not in names:
            return None
        group = hdf5.member(trials, name)
        if "marker_measured" not in group and "plate_force" not in group:
            return None
        times = _numbers(path, group, "time", (-1,))
        markers, position = _named(path, group, "marker", "marker_measured", len(times))
        _, modelled = _named(path, group, "marker", "marker_modelled", len(times))
        bodies, force = _named(path, group, "plate", "plate_force", len(times))
        _, point = _named(path, group, "plate", "plate_point", len(times))
    if np.isnan(force).any() or np.isnan(point).any():
        raise ResultError(f"{path}: a force of {name!r} is not a number")
    return Measured(times, markers, position, modelled, bodies, force, point)


def _named(path: str | Path, group: Any, axis: str, name: str, frames: int) -> tuple[tuple[str, ...], Floats]:
    """Names along an axis, and vectors (F, K, 3) of them in world axes of scenes; none where there is no such array."""
    if name not in group:
        return (), np.zeros((frames, 0, 3))
    labels = hdf5.strings(hdf5.member(group, axis))
    return labels, _numbers(path, group, name, (frames, len(labels), 3)) @ TO_OPENSIM


def _numbers(path: str | Path, group: Any, name: str, shape: tuple[int, ...]) -> Floats:
    found = hdf5.checked_array(group, name)
    if not isinstance(found, np.ndarray) or found.dtype.kind != "f":
        raise ResultError(f"{path}: {group.name}/{name} holds no numbers")
    if len(found.shape) != len(shape) or (shape != (-1,) and found.shape != shape):
        raise ResultError(f"{path}: {group.name}/{name} has the shape {found.shape}, not {shape}")
    if np.isinf(found).any():
        raise ResultError(f"{path}: {group.name}/{name} holds an infinite number")
    return np.asarray(found, dtype=np.float64)
