"""Where a simulation starts, taken from a frame of a recorded motion."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, ResultError, SceneError
from warpmuscle.core.files import named_file
from warpmuscle.scene import InitialState, JointState, Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.number import Number
from warpmuscle.scene.validation.checks import near

if TYPE_CHECKING:
    from warpmuscle.results.recording import Recording

KEY = "initial_state.file"
TOLERANCE = 1e-6  # s, by which a time may lie outside of a motion


def with_recorded_start(scene: Scene, folders: Sequence[Path]) -> Scene:
    """The scene with the numbers of the frame that its initial state names, in place of the name.

    Args:
        folders: where the file may lie, the first one first.

    Raises:
        SceneError: with key; the file cannot be read, or holds a motion of another character.
    """
    state = scene.initial_state
    if not state.file:
        return scene
    path = named_file(state.file, folders, KEY)
    motion = _motion(path, state.replay)
    frame = _frame(motion, state.time, path)
    return msgspec.structs.replace(scene, initial_state=_state(motion, frame, scene, path))


def _motion(path: Path, replay: int) -> Recording:
    # What reads files takes longer to import than most scenes take to load, which start from none.
    from warpmuscle.results.partial_motion import motion_of
    from warpmuscle.results.result import read

    if replay < 0:
        raise SceneError(f"must be 0 at least, is {replay}", "initial_state.replay")
    try:
        return motion_of(read(path, replay=replay), str(path), replay)
    except Error as error:
        raise SceneError(str(error), KEY) from None


def _frame(motion: Recording, time: float, path: Path) -> int:
    """The frame that is nearest to a time, s."""
    first, last = float(motion.time[0]), float(motion.time[-1])
    if not first - TOLERANCE <= time <= last + TOLERANCE:
        raise SceneError(f"{path}: the motion lasts from {first:g} to {last:g} s", "initial_state.time")
    return int(abs(motion.time - time).argmin())


def _state(motion: Recording, frame: int, scene: Scene, path: Path) -> InitialState:
    """The initial state of a frame; joints that the motion lacks stay as the scene has them."""
    character, joints = scene.character, dict(scene.initial_state.joints)
    for name in motion.joint_names:
        if name not in character.joints:
            hint = near(name, character.joints)
            raise SceneError(f"{path}: its motion has a joint {name!r}, and {scene.name} has none{hint}", KEY)
    try:
        for number, name in enumerate(motion.joint_names):
            kind = joint_type(character.joints[name])
            if kind.by_coordinate and kind.moves:
                joints[name] = JointState(
                    coordinate=_column(motion.coordinate, motion.coordinate_names, name, frame, path),
                    speed=_column(motion.speed, motion.speed_names, name, frame, path),
                )
            elif kind.moves:
                turn, rate = motion.joint_orientation[frame, number], motion.joint_angular_velocity[frame, number]
                joints[name] = JointState(_quaternion(turn), _vector(rate))
        return InitialState(
            root_position=_vector(motion.root_position[frame]),
            root_orientation=_quaternion(motion.root_orientation[frame]),
            root_velocity=_vector(motion.root_velocity[frame]),
            root_angular_velocity=_vector(motion.root_angular_velocity[frame]),
            heading=scene.initial_state.heading,
            joints=joints,
        )
    except ResultError as error:  # a quantity that was not kept
        raise SceneError(str(error), KEY) from None


def _column(values: Floats, names: Sequence[str], joint: str, frame: int, path: Path) -> float:
    """The number of a joint's coordinate in a frame."""
    if joint not in names:
        raise SceneError(f"{path}: its motion has no coordinate of the joint {joint!r}", KEY)
    return float(values[frame, list(names).index(joint)])


def _vector(values: Floats) -> tuple[Number, Number, Number]:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _quaternion(values: Floats) -> tuple[Number, Number, Number, Number]:
    x, y, z, w = (float(value) for value in values)
    return x, y, z, w
