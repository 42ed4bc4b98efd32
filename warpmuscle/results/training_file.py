"""The file that a training goes on from after a kill: a result beside all that the learner knows."""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from warpmuscle.core import hdf5
from warpmuscle.core.errors import ResultError
from warpmuscle.core.files import replace_result
from warpmuscle.results.checks import check_result
from warpmuscle.results.layout import put
from warpmuscle.results.records import Result
from warpmuscle.results.result import load, opened

if sys.platform != "win32":
    import fcntl

SUFFIX, LOCK = ".training", ".lock"
Arrays = dict[str, NDArray[Any]]


def training_path(path: Path) -> Path:
    """Where the training of a policy's file goes on from."""
    return path.with_name(path.name + SUFFIX)


def write_training(path: Path, result: Result, state: Arrays) -> None:
    """Write a result with the state of its training, by names of arrays.

    Raises:
        ResultError: the file cannot be written; the one that was there stays then.
    """
    memory = io.BytesIO()
    with h5py.File(memory, "w", track_order=True) as file:
        put(file, result)
        group = file.create_group("state", track_order=True)
        for name, array in state.items():
            group.create_dataset(name, data=array)
        file.attrs["digest"] = _digest(file)
    replace_result(path, memory.getvalue())


def read_training(path: Path) -> tuple[Result, Arrays]:
    """A result with the state of its training.

    Raises:
        ResultError: as `result.read`, the file holds no training, or something else than was written.
    """
    with opened(path) as group:
        result = load(group)
        check_result(result)
        if result.learned is None or "state" not in group:
            raise ResultError(f"{path}: holds no training to go on with")
        if "digest" in group.attrs and str(group.attrs["digest"]) != _digest(group):  # older files have none
            raise ResultError(f"{path}: damaged training: it does not hold what was written; begin anew, or --from it")
        state = {name: np.asarray(array) for name, array in hdf5.arrays(hdf5.member(group, "state")).items()}
        if wrong := [name for name, array in state.items() if array.dtype.kind not in "iufb"]:
            raise ValueError(f"state/{wrong[0]} holds no numbers")
        return result, state


def check_belongs(path: Path, training: Result) -> None:
    """ResultError if a policy's file was learnt in another scene, or from another seed, than the training beside it."""
    if not path.exists():
        return
    with opened(path) as group:
        result = load(group)
    if result.learned is None or (result.scene, result.seed) != (training.scene, training.seed):
        raise ResultError(
            f"{path}: is of another scene or seed than {training_path(path)}, which would replace it; move one of them"
        )


@contextlib.contextmanager
def locked(path: Path) -> Iterator[None]:
    """While a training writes a file, no other process trains into it; raises ResultError if one does already."""
    if sys.platform == "win32":
        yield
        return
    place = training_path(path).with_name(training_path(path).name + LOCK)
    try:
        file = os.open(place, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
    except OSError:  # what cannot be written is told where the file itself is written
        yield
        return
    try:
        with contextlib.suppress(OSError):  # a file system without locks
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise ResultError(f"{path}: another process is at work on this training") from None
        try:
            yield
        finally:
            with contextlib.suppress(OSError):
                place.unlink()
    finally:
        os.close(file)


def _digest(group: Any) -> str:
    """SHA-256 of all names and values in a file."""
    found = hashlib.sha256()
    names: list[str] = []
    group.visititems(lambda name, _: names.append(name))
    for name in sorted(names):
        one = group[name]
        values = {f"{name}@{key}": one.attrs[key] for key in sorted(one.attrs)}
        if isinstance(one, h5py.Dataset):
            values[name] = one[()]
        for place, value in values.items():
            array = np.asarray(value)
            content = repr(array.tolist()).encode() if array.dtype.kind == "O" else array.tobytes()
            found.update(f"{place} {array.dtype} {array.shape}\n".encode() + content)
    return found.hexdigest()
