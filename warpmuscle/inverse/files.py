"""Markers and coordinates from files, and coordinates into files."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ResultError, SignalError
from warpmuscle.core.files import replace_file
from warpmuscle.formats.npz import LARGEST_ANGLE
from warpmuscle.formats.sto import rows_text, storage_text
from warpmuscle.inverse.laboratory.axes import axes_of_c3d, check_axes, to_ground
from warpmuscle.inverse.plausibility.motions import unit_notes
from warpmuscle.inverse.trial import Coordinates, Markers, TrialWarning, of_file
from warpmuscle.markers.arm import AXES
from warpmuscle.markers.files import read_markers as read_file
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.opensim_root import usual_root
from warpmuscle.synergy.columns import TIMES, plain_name
from warpmuscle.synergy.tables import STORAGE, check_rising, finite_columns, read_table

WRITTEN = (".mot", ".sto", ".csv")
C3D = ".c3d"


def read_markers(
    path: str | Path, unit: str | None = None, up: str | None = None, forward: str | None = None
) -> Markers:
    """The markers of a `.trc`, `.c3d`, `.csv` or other file that `warpmuscle.markers.files` reads, in ground axes.

    Args:
        unit: of positions: m, cm, mm, ft or in; by default what the file says.
        up, forward: which axes of the file these are, such as `z` or `-x`; by default y and x, and of a `.c3d` those
            that its force plates and the way of its points tell.

    Raises:
        SignalError: the file cannot be read or holds no markers; an axis is none, or both are the same one.
    """
    if Path(path).suffix.lower() == C3D:
        found = read_file(path, unit)
        up, forward = axes_of_c3d(Path(path), up, forward)
    else:
        up, forward = up or "y", forward or ("x" if up is None or AXES.get(up) != 0 else "y")
        check_axes(up, forward)
        found = read_file(path, unit)
    turn = to_ground(up, forward)
    twice = next((name for k, name in enumerate(found.names) if name in found.names[:k]), None)
    if twice is not None:
        raise SignalError(f"two markers are called {twice!r}; rename one", file=path)
    with of_file(path):
        return Markers(found.names, found.time + found.begin, found.position @ turn.T)


def angle_names(scene: Scene) -> frozenset[str]:
    """Names of the coordinates of a scene's model that are angles, rad; all others are lengths, m."""
    if scene.opensim is not None:
        return frozenset(scene.opensim.angles)
    root = usual_root(scene.character)
    names = set(root.root_coordinates[: len(root.root.rotations)] if root.root is not None else ())
    for name, joint in scene.character.joints.items():
        kind = joint_type(joint)
        if kind.unit(joint) == "rad":
            names |= {f"{name}_{word}".rstrip("_") for word in kind.angles}
    return frozenset(names)


def read_coordinates(path: str | Path, scene: Scene, degrees: bool | None = None) -> Coordinates:
    """Coordinates of a scene's model from a `.mot`, `.sto` or `.csv` file, angles in rad.

    Columns have the names of coordinates, or OpenSim's paths of their values; others are left aside. The header says by
    `inDegrees` which unit angles have; a `.csv` has degrees.

    Args:
        degrees: whether angles are in degrees, whatever the header says.

    Warns:
        TrialWarning: angles that may well be rad where the file says degrees.

    Raises:
        SignalError: the file cannot be read, has no times or coordinates, does not tell the unit, or holds something
            else than finite numbers.
    """
    table = read_table(path)
    plain = [plain_name(name) for name in table.names]
    time = next((plain.index(name) for name in TIMES if name in plain), None)
    if time is None:
        raise SignalError("no column of time; name one `time`", file=path)
    angles = angle_names(scene)
    known = _coordinate_names(scene)
    columns: dict[str, int] = {}
    for index, heading in enumerate(table.names):
        parts = heading.strip().split("/")
        name = parts[0] if len(parts) == 1 else parts[-2] if parts[-1] == "value" else ""
        if name in known and columns.setdefault(name, index) != index:
            raise SignalError(f"two columns give the coordinate {name!r}", file=path)
    if not columns:
        raise SignalError(f"no column has the name of a coordinate; the model's are {', '.join(known[:8])}, ...",
                          file=path)  # fmt: skip
    values = finite_columns(table, [time, *columns.values()], ["time", *columns])
    times = TIMES[plain[time]] * values[:, 0]
    check_rising(table, times)
    unit_given = degrees is not None
    degrees = table.degrees if degrees is None else degrees
    if degrees is None and Path(path).suffix.lower() in STORAGE:
        raise SignalError(
            "the header does not tell the unit of angles: write inDegrees=yes or inDegrees=no above endheader, or say "
            "whether they are in degrees",
            file=path,
        )
    turned = np.array([name in angles and degrees is not False for name in columns])
    found = np.where(turned, np.radians(values[:, 1:]), values[:, 1:])
    for name, column in zip(columns, found.T, strict=True):
        if name in angles and np.abs(column).max() > 8.0 * LARGEST_ANGLE:
            unit = "rad, as inDegrees=no says" if degrees is False else "degrees"
            raise SignalError(f"column {name!r} goes beyond eight turns in {unit}", file=path)
    for note in [] if unit_given else unit_notes(values[:, 1:][:, turned]):
        warnings.warn(f"{path}: {note}", TrialWarning, stacklevel=2)
    with of_file(path):
        return Coordinates(tuple(columns), times, found)


def _coordinate_names(scene: Scene) -> list[str]:
    """All coordinates of a scene's model, also locked and coupled ones."""
    model = scene.opensim or usual_root(scene.character)
    names = list(model.root_coordinates)
    for name, joint in scene.character.joints.items():
        if name in model.balls:
            names += model.balls[name].names
        else:
            names += [f"{name}_{word}".rstrip("_") for word in joint_type(joint).angles]
    return [*names, *model.couplers, *model.locked]


def write_coordinates(path: str | Path, coordinates: Coordinates, scene: Scene) -> None:
    """Write coordinates under their names as OpenSim's `.mot` or `.csv`, angles in degrees, or `.sto`, in rad.

    Raises:
        ResultError: another suffix.
        SceneError: the file cannot be written; nothing is left behind then.
    """
    angles = angle_names(scene)
    degrees = Path(path).suffix.lower() != ".sto"
    turned = np.array([name in angles and degrees for name in coordinates.names])
    values = np.where(turned, np.degrees(coordinates.values), coordinates.values)
    write_columns(path, scene.name, coordinates.times, coordinates.names, values, degrees)


def write_columns(
    path: str | Path, title: str, times: Floats, names: tuple[str, ...], values: Floats, degrees: bool = False
) -> None:
    """Write columns (F, K) over time under their names; see `write_coordinates`."""
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in WRITTEN:
        raise ResultError(f"{path.name!r}: this is written as {', '.join(WRITTEN)}")
    columns, table = ["time", *names], np.column_stack([times, values])
    csv = suffix == ".csv"
    replace_file(path, rows_text(columns, table, ",") if csv else storage_text(title, columns, table, degrees))
