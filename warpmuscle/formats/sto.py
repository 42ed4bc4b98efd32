"""Writes motions as OpenSim storage (`.mot`, `.sto`) or comma-separated values: a header, names, a row a frame.

A `.mot` holds all degrees of freedom (see `results.degrees_of_freedom`), angles in degrees and lengths in metres, a
`.sto` activations and forces of the muscles, a `.csv` both. OpenSim plays the motion of a scene made of one of its
models on that model.
"""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.files import replace_file
from warpmuscle.core.plain_text import one_line
from warpmuscle.results.degrees_of_freedom import degrees_of_freedom
from warpmuscle.results.motion_of_scene import check_motion_of
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import at_start

SUFFIXES = (".mot", ".sto", ".csv")
TAB = "\t"


def write(motion: Recording, scene: Scene, path: str | Path) -> None:
    """Write a motion of a scene, whole or not at all; the file's suffix says what and how.

    Raises:
        Error: another suffix, no muscles for a `.sto`, a motion of another character, one that does not come to
            finite numbers, or the file cannot be written.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise Error(f"{path.name!r}: a motion is written as {', '.join(SUFFIXES)}")
    if suffix == ".sto" and not motion.muscle_names:
        raise Error(f"{path.name!r}: this motion has no muscles to write")
    check_motion_of(motion, scene, f"{path.name!r}: the motion")
    parts = []
    if suffix != ".sto":
        parts.append(coordinates(motion, at_start(scene)))
    if suffix != ".mot":
        parts.append(_muscles(motion))
    names = ["time", *(name for part, _ in parts for name in part)]
    table = np.column_stack([motion.time, *(values for _, values in parts)])
    if not np.isfinite(table).all():
        column = names[int(np.flatnonzero(~np.isfinite(table).all(axis=0))[0])]
        raise Error(
            f"{path.name!r}: column {column!r} of the motion holds a value that is not finite; nothing was written"
        )
    storage = suffix != ".csv"
    text = storage_text(scene.name, names, table, suffix == ".mot") if storage else rows_text(names, table, ",")
    replace_file(path, text)


def coordinates(motion: Recording, scene: Scene) -> tuple[list[str], Floats]:
    """Names and values (F, K) of all degrees of freedom: lengths in m, angles in degrees.

    Args:
        scene: without free parameters, of the same character.

    Raises:
        Error: it has none.
    """
    found = degrees_of_freedom(motion, scene)
    if not found:
        raise Error(f"nothing of {scene.name} moves, so that there are no coordinates to write")
    columns = [np.degrees(degree.values) if degree.unit == "rad" else degree.values for degree in found]
    return [degree.name for degree in found], np.stack(columns, axis=1)


def _muscles(motion: Recording) -> tuple[list[str], Floats]:
    """Names and values of activations and forces, N."""
    names = [f"{name}.{what}" for what in ("activation", "force") for name in motion.muscle_names]
    return names, np.concatenate([motion.muscle_activation, motion.muscle_force], axis=1)


def storage_text(title: str, names: list[str], table: Floats, degrees: bool = False) -> str:
    """The text of a file of OpenSim's: header, names, a row (F, K) a frame."""
    words = {"version": "1", "nRows": str(len(table)), "nColumns": str(len(names))}
    words["inDegrees"] = "yes" if degrees else "no"
    header = "".join(f"{key}={value}\n" for key, value in words.items())
    return f"{_label(one_line(title), TAB)}\n{header}endheader\n{rows_text(names, table, TAB)}"


def rows_text(names: list[str], table: Floats, separator: str) -> str:
    """A row of names, and a row (F, K) of numbers a frame."""
    lines = io.StringIO()
    lines.write(separator.join(_label(name, separator) for name in names) + "\n")
    np.savetxt(lines, table, fmt="%.9g", delimiter=separator)
    return lines.getvalue()


def _label(name: str, separator: str) -> str:
    """A name as the heading of a column: one line, in quotes where it has what separates columns."""
    name = " ".join(name.split())
    if separator in name or '"' in name:
        return '"' + name.replace('"', '""') + '"'
    return name
