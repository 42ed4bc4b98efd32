"""Results of inverse dynamics, static optimisation and joint reactions as files: HDF5, and OpenSim's `.sto`.

An HDF5 file has a group a trial under `trials`, whose arrays have units and named axes, as netCDF has them:
`xarray.open_dataset("result.h5", group="trials/walk1", engine="h5netcdf")` reads one. What stands along an axis is the
array of its name.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from warpmuscle.core.errors import ArgumentError, ResultError
from warpmuscle.core.files import replace_files, replace_result
from warpmuscle.core.hdf5_writing import store
from warpmuscle.formats.sto import storage_text
from warpmuscle.inverse.activations import Activations
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import Moments
from warpmuscle.inverse.named_array import NamedArray
from warpmuscle.inverse.reactions.joint_reactions import JointReactions
from warpmuscle.inverse.recordings import measured
from warpmuscle.inverse.recordings.measured import Measured
from warpmuscle.inverse.recordings.result import motions_result
from warpmuscle.inverse.tracking.output import tracked_arrays, tracked_storages
from warpmuscle.inverse.tracking.tracked import Tracked
from warpmuscle.inverse.trial import Coordinates
from warpmuscle.results.layout import put
from warpmuscle.results.recording import Recording
from warpmuscle.results.result import INVERSE_FORMAT

TIMES = {"time": "of the frames", "tracking_time": "between windows of tracking", "window_time": "when these begin"}


@dataclass(frozen=True)
class Trial:
    """All that was found of a trial; what was not asked for is None."""

    name: str
    coordinates: Coordinates
    moments: Moments | None = None
    activations: Activations | None = None
    reactions: JointReactions | None = None
    tracked: Tracked | None = None
    recording: Recording | None = None  # the same as a motion of the model's scene
    measured: Measured | None = None  # markers and forces on bodies


def write_result(
    path: str | Path, trials: Sequence[Trial], about: Mapping[str, str], body: BodyModel | None = None
) -> None:
    """Write trials into an HDF5 file, whole or not at all.

    Args:
        about: attributes of the file, such as the model and the options.
        body: the model, with which recordings of the trials are written so that other commands read them as motions.

    Raises:
        ResultError: two trials have one name, a value is not finite, or the file cannot be written.
    """
    names = [trial.name for trial in trials]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ResultError(f"two trials are called {twice!r}; rename one of their files")
    content = io.BytesIO()
    with h5py.File(content, "w", track_order=True) as file:
        motions = {trial.name: trial.recording for trial in trials if trial.recording is not None}
        if body is not None and motions:
            runs = {f"{trial.name} followed": trial.tracked for trial in trials if trial.tracked is not None}
            motions |= {name: run.motion for name, run in runs.items() if run.motion is not None}
            grounds = [run.ground for run in runs.values() if run.ground is not None]
            scene = grounds[0].scene if grounds else body.scene
            put(file, motions_result(body, scene, motions, about.get("command", "")), INVERSE_FORMAT)
        else:
            file.attrs["format"] = INVERSE_FORMAT
        for key, value in about.items():
            file.attrs[key] = value
        group = file.create_group("trials", track_order=True)
        for trial in trials:
            _put(group.create_group(trial.name.replace("/", "_"), track_order=True), trial)
    replace_result(path, content.getvalue())


def _put(group: Any, trial: Trial) -> None:
    """Store a trial, its axes as dimension scales."""
    for axis, labels in _labels(trial).items():
        store(group, axis, tuple(labels), axes=axis, description=f"names along the axis {axis}")
        group[axis].make_scale(axis)
    times = {"time": _times(trial)}
    if trial.tracked is not None:
        times |= {"tracking_time": trial.tracked.times, "window_time": trial.tracked.times[:-1]}
    for name, values in times.items():
        store(group, name, values, "s", name, description=TIMES[name])
        group[name].make_scale(name)
    for one in [*_arrays(trial), *(tracked_arrays(trial.tracked) if trial.tracked is not None else [])]:
        axes = (one.over, *one.axes)
        store(group, one.name, one.values, one.units, ",".join(axes), description=one.description)
        for place, axis in enumerate(axes):
            group[one.name].dims[place].attach_scale(group[axis])
    if trial.measured is not None and np.array_equal(trial.measured.times, times["time"]):
        measured.put(group, trial.measured)


def _times(trial: Trial) -> Any:
    found = next((one for one in (trial.moments, trial.activations, trial.reactions) if one is not None), None)
    return trial.coordinates.times if found is None else found.times


def _labels(trial: Trial) -> dict[str, tuple[str, ...]]:
    """What stands along the axes."""
    found: dict[str, tuple[str, ...]] = {}
    moments = trial.moments or (trial.activations.moments if trial.activations is not None else None)
    if moments is not None:
        found["coordinate"] = moments.names
    if trial.tracked is not None:
        found |= {"coordinate": trial.tracked.names, "muscle": trial.tracked.muscles}
        if trial.tracked.ground is not None:
            found |= {"foot": ("left", "right"), "ground_axis": ("x", "y", "z")}
    if trial.activations is not None:
        found["muscle"] = trial.activations.muscles
    if trial.reactions is not None:
        found |= {"joint": trial.reactions.joints, "axis": ("x", "y", "z")}
    return found


def _arrays(trial: Trial) -> list[NamedArray]:
    """All arrays of a trial; units of generalised forces are `N m` of turns and `N` of shifts."""
    found, generalised = [], "N m or N"
    moments = trial.moments or (trial.activations.moments if trial.activations is not None else None)
    if moments is not None:
        known = trial.coordinates
        values = np.stack(
            [
                np.interp(moments.times, known.times, known.of(name)) if name in known.names else 0.0 * moments.times
                for name in moments.names
            ],
            axis=1,
        )
        found.append(NamedArray("coordinate_value", ("coordinate",), "rad or m", values, "as recorded, not filtered"))
        found.append(NamedArray("moment", ("coordinate",), generalised, moments.values, "generalised force needed"))
    one = trial.activations
    if one is not None:
        found += [
            NamedArray("activation", ("muscle",), "1", one.activation, "of static optimisation"),
            NamedArray("muscle_force", ("muscle",), "N", one.force, "along the tendon"),
            NamedArray("fibre_length", ("muscle",), "m", one.fibre_length, "of fibres"),
            NamedArray(
                "fibre_velocity", ("muscle",), "m/s", one.fibre_velocity, "of fibres, positive when lengthening"
            ),
            NamedArray("muscle_power", ("muscle",), "W", one.power, "upon the skeleton, positive while shortening"),
            NamedArray("muscle_work", ("muscle",), "J", one.work, "since the first frame"),
            NamedArray("reserve", ("coordinate",), generalised, one.reserve, "needed beside the muscles"),
            NamedArray("iterations", (), "1", one.iterations, "-1 where moments were not balanced"),
        ]
    reaction = trial.reactions
    if reaction is not None:
        where = "; ".join(
            f"{joint} on {body} in {frame}"
            for joint, body, frame in zip(reaction.joints, reaction.bodies, reaction.frames, strict=True)
        )
        found += [
            NamedArray("reaction_force", ("joint", "axis"), "N", reaction.force, where),
            NamedArray("reaction_moment", ("joint", "axis"), "N m", reaction.moment, "about the point"),
            NamedArray("reaction_point", ("joint", "axis"), "m", reaction.point, "where it acts, in the same axes"),
        ]
    return found


def write_storages(folder: str | Path, trials: Sequence[Trial]) -> list[Path]:
    """Write all of the trials as `.sto` files with OpenSim's names into a folder, which is made if it is not there.

    Raises:
        SceneError: a file cannot be written; none is left behind then.
    """
    contents = {}
    for trial in trials:
        for ending, (title, columns) in _storages(trial).items():
            times = columns.pop("time")
            table = np.column_stack([times, *columns.values()])
            if not np.isfinite(table).all():
                raise ArgumentError(f"{trial.name}: a number of {title} is not finite; nothing was written")
            contents[Path(folder) / f"{trial.name}_{ending}.sto"] = storage_text(title, ["time", *columns], table)
    with contextlib.suppress(OSError):  # what cannot be made is told of by the first file in it
        Path(folder).mkdir(exist_ok=True)
    replace_files(contents)
    return list(contents)


def _storages(trial: Trial) -> dict[str, tuple[str, dict[str, Any]]]:
    """Titles and columns of files by the ending of their names."""
    found: dict[str, tuple[str, dict[str, Any]]] = {}
    if trial.moments is not None:
        one = trial.moments
        words = [
            f"{name}_{'moment' if unit == 'N m' else 'force'}" for name, unit in zip(one.names, one.units, strict=True)
        ]
        columns = {"time": one.times} | dict(zip(words, one.values.T, strict=True))
        found["InverseDynamics"] = "Inverse Dynamics Generalized Forces", columns
    if trial.activations is not None:
        acts = trial.activations
        reserves = {f"{name}_reserve": values for name, values in zip(acts.moments.names, acts.reserve.T, strict=True)}
        for word, title, values in (
            ("activation", "Static Optimization", acts.activation), ("force", "ModelForces", acts.force),
        ):  # fmt: skip
            columns = {"time": acts.times} | dict(zip(acts.muscles, values.T, strict=True))
            found[f"StaticOptimization_{word}"] = title, columns | (reserves if word == "force" else {})
    if trial.reactions is not None:
        columns = {"time": trial.reactions.times} | trial.reactions.columns()
        found["JointReaction_ReactionLoads"] = "Joint Reaction Loads", columns
    return found | (tracked_storages(trial.tracked) if trial.tracked is not None else {})
