"""Runs the commands of a case in this process, and finds what is wrong with what they did."""

from __future__ import annotations

import contextlib
import hashlib
import io
import math
import os
import re
import sys
import time
import tomllib
import traceback
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

COMPILING = 120.0  # s, for a case that may compile a kernel
OPEN = 1.0e-3  # m, by which points that a constraint holds together may be apart where a run has ended well
HANG = 20.0  # s, on a machine that has a core for every process that wants one
SECRET = "the secret of another file"
ESCAPES = re.compile(r"[\x00-\x08\x0b-\x1f\x7f]")
NOT_A_NUMBER = re.compile(r"(?<![\w.'\"/-])[-+]?(?:nan|inf|infinity)(?![\w'\"/.(])", re.IGNORECASE)
NAN_ALLOWED = ("terms", "sigma", "searches", "restart", "marker_measured")  # of paths of datasets that may hold nan
GOES_ON = (
    ".h5",
    ".journal",
    ".sweep",
    "adaptation.toml",
)  # what a search leaves that fails after it began, so that it can go on


class NotCompiled(BaseException):
    """A case needs a kernel that would have to be compiled for many seconds."""


@dataclass
class Verdict:
    """What became of a case."""

    complaints: list[str] = field(default_factory=list)
    refused: bool = False  # with an error of one line
    skipped: bool = False  # for want of a compiled kernel
    seconds: float = 0.0
    said: str = ""  # errors and notes


@dataclass(frozen=True)
class Outcome:
    """What a command did."""

    code: int
    out: str
    log: str
    crash: str
    seconds: float


def judged(commands: list[list[str]], folder: Path, inside: Path, longest: float = HANG) -> Verdict:
    """Run the commands in a folder, and judge them.

    Args:
        inside: a folder around it, in which no other file may change.
        longest: s, that a command may take.
    """
    verdict = Verdict()
    for command in commands:
        before, around = _contents(folder), _contents(inside, folder)
        try:
            outcome = run(command, folder)
        except NotCompiled:
            verdict.skipped = True
            return verdict
        verdict.seconds += outcome.seconds
        verdict.refused |= outcome.code == 2
        verdict.said += outcome.log
        shown = " ".join(["warpmuscle", *command])
        for complaint in _complaints(outcome, longest):
            verdict.complaints.append(f"{shown}: {complaint}")
        after = _contents(folder)
        new = sorted(path for path in after if after[path] != before.get(path))
        if _contents(inside, folder) != around:
            verdict.complaints.append(f"{shown}: a file outside of its folder")
        for complaint in _wrong_files(folder, new, outcome.code, command):
            verdict.complaints.append(f"{shown}: {complaint}")
        if gone := [path for path in before if path not in after and not path.endswith(".journal")]:
            verdict.complaints.append(f"{shown}: removed {', '.join(gone)}")
        if outcome.code != 0:
            break
    return verdict


def run(command: list[str], folder: Path) -> Outcome:
    """Run a command in a folder as the command line does, all that it prints caught."""
    from warpmuscle.cli.program import main

    begin, crash, code = time.monotonic(), "", 0
    earlier, arguments = Path.cwd(), sys.argv
    os.chdir(folder)
    sys.argv = ["warpmuscle", *command]
    with _caught() as (out, log):
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("always")
                warnings.filterwarnings("ignore", category=DeprecationWarning)
                warnings.filterwarnings("ignore", category=ResourceWarning)
                main()
        except SystemExit as error:
            code = error.code if isinstance(error.code, int) else 1 if error.code else 0
        except NotCompiled:
            raise
        except BaseException:
            code, crash = 1, traceback.format_exc()
        finally:
            os.chdir(earlier)
            sys.argv = arguments
    return Outcome(code, out(), log(), crash, time.monotonic() - begin)


def crowding() -> float:
    """How many processes want each core of this machine, at least one."""
    return max(os.getloadavg()[0] / (os.cpu_count() or 1), 1.0)


@contextlib.contextmanager
def _caught() -> Iterator[Any]:
    """Catch what is printed, by Python or by libraries."""
    import tempfile

    files = [tempfile.TemporaryFile() for _ in range(2)]  # noqa: SIM115
    saved = [os.dup(1), os.dup(2)]
    streams = sys.stdout, sys.stderr
    for number, file in enumerate(files, start=1):
        os.dup2(file.fileno(), number)
    sys.stdout, sys.stderr = (
        io.TextIOWrapper(io.FileIO(number, "wb", closefd=False), "utf-8", "backslashreplace", write_through=True)
        for number in (1, 2)
    )

    def reader(file: Any) -> Any:
        def read() -> str:
            with file:
                file.seek(0)
                return str(file.read().decode("utf-8", "replace"))

        return read

    try:
        yield [reader(file) for file in files]
    finally:
        for number, handle in enumerate(saved, start=1):
            os.dup2(handle, number)
            os.close(handle)
        sys.stdout, sys.stderr = streams


def _complaints(outcome: Outcome, longest: float = HANG) -> Iterator[str]:
    """What is wrong with exit code, time and text."""
    both = outcome.out + outcome.log
    if outcome.crash:
        yield f"traceback: {outcome.crash.strip().splitlines()[-1][:300]}\n{outcome.crash}"
    elif "Traceback (most recent call last)" in both:
        yield f"prints a traceback: {both[-2000:]}"
    elif outcome.code not in (0, 2) and not (outcome.code == 1 and "\nmissed: " in f"\n{outcome.log}"):
        yield f"exit code {outcome.code}: {outcome.log.strip()[-300:]}"
    if outcome.seconds > longest * crowding():
        yield f"took {outcome.seconds:.1f} s"
    if found := re.search(r"^.*\b\w*Warning: .*$", outcome.log, re.MULTILINE):
        yield f"warns: {found[0][:300]}"
    if outcome.code == 2 and "Usage:" not in outcome.log:
        lines = [line for line in outcome.log.splitlines() if line.strip()]
        errors = [line for line in lines if line.startswith("error:")]
        if len(errors) != 1 or lines[-1] != errors[0]:
            yield f"not one line of error: {outcome.log.strip()[-500:]!r}"
        elif len(errors[0]) > 2000:
            yield f"an error of {len(errors[0])} characters: {errors[0][:200]!r}"
    if found := ESCAPES.search(both):
        yield f"prints the control character {found[0]!r}: {both[max(found.start() - 80, 0) : found.end() + 40]!r}"
    if outcome.code == 0 and (found := NOT_A_NUMBER.search(outcome.out)):
        yield f"prints {found[0]!r}: {outcome.out[max(found.start() - 80, 0) : found.end() + 40]!r}"
    if SECRET in both:
        yield "shows the content of another file"


def _contents(folder: Path, without: Path | None = None) -> dict[str, str]:
    """A digest of every file below a folder, by path."""
    found = {}
    for path in folder.rglob("*"):
        if without is not None and path.is_relative_to(without):
            continue
        name = str(path.relative_to(folder))
        if path.is_symlink() or not path.is_file() or path.stat().st_size > 2**27:
            found[name] = "no file"
        else:
            found[name] = hashlib.md5(path.read_bytes()).hexdigest()
    return found


def _wrong_files(folder: Path, new: list[str], code: int, command: list[str]) -> Iterator[str]:
    """What is wrong with the files that a command has written."""
    goes_on = command[0] in ("optimize", "sweep", "study", "adaptation", "learn")
    for name in new:
        path = folder / name
        if path.is_dir():
            continue
        if re.search(r"(^|/)\.(?!z(array|attrs|group|metadata)$)", name):  # a store of Zarr is a folder of such files
            yield f"left {name} behind"
        elif code != 0 and not (goes_on and any(part in name for part in GOES_ON)):
            yield f"wrote {name} although it failed"
        else:
            try:
                yield from (f"{name}: {complaint}" for complaint in _wrong_file(path))
            except Exception as error:
                yield f"{name} cannot be read: {error!r}"


def _wrong_file(path: Path) -> Iterator[str]:
    if path.stat().st_size == 0 and path.name != "lock":
        yield "is empty"
    elif path.suffix == ".h5":
        yield from _wrong_hdf5(path)
    elif path.suffix in (".csv", ".mot", ".sto", ".rbs", ".sbc", ".rs", ".xml"):
        if found := NOT_A_NUMBER.search(path.read_text()):
            yield f"holds {found[0]}"
    elif path.suffix == ".toml":
        yield from _wrong_numbers(tomllib.loads(path.read_text()), "")
    if path.suffix in (".html", ".toml", ".csv") and SECRET in path.read_text(errors="replace"):
        yield "shows the content of another file"


def _wrong_hdf5(path: Path) -> Iterator[str]:
    import h5py

    wrong: list[str] = []

    def look(name: str, item: Any) -> None:
        for key, value in item.attrs.items():
            if isinstance(value, float | np.floating) and not math.isfinite(value):
                wrong.append(f"{name}@{key} is {value}")
        if isinstance(item, h5py.Dataset) and item.dtype.kind == "f" and item.size:
            finite = np.isfinite(item[()])
            if not finite.all() and not (any(part in name for part in NAN_ALLOWED) and not np.isinf(item[()]).any()):
                wrong.append(f"{name} is not finite throughout")

    with h5py.File(path) as file:
        look("", file)
        file.visititems(look)
        wrong.extend(_open_loops(file))
    yield from wrong


def _open_loops(file: Any) -> Iterator[str]:
    """Points of a recorded body that a constraint holds together, and that are apart though nothing was said."""
    from warpmuscle.core.pose import rotate
    from warpmuscle.formats.toml import loads

    if "replay/0" not in file or "scene" not in file:
        return
    motion, scene = file["replay/0"], loads(file["scene"][()].decode())
    if not len(motion["time"]) or motion["time"][-1] < scene.duration - 2.0 * scene.time_step - np.diff(
        motion["time"]
    ).max(initial=0.0):
        return  # it has ended early, and says why
    names = [name.decode() for name in motion["body_names"][()]]
    poses = {name: (motion["body_position"][:, k], motion["body_orientation"][:, k]) for k, name in enumerate(names)}
    for name, one in scene.character.constraints.items():
        if one.type != "point" or not {one.body, one.other_body} <= set(poses):
            continue
        ends = [
            place + rotate(turn, np.broadcast_to(np.array(at, dtype=float), place.shape))
            for (place, turn), at in ((poses[one.body], one.position), (poses[one.other_body], one.other_position))
        ]
        apart = float(np.linalg.norm(ends[0] - ends[1], axis=1).max())
        if apart > OPEN:
            yield f"constraint {name} is open by {apart:.3g} m"


def _wrong_numbers(data: Any, key: str) -> Iterator[str]:
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for name, value in items:
        yield from _wrong_numbers(value, f"{key}.{name}")
    if isinstance(data, float) and not math.isfinite(data):
        yield f"{key} is {data}"
