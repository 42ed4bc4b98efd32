"""Motions of many instances in a result file, without the rest of it: read by parts, and added to."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import h5py

from warpmuscle.core.arguments import as_kind, as_path, as_text, as_texts, in_words
from warpmuscle.core.errors import ArgumentError, ResultError
from warpmuscle.core.files import replace_result
from warpmuscle.results.checks import check_recording
from warpmuscle.results.layout import FORMAT_VERSION
from warpmuscle.results.motion_layout import append, has_arrays, load_motions, load_names, load_recording, put_motions
from warpmuscle.results.motions import Motions
from warpmuscle.results.partial_motion import checked_quantities
from warpmuscle.results.recorded_quantities import QUANTITIES
from warpmuscle.results.recording import Recording
from warpmuscle.results.result import opened

ALL = slice(None)


def read_motions(
    path: str | Path, quantities: Sequence[str] | None = None, instances: slice = ALL, run: str | None = None
) -> Motions:
    """Read the motions of a result file; only the chosen quantities and instances are read.

    Args:
        quantities: names of those that are wanted; all that are there by default.
        instances: which ones, such as `slice(0, 20)`.
        run: name of a run, for the file of a sweep only.

    Raises:
        ResultError: as `read`, or the file holds no motions, or lacks a quantity.
        ArgumentError: its motions are not of one body and clock.
    """
    file = as_path(path, "path", error=ResultError)
    as_kind(slice, instances, "instances")
    if instances.step is not None and not (isinstance(instances.step, int) and instances.step > 0):
        raise ArgumentError(f"instances must go forwards, not by {instances.step}")
    wanted = None if quantities is None else checked_quantities(quantities)
    if run is not None:
        as_text(run, "run", error=ResultError)
    with opened(file, run) as group:
        if "replay" not in group:
            raise ResultError(f"{file}: no motions; `write` a result that has some")
        replay = group["replay"]
        if has_arrays(replay):
            _check_there(file, wanted, [name for name in QUANTITIES if name in replay])
            return load_motions(replay, wanted, instances)
        numbers = range(len(replay))[instances]
        names = load_names(replay)[instances]
        recordings = [load_recording(replay[str(number)]) for number in numbers]
    try:
        found = Motions.of(recordings, names)
    except ArgumentError as error:
        raise ArgumentError(f"{file}: {error}") from None
    _check_there(file, wanted, list(found.arrays))
    arrays = {name: array for name, array in found.arrays.items() if wanted is None or name in wanted}
    return replace(found, arrays=arrays)


def append_motions(path: str | Path, recordings: Sequence[Recording], names: Sequence[str] = ()) -> None:
    """Append motions of the same character to a result file, which is replaced once the new one is complete.

    Args:
        names: of the added ones, if those of the file have names.

    Raises:
        ResultError: the file cannot be read or written, holds no motions, or a value is not finite.
        ArgumentError: the motions are of another body, or were recorded at other times.
    """
    file = as_path(path, "path", error=ResultError)
    if not (isinstance(recordings, list | tuple) and recordings) or not all(
        isinstance(one, Recording) for one in recordings
    ):
        raise ArgumentError(f"recordings must be a list of one or more recordings, not {in_words(recordings)}")
    added = Motions.of(recordings, as_texts(names, "names"))
    for number, recording in enumerate(recordings):
        try:
            check_recording(recording, f"motion {number}: ")
        except ValueError as error:
            raise ResultError(f"{error}; nothing was written") from None
    with opened(file) as group:
        if "replay" not in group:
            raise ResultError(f"{file}: no motions to add to; `write` a result that has some")
        replay = group["replay"]
        if has_arrays(replay):
            load_motions(replay, rows=slice(0, 0))  # whether it is sound
        kept = None if has_arrays(replay) else [load_recording(replay[str(number)]) for number in range(len(replay))]
        had = load_names(replay)
    memory = io.BytesIO(file.read_bytes())
    with h5py.File(memory, "r+", track_order=True) as content:
        content.attrs["format_version"] = FORMAT_VERSION
        if kept is None:
            append(content["replay"], added)
        else:
            if bool(had) != bool(added.names):
                raise ArgumentError("either all motions of a file have names, or none has")
            every = [*kept, *recordings]
            Motions.of(every)  # they have to be of one body and clock
            del content["replay"]
            put_motions(content, every, (*had, *added.names))
    replace_result(file, memory.getvalue())


def _check_there(file: Path, wanted: Sequence[str] | None, there: Sequence[str]) -> None:
    """Raise ResultError if the motions of a file lack a quantity that is wanted."""
    if gone := [name for name in wanted or () if name not in (*there, "time")]:
        those = ", ".join(name for name in there if name != "time")
        raise ResultError(f"{file}: its motions have no {', '.join(gone)}; there are {those}")
