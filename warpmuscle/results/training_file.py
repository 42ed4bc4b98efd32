"""The file that a training goes on from after a kill: a result beside all that the learner knows."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from warpmuscle.core import hdf5
from warpmuscle.core.errors import ResultError, SceneError
from warpmuscle.core.files import replace_file
from warpmuscle.results.checks import check_result
from warpmuscle.results.layout import put
from warpmuscle.results.records import Result
from warpmuscle.results.result import load, opened

SUFFIX = ".training"
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
    try:
        replace_file(path, memory.getvalue())
    except SceneError as error:
        raise ResultError(f"{path}: {error.message}") from None


def read_training(path: Path) -> tuple[Result, Arrays]:
    """A result with the state of its training.

    Raises:
        ResultError: as `result.read`, or the file holds no training.
    """
    with opened(path) as group:
        result = load(group)
        check_result(result)
        if result.learned is None or "state" not in group:
            raise ResultError(f"{path}: holds no training to go on with")
        state = {name: np.asarray(array) for name, array in hdf5.arrays(hdf5.member(group, "state")).items()}
        if wrong := [name for name, array in state.items() if array.dtype.kind not in "iufb"]:
            raise ValueError(f"state/{wrong[0]} holds no numbers")
        return result, state
