"""Writes motions as OpenSim storage (`.mot`, `.sto`) or comma-separated values: a header, names, a row a frame.

A `.mot` holds the angles of the joints in degrees and the root's position in metres, a `.sto` activations and forces of
the muscles, a `.csv` both. A ball joint gives three angles, of turns about the child's x, then y, then z axis
(intrinsic); a hinge or universal joint its own, a slide its position in metres. Names are the joint's, with `_x`,
`_y`, `_z` or `_a`, `_b` behind it. A scene made of an OpenSim model gives that model's coordinates
instead, locked and coupled ones among them, so that OpenSim plays the motion on the model.
"""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.files import replace_file
from warpmuscle.core.pose import euler_xyz, normalized
from warpmuscle.results.joint_poses import joint_angles
from warpmuscle.results.motion_of_scene import check_motion_of
from warpmuscle.results.recording import Recording
from warpmuscle.scene import BallCoordinates, OpenSim, Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.joints.displacement import rates
from warpmuscle.scene.opensim_root import root_values
from warpmuscle.scene.parameters import start_values, substitute

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
        parts.append(coordinates(motion, substitute(scene, start_values(scene))))
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
    text = storage_text(scene.name, names, table, suffix == ".mot") if storage else _rows(names, table, ",")
    replace_file(path, text)


def coordinates(motion: Recording, scene: Scene) -> tuple[list[str], Floats]:
    """Names and values (F, K) of the root's position, m, and of all angles, degrees.

    Args:
        scene: without free parameters, of the same character.
    """
    if scene.opensim is not None:
        return _model_coordinates(motion, scene, scene.opensim)
    root = scene.character.root
    names = [f"{root}_t{axis}" for axis in "xyz"] + [f"{root}_{axis}" for axis in "xyz"]
    turned = normalized(motion.root_orientation)
    columns: list[Floats] = [np.asarray(motion.root_position, np.float64), np.degrees(euler_xyz(turned))]
    for name in motion.joint_names:
        joint = scene.character.joints[name]
        names += [f"{name}_{word}".rstrip("_") for word in joint_type(joint).angles]
        angles = joint_angles(motion, scene.character, name)
        columns.append(np.degrees(angles) if joint_type(joint).unit(joint) == "rad" else angles)
    return names, np.concatenate(columns, axis=1)


def _model_coordinates(motion: Recording, scene: Scene, opensim: OpenSim) -> tuple[list[str], Floats]:
    """Names and values of the coordinates of an OpenSim model, (F, K), degrees where OpenSim has them so."""
    root = root_values(opensim, np.asarray(motion.root_position, np.float64), motion.root_orientation)
    values: dict[str, Floats] = dict(zip(opensim.root_coordinates, root.T, strict=True))
    for name in motion.joint_names:
        if name in opensim.balls:
            values |= _ball_coordinates(motion, scene, name, opensim.balls[name])
        elif name in motion.coordinate_names:
            values[name] = np.asarray(motion.coordinate[:, motion.coordinate_names.index(name)], np.float64)
        elif len(joint_type(scene.character.joints[name]).angles) == 1:
            values[name] = joint_angles(motion, scene.character, name)[:, 0]
    for name, coupling in opensim.couplers.items():
        values[name] = rates(coupling, values[coupling.joint])[0]
    values |= {name: np.full(motion.frames, value) for name, value in opensim.locked.items()}
    columns = [np.degrees(values[name]) if name in opensim.angles else values[name] for name in values]
    return list(values), np.stack(columns, axis=1)


def _ball_coordinates(motion: Recording, scene: Scene, name: str, ball: BallCoordinates) -> dict[str, Floats]:
    """Coordinates of a model, (F,) rad each, that are angles of a ball joint here."""
    joint = scene.character.joints[name]
    turned = normalized(motion.joint_orientation[:, motion.joint_names.index(name)])
    first, second, third = joint_type(joint).angles_of(joint, turned).T
    return dict(zip(ball.names, (first, -second if ball.turned_round else second, third), strict=True))


def _muscles(motion: Recording) -> tuple[list[str], Floats]:
    """Names and values of activations and forces, N."""
    names = [f"{name}.{what}" for what in ("activation", "force") for name in motion.muscle_names]
    return names, np.concatenate([motion.muscle_activation, motion.muscle_force], axis=1)


def storage_text(title: str, names: list[str], table: Floats, degrees: bool = False) -> str:
    """The text of a file of OpenSim's: header, names, a row (F, K) a frame."""
    words = {"version": "1", "nRows": str(len(table)), "nColumns": str(len(names))}
    words["inDegrees"] = "yes" if degrees else "no"
    header = "".join(f"{key}={value}\n" for key, value in words.items())
    return f"{_label(title, TAB)}\n{header}endheader\n{_rows(names, table, TAB)}"


def _rows(names: list[str], table: Floats, separator: str) -> str:
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
