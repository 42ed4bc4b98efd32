"""How motions become groups and datasets of an HDF5 file, and are read again.

Motions of one body and one clock are arrays: `/replay/com` is (instance, time, xyz), and so are all others, extendable
along both first axes and packed by instance, so that one of many is read without the others. A motion that is alone,
and motions of different bodies, are a group each, `/replay/<k>`; so are all motions of files before version 3.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from warpmuscle.core import hdf5
from warpmuscle.core.errors import ArgumentError, ResultError
from warpmuscle.core.hdf5_writing import store
from warpmuscle.core.limits import check_size
from warpmuscle.results.motions import INSTANCE, TEXTS, Motions, absent, difference
from warpmuscle.results.recorded_quantities import INTEGER_QUANTITIES, NAMED, QUANTITIES, UNITS, dimension, has_place
from warpmuscle.results.recording import Recording

ABOUT = {
    "joint_names": "joints, breadth first from the root",
    "body_names": "the root, then the joints' children",
    "muscle_names": "muscles that were simulated",
    "coordinate_names": "of the root, then of the joints: degrees of freedom, and quaternions of balls",
    "speed_names": "of the root, then of the joints",
    "joint_angle_names": "of the root, then of the joints",
    "controller_value_names": "what a declared controller lets be recorded",
    "recorded_names": "quantities of the scene's own",
    "coordinate_units": "unit of each coordinate",
    "speed_units": "unit of each speed",
    "controller_value_units": "unit of each",
    "recorded_units": "unit of each quantity of the scene's own",
}
_AXIS = {name: axis for table in (NAMED, UNITS) for axis, name in table.items()}
KEPT = "quantities"  # attribute that names those which are there, if others are missing
OPTIONAL = ("joint_torque_desired",)  # which old files lack
MOST_ROOM, FEW_FRAMES = 4, 10_000  # times the frames of all motions that their arrays may have; and what is always well
MOST_ALONG = (2**31 - 1,)  # shape of a scale at most: readers look through all datasets for an unlimited one
CHUNK_BYTES = 2**20  # of a packed piece of an array, at most


def put_motions(file: Any, recordings: Sequence[Recording], names: Sequence[str] = ()) -> None:
    """Put motions into `/replay`, in the precision that they have, without the quantities that they lack.

    Args:
        names: of the motions, if they have any.

    Raises:
        ResultError: a value is not finite.
    """
    frames = [one.frames for one in recordings]
    if len(recordings) > 1 and fits(frames) and difference(recordings) is None:
        _put_arrays(file.create_group("replay", track_order=True), Motions.of(recordings, names))
        return
    for number, recording in enumerate(recordings):
        group = file.create_group(f"replay/{number}", track_order=True)
        if names and names[number]:
            group.attrs["name"] = names[number]
        _put_recording(group, recording)


def fits(frames: Sequence[int]) -> bool:
    """Whether motions of so many frames can be in one array: else most of it would be behind the ends of most."""
    room = len(frames) * max(frames, default=0)
    return room <= max(FEW_FRAMES, MOST_ROOM * sum(frames))


def has_arrays(group: Any) -> bool:
    """Whether a `/replay` has arrays over instances."""
    return "frames" in group


def load_recordings(group: Any, only: int | None = None) -> tuple[Recording, ...]:
    """All motions of a `/replay`, whichever way it keeps them; or one by its number, the others without frames.

    Raises:
        KeyError or ValueError: something is missing or does not fit.
    """
    count = len(group["frames"] if has_arrays(group) else group)
    if not has_arrays(group):
        return tuple(load_recording(group[str(number)], only in (None, number)) for number in range(count))
    if only is None:
        motions = load_motions(group)
        return tuple(motions.recording(number) for number in range(count))
    nothing = Recording.of({"time": np.zeros(0)}, *(_texts(group, name) for name in TEXTS), kept=())
    found = [nothing] * count
    if only < count:
        found[only] = load_motions(group, rows=slice(only, only + 1)).recording(0)
    return tuple(found)


def load_names(group: Any) -> tuple[str, ...]:
    """Names of the motions, empty if they have none."""
    if has_arrays(group):
        return hdf5.strings(group[INSTANCE]) if group[INSTANCE].dtype.kind == "O" else ()
    names = tuple(str(group[str(number)].attrs.get("name", "")) for number in range(len(group)))
    return names if any(names) else ()


def load_recording(group: Any, read: bool = True) -> Recording:
    """A motion that has a group of its own; without frames if its numbers are not to be read."""
    texts = [_texts(group, name) for name in TEXTS]
    if not read:
        return Recording.of({"time": np.zeros(0)}, *texts, kept=())
    kept = _kept(group)
    arrays = {name: hdf5.array(group, name) for name in QUANTITIES if name in group}
    _check_complete(group, arrays, kept)
    recording = Recording.of(arrays, *texts, kept=kept)
    if wrong := [name for name in recording.missing if kept is None or name in kept]:
        raise ValueError(f"{group.name}/{wrong[0]} has fewer frames than there are times")
    return recording


def load_motions(group: Any, quantities: Sequence[str] | None = None, rows: slice = slice(None)) -> Motions:
    """The arrays of a `/replay`, or those of some quantities that are there, and of some instances: these are read.

    Raises:
        KeyError or ValueError: something is missing or does not fit.
    """
    wanted = [name for name in QUANTITIES if name != "time" and name in group]
    texts = {name: _texts(group, name) for name in TEXTS}
    _check_complete(group, wanted, _kept(group))
    if quantities is not None:
        wanted = [name for name in wanted if name in quantities]
    frames = hdf5.array(group, "frames")
    if frames.ndim != 1 or frames.dtype.kind not in "iu":
        raise ValueError(f"{group.name}/frames holds no numbers of frames")
    check_size("objects", len(frames), ValueError)
    names = load_names(group)[rows]
    arrays = {name: hdf5.member(group, name)[rows] for name in wanted}
    return Motions(hdf5.array(group, "time"), frames[rows].astype(np.int64), names, arrays, texts)


def append(group: Any, added: Motions) -> None:
    """Put further motions behind those of a `/replay` with arrays.

    Raises:
        ArgumentError: they are of another body or clock, or lack a quantity. ResultError: a value is not finite.
    """
    time, count = group["time"][()], len(group["frames"])
    for name in TEXTS:
        if _texts(group, name) != added.texts[name]:
            raise ArgumentError(f"the added motions are of another body: their {name} differ from those of the file")
    common = min(len(time), len(added.time))
    if not np.array_equal(time[:common], added.time[:common]):
        raise ArgumentError("the added motions were recorded at other times than those of the file")
    if bool(added.names) != bool(load_names(group)):
        raise ArgumentError("either all motions of a file have names, or none has")
    if not fits([*group["frames"][()], *added.frames]):
        raise ArgumentError("motions of such different lengths are not kept as arrays; `write` them to another file")
    longest, total = max(len(time), len(added.time)), count + len(added)
    for name in [name for name in QUANTITIES if name in group and name != "time"]:
        _check_finite(group, name, added)
        dataset = group[name]
        dataset.resize((total, longest, *dataset.shape[2:]))
        dataset[count:, : len(added.time)] = added[name]
    for name, values in {"frames": added.frames, INSTANCE: added.names or np.arange(count, total)}.items():
        group[name].resize((total,))
        group[name][count:] = values
    group["time"].resize((longest,))
    group["time"][common:] = (added.time if len(added.time) > common else time)[common:]


def _put_arrays(group: Any, motions: Motions) -> None:
    """Fill an empty `/replay`; raises ResultError if a value is not finite."""
    _put_texts(group, motions.texts)
    instances: Any = tuple(motions.names) or np.arange(len(motions))
    about = QUANTITIES["time"]
    store(group, INSTANCE, instances, axes=INSTANCE, description="names or numbers of the instances",
          maxshape=MOST_ALONG)  # fmt: skip
    store(group, "frames", motions.frames, axes=INSTANCE, description="how many frames the instance has",
          maxshape=(None,))  # fmt: skip
    store(group, "time", motions.time, about.units, "frame", description=about.description, at=about.at,
          maxshape=MOST_ALONG)  # fmt: skip
    for name, array in motions.arrays.items():
        _check_finite(group, name, motions)
        about = QUANTITIES[name]
        values = array.astype(np.int32, copy=False) if name in INTEGER_QUANTITIES else array
        store(group, name, values, about.units, ", ".join((INSTANCE, *about.axes)), description=about.description,
              finite=False, at=about.at, maxshape=(None, None, *array.shape[2:]), chunks=_chunk(values),
              fillvalue=absent(name))  # fmt: skip
    _put_kept(group, motions.missing)
    _put_scales(group, {name: (INSTANCE, *QUANTITIES[name].axes) for name in motions.arrays} | {"frames": (INSTANCE,)})


def _put_recording(group: Any, recording: Recording) -> None:
    texts, gone, axes = {name: getattr(recording, name) for name in TEXTS}, recording.missing, {}
    _put_texts(group, texts)
    for name, about in QUANTITIES.items():
        if name in gone or not has_place(name, texts):
            continue
        array = recording[name]
        array = array.astype(np.int32, copy=False) if name in INTEGER_QUANTITIES else array
        store(group, name, array, about.units, ", ".join(about.axes), description=about.description, at=about.at)
        axes[name] = about.axes
    _put_kept(group, gone)
    _put_scales(group, axes)


def _put_kept(group: Any, missing: Sequence[str]) -> None:
    """Say which quantities are there, if others are missing."""
    if missing:
        group.attrs[KEPT] = ", ".join(name for name in QUANTITIES if name in group)


def _kept(group: Any) -> list[str] | None:
    """Names of the quantities that motions were written with, None if with all."""
    return str(group.attrs[KEPT]).split(", ") if KEPT in group.attrs else None


def _check_complete(group: Any, present: Iterable[str], kept: Sequence[str] | None) -> None:
    """Raise ValueError if a quantity that was written is not there."""
    have, optional = set(present), OPTIONAL if kept is None else ()
    texts = {name: _texts(group, name) for name in TEXTS}
    for name in QUANTITIES if kept is None else kept:
        if name not in (*have, "time") and name not in optional and has_place(name, texts):
            raise ValueError(f"{group.name}/{name} is missing")


def _put_texts(group: Any, texts: Any) -> None:
    for name, description in ABOUT.items():
        if texts[name] or name in ("joint_names", "body_names"):
            store(group, name, texts[name], axes=_AXIS[name], description=description)


def _put_scales(group: Any, axes: dict[str, tuple[str, ...]]) -> None:
    """Attach to the axes of motions what stands along them: the time, and names, as HDF5 dimension scales."""
    scales: dict[str, Any] = {}
    axes = axes | {name: (axis,) for table in (NAMED, UNITS) for axis, name in table.items() if name in group}
    for axis in dict.fromkeys(axis for names in axes.values() for axis in names):
        scale = dimension(axis)
        if scale not in group:
            store(group, scale, tuple(axis.split()), axes=axis, description="components")
        scales[scale] = group[scale].id
        h5py.h5ds.set_scale(scales[scale], scale.encode())
    for name, along in axes.items():
        dataset = group[name].id
        for number, axis in enumerate(along):
            if name != dimension(axis):
                h5py.h5ds.attach_scale(dataset, scales[dimension(axis)], number)


def _texts(group: Any, name: str) -> tuple[str, ...]:
    return hdf5.strings(group[name]) if name in group else ()


def _chunk(array: NDArray[Any]) -> tuple[int, ...]:
    """Shape of what is packed together: an instance over as many frames as fit."""
    a_frame = max(array[:1, :1].nbytes, 1)
    return (1, max(min(array.shape[1], CHUNK_BYTES // a_frame), 1), *(max(size, 1) for size in array.shape[2:]))


def _check_finite(group: Any, name: str, motions: Motions) -> None:
    """Raise ResultError if an instance has a number that is not finite before its end."""
    array = motions[name]
    if array.dtype.kind == "f":
        good = np.isfinite(array).all(axis=tuple(range(2, array.ndim)))
        wrong = ~good & (np.arange(array.shape[1]) < motions.frames[:, None])
        if wrong.any():
            row, frame = np.argwhere(wrong)[0]
            raise ResultError(
                f"{group.name}/{name} holds a value that is not finite (instance {row}, frame {frame}); nothing was "
                "written"
            )
