"""Reads joint motion from OpenSim's storage files (`.mot`, `.sto`) and from `.csv`, to be tracked.

A column has the name of a coordinate, as in the files that `formats.sto` writes: of the OpenSim model that a scene was
made of, or the joint's name with `_x`, `_y`, `_z` or `_a`, `_b` behind it. OpenSim's paths of states, such as
`/jointset/knee_r/knee_angle_r/value`, are understood. The header says by `inDegrees` which unit angles have; a `.csv`,
which has no header, has degrees, as those that are written here.

Columns `cycle`, or `phase` and `stance`, say when in the step a frame is, as in `formats.npz`. Where there are none,
touch-downs are found from the motion: a foot comes down where it is farthest ahead of the root, in the direction of
travel (Zeni, Richards, Higginson 2008, Gait & Posture 27: 710-714, coordinate-based). Frames outside the gait cycles
of the left foot do not count then.
"""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ResultError, SignalError
from warpmuscle.core.number_rows import rows
from warpmuscle.core.pose import about, multiply, rotate
from warpmuscle.formats.npz import LARGEST_ANGLE, JointMotion, steps
from warpmuscle.scene import JointState, Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.opensim_root import root_motion, usual_root
from warpmuscle.scene.topology import topology
from warpmuscle.synergy.tables import STORAGE, Table, read_table

SUFFIXES = (*STORAGE, ".csv")
HALF = 0.5  # of a cycle, that frames go over at least if they tell its period
STEPS = ("phase", "stance", "cycle")
TRAVEL = 0.5  # m, of a root that walks over the ground rather than on a treadmill
SHORTEST_CYCLE = 0.2  # s, from a touch-down of a foot to its next


def read(path: str | Path, scene: Scene) -> JointMotion:
    """Read the motion of the joints of a scene's character.

    Args:
        scene: without free parameters.

    Raises:
        ResultError: the file cannot be read, lacks times, coordinates or a unit, or holds something else than finite
            numbers; or it does not say when in the step its frames are, and no whole gait cycle is found.
    """
    try:
        table = read_table(path)
        wanted = set(_wanted(scene))
        columns = {name: index for name, index in _columns(table).items() if name in wanted}
        values = dict(zip(columns, table.columns(list(columns.values())).T, strict=True))
    except SignalError as error:
        raise ResultError(str(error)) from None
    try:
        return _motion(values, scene, table.degrees, path)
    except ValueError as error:
        raise ResultError(f"{path}: {error}") from None


def _columns(table: Table) -> dict[str, int]:
    """Columns by the name of what they hold."""
    found: dict[str, int] = {}
    for index, name in enumerate(table.names):
        parts = name.strip().split("/")
        if len(parts) > 1 and parts[-1] == "value":
            name = parts[-2]
        elif len(parts) > 1:
            continue  # such as speeds, and states of muscles
        found.setdefault(name, index)
    return found


def _coordinates(scene: Scene) -> dict[str, list[str]]:
    """Names of the coordinates of every joint that moves by itself, in the order of its angles."""
    found = {}
    for name, joint in scene.character.joints.items():
        kind = joint_type(joint)
        if kind.moves and scene.opensim is not None:
            balls = scene.opensim.balls
            found[name] = list(balls[name].names) if name in balls else [name]
        elif kind.moves:
            found[name] = [f"{name}_{word}".rstrip("_") for word in kind.angles]
    return found


def _wanted(scene: Scene) -> list[str]:
    """Names of all columns that are read."""
    root = (scene.opensim or usual_root(scene.character)).root_coordinates
    return ["time", *STEPS, *root, *(name for names in _coordinates(scene).values() for name in names)]


def _motion(values: dict[str, Floats], scene: Scene, degrees: bool | None, path: str | Path) -> JointMotion:
    """The motion; ValueError if the columns do not fit."""
    if not all(len(column) for column in values.values()):
        raise ValueError("has no rows")
    for name, column in values.items():
        if not np.isfinite(column).all():
            raise ValueError(f"column {name!r} holds a value that is not finite")
    if "time" not in values and not set(STEPS) & set(values):
        raise ValueError("has no column 'time', nor 'cycle'")
    joints = _angles(values, scene, degrees, path)
    if any(name in values for name in STEPS):
        phase, stance = steps(values)
        present, orientation = _orientations(joints, scene)
        return JointMotion(present, values.get("time"), phase, stance, orientation, by_contact="cycle" in values)
    time = values["time"]
    if len(time) < 2 or np.diff(time).min() <= 0.0:
        raise ValueError("times must increase from row to row")
    cycle = _cycle(time, _ahead(values, joints, scene, degrees))
    inside = np.isfinite(cycle)
    present, orientation = _orientations({name: angles[inside] for name, angles in joints.items()}, scene)
    phase, stance = steps({"cycle": cycle[inside]})
    cycles = float(np.ptp(np.unwrap(cycle[inside], period=1.0)))
    period = float(np.ptp(time[inside])) / cycles if cycles > HALF else 0.0
    return JointMotion(present, time[inside], phase, stance, orientation, True, period)


def _angles(values: dict[str, Floats], scene: Scene, degrees: bool | None, path: str | Path) -> dict[str, Floats]:
    """Angles and lengths (F, A), rad and m, of every joint that the file has; ValueError if it has none."""
    found = {}
    for joint, names in _coordinates(scene).items():
        missing = [name for name in names if name not in values]
        if len(missing) == len(names):
            continue
        if missing:
            raise ValueError(f"has no column {missing[0]!r}, which goes with {names[0]!r} and the like of {joint}")
        columns = [_in_radians(name, values[name], scene, joint, degrees, path) for name in names]
        ball = scene.opensim.balls.get(joint) if scene.opensim is not None else None
        if ball is not None and ball.turned_round:
            columns[1] = -columns[1]
        found[joint] = np.stack(columns, axis=1)
    if not found:
        some = ", ".join(name for names in list(_coordinates(scene).values())[:6] for name in names)
        raise ValueError(f"no column has the name of a coordinate; the scene's are {some}, ...")
    return found


def _in_radians(name: str, column: Floats, scene: Scene, joint: str, degrees: bool | None, path: str | Path) -> Floats:
    """A column in rad, or in m if it is a length."""
    own = scene.character.joints[joint]
    angle = name in scene.opensim.angles if scene.opensim is not None else joint_type(own).unit(own) == "rad"
    if not angle:
        return column
    if degrees is None and Path(path).suffix.lower() in STORAGE:
        raise ValueError(
            "the header does not tell the unit of angles: write inDegrees=yes or inDegrees=no above endheader"
        )
    if degrees is not False:
        column = np.radians(column)
    if np.abs(column).max() > LARGEST_ANGLE:
        unit = "rad, as inDegrees=no says" if degrees is False else "degrees"
        raise ValueError(f"column {name!r} goes beyond a whole turn in {unit}")
    return column


def _orientations(joints: dict[str, Floats], scene: Scene) -> tuple[tuple[str, ...], Floats]:
    """Names of J joints and orientations (F, J, 4) of their children in their parents."""
    turned = [_turned(name, angles, scene) for name, angles in joints.items()]
    return tuple(joints), np.stack(turned, axis=1)


def _turned(name: str, angles: Floats, scene: Scene) -> Floats:
    """Orientation (F, 4) of a joint's child in its parent at angles (F, A)."""
    joint = scene.character.joints[name]
    kind = joint_type(joint)
    if scene.opensim is None or name not in scene.opensim.balls:
        return kind.turned(joint, angles)
    swing, twist = (axis[0] for axis in kind.frame(joint))  # a model's axes, as in `Ball.angles_of`
    first, second, third = (
        about(axis, angle) for axis, angle in zip((swing, np.cross(swing, twist), twist), angles.T, strict=True)
    )
    return np.asarray(multiply(multiply(first, second), third))


def _ahead(values: dict[str, Floats], joints: dict[str, Floats], scene: Scene, degrees: bool | None) -> Floats:
    """How far the left foot is ahead of the root in the direction of travel, (F,) m; ValueError if there are no feet.

    What the file does not have of the root and of joints is as in the scene's initial pose, the root upright.
    """
    feet = scene.feet or ("lFoot", "rFoot")
    if feet[0] not in scene.character.bodies:
        raise ValueError("does not say when in the step its frames are: it needs a column 'cycle', 0 to 1")
    opensim, frames = scene.opensim or usual_root(scene.character), len(values["time"])
    turns = 0 if opensim.root is None else len(opensim.root.rotations)
    columns = [values.get(name, np.zeros(frames)) for name in opensim.root_coordinates]
    angles = [column if degrees is False else np.radians(column) for column in columns[:turns]]
    root = root_motion(opensim, np.stack([*angles, *columns[turns:]], axis=1) if columns else np.zeros((frames, 0)))
    way = (root.position[-1] - root.position[0]) * (1.0, 0.0, 1.0)
    length = float(np.linalg.norm(way))
    forward = way / length if length > TRAVEL else np.array([0.0, 0.0, 1.0])
    return np.asarray(rotate(root.orientation, _place_of(scene, feet[0], joints, frames)) @ forward)


def _place_of(scene: Scene, body: str, joints: dict[str, Floats], frames: int) -> Floats:
    """Position (F, 3), m, of a body in the root's frame."""
    character = scene.character
    place, turn = np.zeros((frames, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (frames, 1))
    poses, moved, starts = {character.root: (place, turn)}, {}, {}
    for name, joint in character.joints.items():
        kind = joint_type(joint)
        q, v = starts[name] = kind.start(joint, scene.initial_state.joints.get(name, JointState()))
        moved[name] = joints.get(name, np.repeat(q, frames, axis=0)) if kind.scalars else None
    for name in topology(character).joints:
        joint = character.joints[name]
        kind, (q, v) = joint_type(joint), starts[name]
        source = moved[joint.follows or name]
        if joint.beside and source is not None and (other := moved[joint.beside]) is not None:
            source, v = np.concatenate([source, other], axis=1), np.zeros((1, 2))
        motion = kind.motion(joint, np.repeat(q, frames, axis=0) if source is None else source, np.repeat(v, frames, 0))
        turned = _turned(name, joints[name], scene) if kind.quaternion and name in joints else motion.orientation
        place, turn = poses[joint.parent]
        at = place + rotate(turn, rows(joint.position_in_parent) + motion.place)
        turn = multiply(turn, turned)
        poses[joint.child] = at - rotate(turn, rows(joint.position_in_child)), turn
    return poses[body][0]


def _cycle(time: Floats, ahead: Floats) -> Floats:
    """The part of the gait cycle (F,) at every frame, NaN outside of whole cycles; ValueError if there is none."""
    down = _touch_downs(time, ahead)
    if len(down) < 2:
        raise ValueError(
            "holds no whole gait cycle of the left foot, and no column 'cycle', 0 to 1, that tells when in the cycle "
            "its frames are"
        )
    cycle = np.full(len(time), np.nan)
    for first, last in itertools.pairwise(down):
        cycle[first:last] = (time[first:last] - time[first]) / (time[last] - time[first])
    return cycle


def _touch_downs(time: Floats, ahead: Floats) -> Integers:
    """Frames in which the foot is farthest ahead, one for each time that it is in front of the middle of its way."""
    high = ahead > 0.5 * (ahead.max() + ahead.min())
    edges = [0, *(np.flatnonzero(np.diff(high.astype(int))) + 1).tolist(), len(high)]
    found: list[int] = []
    for first, last in itertools.pairwise(edges):
        peak = int(first + np.argmax(ahead[first:last]))
        if not high[first] or peak in (0, len(high) - 1):  # there it may be farther ahead outside of the recording
            continue
        if not found or time[peak] - time[found[-1]] > SHORTEST_CYCLE:
            found.append(peak)
    return np.array(found, dtype=np.int64)
