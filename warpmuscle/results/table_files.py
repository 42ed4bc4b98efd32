"""Tables and motions as files that other programs read: Parquet, Zarr, netCDF, comma-separated values."""

from __future__ import annotations

import contextlib
import secrets
import shutil
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warpmuscle.core.errors import Error, ResultError
from warpmuscle.core.files import replacing, unwritable
from warpmuscle.results.partial_motion import motion_of
from warpmuscle.results.result import read
from warpmuscle.results.sweeps import is_sweep, read_sweep

if TYPE_CHECKING:
    import pandas
    import xarray

FLAT = (".parquet", ".csv")  # rows and columns
LABELLED = (".zarr", ".nc")  # arrays with names along their axes
ENDINGS = (*FLAT, *LABELLED)
_NEEDED = {".parquet": "pyarrow", ".zarr": "zarr", ".nc": "h5netcdf"}
_MARKS = ("zarr.json", ".zgroup")  # what a Zarr store has in its folder


def check_ending(path: Path) -> str:
    """The ending of a table's file, lower case; raises Error if it is none of `ENDINGS`, or its package is missing."""
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise Error(f"{path}: a table ends in {', '.join(ENDINGS[:-1])} or {ENDINGS[-1]}")
    if (package := _NEEDED.get(ending)) is not None:
        try:
            import_module(package)
        except ImportError:
            raise Error(f"{path}: this needs {package}: pip install 'warpmuscle[tables]'") from None
    return ending


def write_rows(table: pandas.DataFrame, path: Path) -> None:
    """Write rows and columns as `.parquet` or `.csv`, whole or not at all.

    Raises:
        Error: another ending, or a package is missing. SceneError: the file cannot be written.
    """
    ending = check_ending(path)
    _check_folder(path)
    with replacing(path, ending) as temporary:
        if ending == ".parquet":
            table.to_parquet(temporary, engine="pyarrow")
        else:
            table.to_csv(temporary)


def write_arrays(arrays: xarray.Dataset, path: Path) -> None:
    """Write labelled arrays as `.zarr` or `.nc`, whole or not at all; a Zarr store takes the place of another one only.

    Raises:
        Error: another ending, or a package is missing. ResultError: something else stands at a store's place, or it
            cannot be written. SceneError: the file cannot be written.
    """
    ending = check_ending(path)
    _check_folder(path)
    if ending == ".nc":
        with replacing(path, ".nc") as temporary:
            arrays.to_netcdf(temporary, engine="h5netcdf")
        return
    if path.is_symlink() or (path.exists() and not any((path / mark).is_file() for mark in _MARKS)):
        raise ResultError(f"{path} is there and no Zarr store: choose another name")
    _write_store(arrays, path)


def _check_folder(path: Path) -> None:
    """Raise ResultError if the folder of a file is not there: some packages would make it."""
    if not path.parent.is_dir():
        raise ResultError(f"{path}: {unwritable(FileNotFoundError())}")


def _write_store(arrays: Any, path: Path) -> None:
    """Write a Zarr store beside its place, then put it there."""
    token = secrets.token_hex(4)
    temporary, former = (path.with_name(f".{path.name}.{token}{end}") for end in (".new", ".old"))
    try:
        arrays.to_zarr(temporary, mode="w-", zarr_format=2)  # which all readers know, texts in it too
        if path.exists():
            path.rename(former)
        temporary.rename(path)
    except OSError as error:
        with contextlib.suppress(OSError):
            if former.exists() and not path.exists():
                former.rename(path)
        raise ResultError(f"{path}: {unwritable(error)}") from None
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
        if path.exists():  # else the former store, which could not be put back, is all that there is
            shutil.rmtree(former, ignore_errors=True)


def is_table(result: Path, output: Path, run: str | None, candidates: bool) -> bool:
    """Whether the output is a table, by its ending; those of comma-separated motions are columns for OpenSim."""
    ending = output.suffix.lower()
    if ending == ".csv":
        return candidates or (run is None and is_sweep(result))
    if ending in (*FLAT, *LABELLED):
        return True
    if candidates:
        raise Error(f"{output}: candidates are written as .parquet, .csv, .zarr or .nc")
    return False


def write_table(result: Path, output: Path, run: str | None, replay: int, candidates: bool) -> None:
    """Write what a file has: runs of a sweep, its candidates or those of a search, else one motion.

    Raises:
        Error: a package is missing. ResultError: the file cannot be read, or has no such thing.
    """
    flat = check_ending(output) in FLAT
    found: Any
    if run is None and is_sweep(result):
        sweep = read_sweep(result)
        found = sweep.to_dataframe(candidates) if flat else sweep.to_xarray(candidates)
    elif candidates:
        table = read(result, run).to_dataframe()
        found = table if flat else table.to_xarray()
    else:
        motion = motion_of(read(result, run, replay=replay), str(result), replay)
        found = motion.to_dataframe() if flat else motion.to_xarray()
    (write_rows if flat else write_arrays)(found, output)
