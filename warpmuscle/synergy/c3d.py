"""Analog channels, points and force plates of C3D files, read by the package `ezc3d` in a process of its own.

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
from typing import Any, NamedTuple

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
every = c3d["parameters"]
group = every[sys.argv[3]]
labels = []
for key in ["LABELS", *(f"LABELS{k}" for k in range(2, 99))]:
    labels += list(group[key]["value"]) if key in group else []
points = sys.argv[3] == "POINT"
values, rate = c3d["data"]["points"][:3] if points else c3d["data"]["analogs"][0], float(group["RATE"]["value"][0])
def of(name, key):
    return list(every[name][key]["value"]) if name in every and key in every[name] else []
plates = every["FORCE_PLATFORM"] if "FORCE_PLATFORM" in every else {}
more = {"plate_" + key: numpy.array(plates[key]["value"], float) for key in sys.argv[4:] if key in plates}
numpy.savez(
    sys.stdout.buffer, values=values, names=numpy.array(labels, str), rate=rate,
    unit=numpy.array(of("POINT", "UNITS")[:1], str), units=numpy.array(of("ANALOG", "UNITS"), str),
    screen=numpy.array(of("POINT", "X_SCREEN")[:1] + of("POINT", "Y_SCREEN")[:1], str), **more,
)
"""
_OF_PLATES = ("USED", "TYPE", "ZERO", "CORNERS", "ORIGIN", "CHANNEL", "CAL_MATRIX")


class C3dPlates(NamedTuple):
    """What a C3D file tells of P force plates, and its analog channels, as they are in the file.

    Attributes:
        rate: of samples, 1/s. samples: of a channel in a frame of points. names, units: (C,). values: (T, C).
        unit: of lengths. types: (P,) numbers. zero: first and last frame of the baseline, counted from 1.
        corners: (P, 4, 3). origins: (P, 3). channels: (n, P), counted from 1. matrices: (n, n, P), or of no size.
    """

    rate: float
    samples: int
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Floats
    unit: str
    types: tuple[int, ...]
    zero: tuple[int, int]
    corners: Floats
    origins: Floats
    channels: Floats
    matrices: Floats


class C3dRoom(NamedTuple):
    """How points of a C3D file lie in the room.

    Attributes:
        positions: (T, K, 3), NaN where one was not seen. corners: (P, 4, 3) of force plates, if there are some.
        screen: axes to the right and upwards when it is shown, such as `+X` and `+Z`; empty where it does not tell.
    """

    positions: Floats
    corners: Floats
    screen: tuple[str, str]


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
    _check_length(path, len(values), frames, samples)
    return names, float(content["rate"]), values


def _check_length(path: Path, count: int, frames: int, samples: int) -> None:
    """Raise SignalError if there are fewer samples of a channel than the header tells."""
    if samples > 0 and frames < MOST_FRAMES and count < frames * samples:
        raise SignalError(f"is truncated: holds {count // samples} of {number_of(frames, 'frame')}", file=path)


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
    return names, rate, values, _unit(content)


def read_room(path: Path) -> C3dRoom:
    """Points, corners of force plates and axes of the screen; raises SignalError, see `read_c3d`."""
    _, _, content = _read(path, "POINT", "points")
    values = np.asarray(content["values"], np.float64).transpose(2, 1, 0)
    used, corners = _count_of_plates(content.get("plate_USED")), _ordered(content.get("plate_CORNERS"), 12)
    screen = [str(word).strip().lower().lstrip("+") for word in content["screen"]]
    right, above = screen if len(screen) == 2 else ("", "")
    return C3dRoom(values, corners[:used].reshape(-1, 4, 3), (right, above))


def read_plates(path: Path) -> C3dPlates | None:
    """The force plates of a file; None if it has none.

    Raises:
        SignalError: see `read_c3d`; or a parameter of the plates is missing, or has another size than they need.
    """
    frames, samples, content = _read(path, "ANALOG", "analog channels")
    used = _count_of_plates(content.get("plate_USED"))
    if used < 1:
        return None
    values = np.asarray(content["values"], np.float64).T
    _check_length(path, len(values), frames, samples)
    found = {}
    for key, size in (("TYPE", 1), ("CORNERS", 12), ("ORIGIN", 3)):
        found[key] = _ordered(content.get(f"plate_{key}"), size)
        if len(found[key]) < used:
            raise SignalError(f"FORCE_PLATFORM:USED says {used}, but {key} is of {len(found[key])}", file=path)
    channels = np.asarray(content.get("plate_CHANNEL", np.zeros(0)), np.float64)
    channels = channels.reshape(len(channels) if channels.ndim else 1, -1) if channels.size else np.zeros((0, 0))
    if channels.shape[1] < used:
        raise SignalError(f"FORCE_PLATFORM:USED says {used}, but CHANNEL is of {channels.shape[1]}", file=path)
    zero = np.ravel(content.get("plate_ZERO", np.zeros(2)))
    matrices = np.asarray(content.get("plate_CAL_MATRIX", np.zeros(0)), np.float64)
    wrong = next((key for key, one in (*found.items(), ("CHANNEL", channels), ("CAL_MATRIX", matrices), ("ZERO", zero))
                  if not np.isfinite(one).all()), None)  # fmt: skip
    if wrong is not None:
        raise SignalError(f"FORCE_PLATFORM:{wrong} has something else than finite numbers", file=path)
    units = [str(word).strip() for word in content["units"]]
    names = tuple(str(name).strip() for name in content["names"])
    return C3dPlates(
        float(content["rate"]), samples, names, tuple(units + [""] * (values.shape[1] - len(units))), values,
        _unit(content), tuple(int(kind) for kind in found["TYPE"][:used, 0]),
        (int(zero[0]), int(zero[1])) if len(zero) > 1 else (0, 0), found["CORNERS"][:used].reshape(-1, 4, 3),
        found["ORIGIN"][:used], channels[:, :used], matrices,
    )  # fmt: skip


def _unit(content: dict[str, Any]) -> str:
    """Of lengths."""
    return str(content["unit"][0]).strip() if content["unit"].size else "mm"


def _count_of_plates(value: Any) -> int:
    """A number of plates; 0 of none."""
    number = np.ravel(value)[:1] if value is not None else np.zeros(0)
    return int(number[0]) if len(number) and np.isfinite(number[0]) else 0


def _ordered(value: Any, size: int) -> Floats:
    """Numbers (n, size) of an array whose first index is the fastest in the file, and whose last one is a plate's."""
    flat = np.ravel(np.zeros(0) if value is None else np.asarray(value, np.float64), order="F")
    return flat[: len(flat) // size * size].reshape(-1, size)


def _read(path: Path, group: str, what: str) -> tuple[int, int, dict[str, Any]]:
    """Frames and analog samples a frame by the header, and what the process found in a group."""
    if importlib.util.find_spec("ezc3d") is None:
        raise SignalError("C3D files need ezc3d: pip install 'warpmuscle[c3d]'", file=path)
    frames, samples = _header(path)
    most = MEMORY + BYTES_OF_ONE * path.stat().st_size  # what a damaged file asks for would take minutes to fill
    command = [sys.executable, "-P", "-c", _READ, str(path), str(most), group, *_OF_PLATES]
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
        size = path.stat().st_size
        check_size("table", size, lambda text: SignalError(text, file=path))
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
    data, samples = struct.unpack_from(f"{order}HH", begin, 16)
    if size < BLOCK * (data - 1):  # ezc3d would look for parameters behind its end, for minutes
        after = BLOCK * (data - 1)
        raise SignalError(
            f"is truncated: ends after {number_of(size, 'byte')}, its data begin after {after}", file=path
        )
    return last - first + 1, samples
