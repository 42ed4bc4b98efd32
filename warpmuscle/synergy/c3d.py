"""Analog channels and points of C3D files, read by the package `ezc3d` in a process of its own.

The library trusts the sizes that a file gives, so that a damaged file may end its process; hence the other one. And it
reads a truncated file as a short one; hence what it read is compared with the number of frames in the file's header.
"""

from __future__ import annotations

import importlib.util
import io
import os
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.core.archive import DamagedArchive, read_arrays
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SignalError
from warpmuscle.core.files import check_regular
from warpmuscle.core.limits import check_size
from warpmuscle.core.plain_text import number_of

BLOCK = 512  # bytes
MIPS = 86  # processor type of files with the most significant byte first
MOST_FRAMES = 65535  # that the header can tell
PATIENCE = 300.0  # s
MEMORY, BYTES_OF_ONE = 2**31, 100  # bytes that the process may have, and besides for each byte of the file
_READ = """
import sys
try:
    import resource
    resource.setrlimit(resource.RLIMIT_AS, (int(sys.argv[2]), int(sys.argv[2])))
except (ImportError, ValueError, OSError):
    pass
import ezc3d, numpy
c3d = ezc3d.c3d(sys.argv[1])
group = c3d["parameters"][sys.argv[3]]
labels = []
for key in ["LABELS", *(f"LABELS{k}" for k in range(2, 99))]:
    labels += list(group[key]["value"]) if key in group else []
points = sys.argv[3] == "POINT"
values, rate = c3d["data"]["points"][:3] if points else c3d["data"]["analogs"][0], float(group["RATE"]["value"][0])
unit = list(group["UNITS"]["value"])[:1] if points and "UNITS" in group else []
numpy.savez(sys.stdout.buffer, values=values, names=numpy.array(labels, str), rate=rate, unit=numpy.array(unit, str))
"""


def read_c3d(path: Path) -> tuple[tuple[str, ...], float, Floats]:
    """Names (C,), sampling rate, 1/s, and values (T, C) of the analog channels.

    Raises:
        SignalError: ezc3d is not installed, or the file cannot be read, is no C3D file, damaged or truncated.
    """
    frames, samples, content = _read(path, "ANALOG", "analog channels")
    values = np.asarray(content["values"], np.float64).T
    names = tuple(str(name).strip() for name in content["names"])
    if not values.shape[1] or len(names) != values.shape[1]:
        raise SignalError(
            f"holds {number_of(values.shape[1], 'analog channel')} with {number_of(len(names), 'name')}", file=path
        )
    if samples > 0 and frames < MOST_FRAMES and len(values) < frames * samples:
        raise SignalError(f"is truncated: holds {len(values) // samples} of {number_of(frames, 'frame')}", file=path)
    return names, float(content["rate"]), values


def read_points(path: Path) -> tuple[tuple[str, ...], float, Floats, str]:
    """Names (K,), sampling rate, 1/s, and positions (T, K, 3) of the points, NaN where one was not seen; their unit.

    Raises:
        SignalError: see `read_c3d`.
    """
    frames, _, content = _read(path, "POINT", "points")
    values = np.asarray(content["values"], np.float64).transpose(2, 1, 0)
    names = tuple(str(name).strip() for name in content["names"])[: values.shape[1]]
    if not names or len(names) != values.shape[1]:
        raise SignalError(
            f"holds {number_of(values.shape[1], 'point')} with {number_of(len(names), 'name')}", file=path
        )
    if frames < MOST_FRAMES and len(values) < frames:
        raise SignalError(f"is truncated: holds {len(values)} of {number_of(frames, 'frame')}", file=path)
    rate = float(content["rate"])
    if not rate > 0.0:
        raise SignalError(f"its points have a rate of {rate:g} Hz", file=path)
    unit = str(content["unit"][0]).strip() if content["unit"].size else "mm"
    return names, rate, values, unit


def _read(path: Path, group: str, what: str) -> tuple[int, int, dict[str, Any]]:
    """Frames and analog samples a frame by the header, and what the process found in a group."""
    if importlib.util.find_spec("ezc3d") is None:
        raise SignalError("C3D files need ezc3d: pip install 'warpmuscle[c3d]'", file=path)
    frames, samples = _header(path)
    most = MEMORY + BYTES_OF_ONE * path.stat().st_size  # what a damaged file asks for would take minutes to fill
    command = [sys.executable, "-P", "-c", _READ, str(path), str(most), group]
    alone = os.environ | {"OPENBLAS_NUM_THREADS": "1"}  # of which each takes memory
    try:
        done = subprocess.run(command, capture_output=True, timeout=PATIENCE, env=alone)
    except subprocess.TimeoutExpired:
        raise SignalError(f"cannot be read as C3D within {PATIENCE:g} s; it may be damaged", file=path) from None
    if done.returncode != 0:
        raise SignalError(f"cannot be read as C3D; it is damaged, or holds no {what}", file=path)
    try:
        return frames, samples, read_arrays(io.BytesIO(done.stdout))
    except DamagedArchive:
        raise SignalError("cannot be read as C3D; it is damaged", file=path) from None


def _header(path: Path) -> tuple[int, int]:
    """Frames of the file, and samples of each analog channel in a frame; raises SignalError if it is no C3D file."""
    try:
        check_regular(path)
        check_size("table", path.stat().st_size, lambda text: SignalError(text, file=path))
        with path.open("rb") as file:
            begin = file.read(BLOCK)
            file.seek(BLOCK * (max(begin[0], 1) - 1) if begin else 0)
            parameters = file.read(4)
    except FileNotFoundError:
        raise SignalError("there is no such file", file=path) from None
    except OSError as error:
        raise SignalError(f"cannot be read: {error.strerror or error}", file=path) from None
    if not begin:
        raise SignalError("is empty", file=path)
    if len(begin) < BLOCK or begin[1] != 0x50 or len(parameters) < 4:
        raise SignalError("is not a C3D file", file=path)
    order = ">" if parameters[3] == MIPS else "<"
    first, last = struct.unpack_from(f"{order}HH", begin, 6)
    (samples,) = struct.unpack_from(f"{order}H", begin, 18)
    return last - first + 1, samples
