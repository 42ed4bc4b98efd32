"""Reads recorded signals: text tables, OpenSim storage files, HDF5 and C3D.

- Text (.csv, .tsv, .txt, .mot, .sto): a column a channel, and one called `time` (also `t`, `time_s`, `time (s)`, or
  with `ms`), unless the sampling rate is given; or Vicon's export, of which `Devices` are read.
- HDF5 (.h5, .hdf5): `values` (T, C) and `names` (C,), or a dataset (T,) a channel; `time` (T,), or `rate` as a dataset
  or an attribute of the file.
- C3D (.c3d), by the package `ezc3d`: its analog channels.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from warpmuscle.core import hdf5
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import SignalError
from warpmuscle.core.plain_text import number_of
from warpmuscle.synergy.c3d import read_c3d
from warpmuscle.synergy.signals import Signals, check_signals, choose_channels
from warpmuscle.synergy.tables import STORAGE, read_table
from warpmuscle.synergy.vicon import DEVICES, is_export, vicon_block

TEXT = (".csv", ".tsv", ".txt", *STORAGE)
HDF5 = (".h5", ".hdf5")
C3D = ".c3d"
GAP = 1.5  # of the usual step between samples; longer ones miss samples
_TIME = re.compile(r"(?:time|t)(?:[\s_]*[\[(]?(s|sec|seconds|ms)[\])]?)?", re.IGNORECASE)


@dataclass(frozen=True)
class _Clock:
    rate: float  # 1/s
    start: float  # s


def read_signals(
    path: str | Path, channels: Sequence[str] = (), rate: float | None = None, silent: bool = False
) -> Signals:
    """Read channels of a recording.

    Args:
        channels: names or patterns such as `env_*`; all channels if none.
        rate: samples a second, of a file without times; a column of times is not looked at then.
        silent: whether channels may be constant, which are refused else.

    Raises:
        SignalError: the file cannot be read, lacks a channel or times, or holds what `check_signals` refuses.
    """
    path = Path(path)
    if rate is not None and not (np.isfinite(rate) and rate > 0.0):
        raise SignalError(f"a sampling rate must be greater than 0, not {rate:g} 1/s", file=path)
    suffix = path.suffix.lower()
    if suffix in TEXT:
        return check_signals(_read_text(path, channels, rate), silent)
    if suffix in HDF5:
        return check_signals(_read_hdf5(path, channels, rate), silent)
    if suffix == C3D:
        return check_signals(_read_c3d(path, channels, rate), silent)
    raise SignalError(f"signals are read from {', '.join((*TEXT, *HDF5, C3D))}", file=path)


def _read_text(path: Path, channels: Sequence[str], rate: float | None) -> Signals:
    if is_export(path):
        return _read_vicon(path, channels, rate)
    table = read_table(path)
    times = [k for k, name in enumerate(table.names) if _TIME.fullmatch(name)]
    others = [k for k in range(len(table.names)) if k not in times[:1]]
    chosen = [others[k] for k in choose_channels([table.names[k] for k in others], channels, str(path))]
    if rate is None and not times:
        raise SignalError("has no column `time`; give the sampling rate", file=path, line=int(table.lines[0] - 1))
    values = table.columns(chosen)
    clock = _Clock(rate or 1.0, 0.0)
    if rate is None and len(values) > 1:
        unit = 1e-3 if (_TIME.fullmatch(table.names[times[0]]) or [""])[1] == "ms" else 1.0
        clock = _clock(unit * table.columns(times[:1])[:, 0], path, table.lines)
    names = tuple(table.names[k] for k in chosen)
    return Signals(names, clock.rate, values, str(path), clock.start, table.lines)


def _read_vicon(path: Path, channels: Sequence[str], rate: float | None) -> Signals:
    """The devices of Vicon's table, whose rate stands below their heading."""
    block = vicon_block(path, DEVICES)
    chosen = choose_channels(block.names, channels, str(path))
    names = tuple(block.names[k] for k in chosen)
    return Signals(names, rate or block.rate, block.values[:, chosen], str(path), 0.0, block.lines)


def _clock(time: Floats, path: Path, lines: Integers | None = None) -> _Clock:
    """Rate and start of times that increase by equal steps; raises SignalError if they do not."""

    def error(message: str, sample: int) -> SignalError:
        where = "" if lines is not None else f", in sample {sample + 1}"
        return SignalError(message + where, "time", path, int(lines[sample]) if lines is not None else 0)

    wrong = np.flatnonzero(~np.isfinite(time))
    if len(wrong):
        raise error(f"the value is {time[wrong[0]]}, not a finite number", int(wrong[0]))
    steps = np.diff(time)
    back = np.flatnonzero(steps <= 0.0)
    if len(back):
        at = int(back[0]) + 1
        twice = "; if times are rounded, give the sampling rate" if steps[at - 1] == 0.0 else ""
        raise error(f"times must increase, but {time[at]:g} s follows {time[at - 1]:g} s{twice}", at)
    usual = float(np.median(steps))
    gaps = np.flatnonzero(steps > GAP * usual)
    if len(gaps):
        at = int(gaps[0]) + 1
        raise error(f"samples are missing: {steps[at - 1]:g} s since the one before, usually {usual:g} s", at)
    return _Clock((len(time) - 1) / float(time[-1] - time[0]), float(time[0]))


def _read_hdf5(path: Path, channels: Sequence[str], rate: float | None) -> Signals:
    if path.is_file() and path.stat().st_size == 0:
        raise SignalError("is empty", file=path)
    if not path.exists():
        raise SignalError("there is no such file", file=path)
    with hdf5.opened(path, lambda message: SignalError(message, file=path), "cannot be used") as file:
        hdf5.check_contents(file)
        return _of_hdf5(file, path, channels, rate)


def _of_hdf5(file: Any, path: Path, channels: Sequence[str], rate: float | None) -> Signals:
    """The signals of an open file; raises SignalError, or ValueError and the like where it is of another kind."""
    if rate is None:
        given = file.attrs.get("rate", file["rate"][()] if "rate" in file else None)
        rate = None if given is None else float(given)
    if "values" in file:
        values = np.asarray(file["values"][()], np.float64)
        if "names" not in file or values.ndim != 2 or values.shape[1] != len(file["names"]):
            raise SignalError(f"`names` must name the columns of `values`, which has shape {values.shape}", file=path)
        names = hdf5.strings(file["names"])
    else:
        names = tuple(
            name for name in list(file)
            if isinstance(item := file[name], h5py.Dataset) and item.ndim == 1 and item.dtype.kind in "iuf"
            and name != "time"
        )  # fmt: skip
        if not names:
            raise SignalError("holds neither `values` nor a dataset a channel", file=path)
        for name in names:
            if len(file[name]) != len(file[names[0]]):
                what = f"has {number_of(len(file[name]), 'sample')}, but {names[0]!r} has {len(file[names[0]])}"
                raise SignalError(what, name, path)
        values = np.stack([np.asarray(file[name][()], np.float64) for name in names], axis=1)
    start = 0.0
    if rate is None:
        if "time" not in file:
            raise SignalError("has neither `time` nor `rate`; give the sampling rate", file=path)
        time = np.asarray(file["time"][()], np.float64)
        if time.shape != values.shape[:1]:
            raise SignalError(f"has {number_of(len(values), 'sample')}, but `time` has shape {time.shape}", file=path)
        if len(time) > 1:
            clock = _clock(time, path)
            rate, start = clock.rate, clock.start
    chosen = choose_channels(names, channels, str(path))
    return Signals(tuple(names[k] for k in chosen), rate or 1.0, values[:, chosen], str(path), start)


def _read_c3d(path: Path, channels: Sequence[str], rate: float | None) -> Signals:
    names, found, values = read_c3d(path)
    if rate is None and not (np.isfinite(found) and found > 0.0):
        raise SignalError(f"gives {found:g} 1/s as the rate of its analog channels; give the sampling rate", file=path)
    chosen = choose_channels(names, channels, str(path))
    return Signals(tuple(names[k] for k in chosen), rate or found, values[:, chosen], str(path))
