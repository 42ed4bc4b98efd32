"""Scenes that begin in the middle of their own motion, so that no transient is left to get over."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.pose import twist_angle
from warpmuscle.results.joint_poses import joint_angles
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Character, InitialState, JointState, Scene
from warpmuscle.scene.initial_pose import plain_number
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import distances_of_commands, leaves, rebuilt
from warpmuscle.scene.terrain.surface import Surface, surface
from warpmuscle.simulation.rollout import Rollout

DIGITS = 6


def steady_state(scene: Scene, after: float) -> Scene:
    """The scene with the state of its own motion as the initial one, at the first step that begins as the scene does.

    The root is put back to the origin of the ground. Muscles start at the activation that the scene says.

    Args:
        scene: sound scene with a controller; it is not changed. after: s, simulated time that it may take to settle.

    Raises:
        RolloutError: it has no controller, fails, or begins no such step within 10 s more.
    """
    if scene.simbicon is None:
        raise RolloutError(f"{scene.name} has no controller whose steps it could begin with")
    longer = msgspec.structs.replace(scene, duration=after + 10.0)
    rollout = Rollout(longer, 1, "cpu", record=[0], record_rate=1.0 / scene.time_step)
    rollout.run()
    motion = rollout.recording()
    frame = first_step(motion, after, scene.simbicon.start_state, int(scene.simbicon.start_stance == "right"))
    if frame is None:
        raise RolloutError(f"{scene.name} begins no step between {after:g} s and its end at {motion.end:.3g} s")
    ground = surface(rollout.numeric.ground)
    found = state_at(motion, frame, ground.plane.normal, rollout.numeric.character)
    if rollout.numeric.ground.terrain is not None:
        found = _lowered(found, ground, motion.root_position[frame], rollout.numeric.ground.terrain.clearing)
    return msgspec.structs.replace(scene, initial_state=_following(scene, found))


def _lowered(found: InitialState, ground: Surface, place: Floats, clearing: float) -> InitialState:
    """A state as over the plane, since a start is raised by what the ground rises below it."""
    x, y, z = (plain_number(number) for number in found.root_position)
    rise = ground.highest_rise(float(place[0]), float(place[2]), clearing)
    return msgspec.structs.replace(found, root_position=(x, round(y - rise, DIGITS), z))


def _following(scene: Scene, found: InitialState) -> InitialState:
    """A state whose numbers follow commands as those of the scene's own initial state do."""
    away = distances_of_commands(scene)
    per = {path: leaf for path, leaf in leaves(scene.initial_state) if isinstance(leaf, Free) and leaf.per}

    def fixed(_: str, number: Any) -> Any:
        return number.value if isinstance(number, Free) else number

    def replaced(path: str, leaf: Any) -> Any:
        before = per.get(path)
        if before is None or not isinstance(leaf, float):
            return leaf
        rates = before.with_rates(fixed)
        added = Free(0.0, per=rates).commanded(away, fixed)
        return Free(round(leaf - added, DIGITS), per=rates)

    return rebuilt(found, replaced)


def first_step(motion: Recording, after: float, state: int, stance: int) -> int | None:
    """First frame after a time in which the controller has just entered a state in a stance."""
    entered = np.diff(motion.phase, prepend=0.0) < 0.0
    found = np.flatnonzero((motion.time > after) & entered & (motion.state == state) & (motion.stance == stance))
    return int(found[0]) if len(found) else None


def state_at(motion: Recording, frame: int, normal: Floats, character: Character) -> InitialState:
    """The state of a motion in one frame, moved along the ground with this normal, (3,), to above the origin."""

    def numbers(values: Floats) -> tuple[float, ...]:
        return tuple(round(float(value), DIGITS) + 0.0 for value in values)

    height = float(motion.root_position[frame] @ normal / normal[1])
    heading = twist_angle(motion.root_orientation[frame], (0.0, 1.0, 0.0))
    return InitialState(
        heading=round(float(heading), DIGITS) + 0.0,
        root_position=(0.0, round(height, DIGITS), 0.0),
        root_orientation=numbers(motion.root_orientation[frame]),  # type: ignore[arg-type]
        root_velocity=numbers(motion.root_velocity[frame]),  # type: ignore[arg-type]
        root_angular_velocity=numbers(motion.root_angular_velocity[frame]),  # type: ignore[arg-type]
        joints={
            name: JointState(
                numbers(motion.joint_orientation[frame, index]),  # type: ignore[arg-type]
                numbers(motion.joint_angular_velocity[frame, index]),  # type: ignore[arg-type]
            )
            for index, name in enumerate(motion.joint_names)
            if not joint_type(character.joints[name]).by_coordinate
        }
        | {
            name: _coordinate_state(motion, frame, character, name)
            for name in motion.joint_names
            if joint_type(character.joints[name]).by_coordinate and joint_type(character.joints[name]).moves
        },
    )


def _coordinate_state(motion: Recording, frame: int, character: Character, name: str) -> JointState:
    """The state of a joint of one coordinate, whose speed follows from the frames beside it."""
    coordinate = joint_angles(motion, character, name)[:, 0]
    speed = np.gradient(coordinate, motion.time)[frame]
    return JointState(coordinate=round(float(coordinate[frame]), DIGITS), speed=round(float(speed), DIGITS))
