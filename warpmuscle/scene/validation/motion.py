"""What the types of a scene cannot say about prescribed motion."""

from __future__ import annotations

from typing import Any

from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import number_of
from warpmuscle.scene import Joint, Motion, Scene
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.scene.validation.checks import Checks, known

LATE = 1.0e-9  # s, by which knots may miss the ends of the simulated time


def check_motion(checks: Checks) -> None:
    """Check the motions of a scene whose joints and actuation are sound.

    Raises:
        SceneError: the first thing wrong, with its key, such as `motion.knee.value`.
    """
    scene = checks.checked
    for name, motion in scene.motion.items():
        key = f"motion.{name}"
        known(name, ["root", *scene.character.joints], "joint", key)
        _times(checks, key, motion, scene)
        if name == "root":
            _root(key, motion, scene)
        else:
            _joint(key, name, motion, scene)


def kinematic_axes(scene: Scene, name: str) -> list[int]:
    """Which degrees of freedom of a joint are kinematic."""
    if name not in scene.actuation:
        return []
    drive = scene.actuation[name].drive
    words = [drive] * len(joint_type(scene.character.joints[name]).speeds) if isinstance(drive, str) else drive
    return [axis for axis, word in enumerate(words) if word == "kinematic"]


def _times(checks: Checks, key: str, motion: Motion, scene: Scene) -> None:
    """Knots are in order and reach over the simulated time; a single one stands for all of it."""
    if not motion.time:
        raise SceneError("a motion needs at least one knot", key=f"{key}.time")
    checks.increasing(f"{key}.time", motion.time, "times")
    first, last = motion.time[0], motion.time[-1]
    if len(motion.time) > 1 and (first > LATE or last < scene.duration - LATE):
        message = f"reaches from {first:g} to {last:g} s, the simulation from 0 to {scene.duration:g} s"
        raise SceneError(message, key=f"{key}.time")


def _root(key: str, motion: Motion, scene: Scene) -> None:
    """The root can move, and has knots of its position or rotation."""
    if not root_type(scene.character).speeds:
        raise SceneError("a fixed root does not move; make `root_joint` free or planar", key=key)
    _only(key, motion, "position", "rotation")
    if not motion.position and not motion.rotation:
        raise SceneError("the motion of the root needs `position` or `rotation`", key=key)
    for field in ("position", "rotation"):
        values = getattr(motion, field)
        if values:
            _count(f"{key}.{field}", len(values), motion)


def _joint(key: str, name: str, motion: Motion, scene: Scene) -> None:
    """A joint has knots for each of its kinematic degrees of freedom, or for all if none is."""
    joint: Joint = scene.character.joints[name]
    axes = kinematic_axes(scene, name) or list(range(len(joint_type(joint).speeds)))
    if not axes:
        raise SceneError(f"a {joint.type} joint does not move", key=key)
    if joint_type(joint).quaternion:
        _only(key, motion, "rotation")
        _count(f"{key}.rotation", len(motion.rotation), motion)
        return
    _only(key, motion, "value")
    lists = [values for values in motion.value if isinstance(values, list)]
    if lists and len(lists) < len(motion.value):
        raise SceneError("either numbers, or one list of them an angle", key=f"{key}.value")
    given: list[Any] = lists or [motion.value]
    if len(given) != len(axes):
        raise SceneError(
            f"{number_of(len(axes), 'angle', 'take')} {number_of(len(axes), 'list')}, got {len(given)}",
            key=f"{key}.value",
        )
    for index, values in enumerate(given):
        _count(f"{key}.value.{index}" if lists else f"{key}.value", len(values), motion)


def _only(key: str, motion: Motion, *wanted: str) -> None:
    """A motion has no other values than those wanted."""
    for field in ("value", "rotation", "position"):
        if field not in wanted and getattr(motion, field):
            raise SceneError(f"takes {' and '.join(f'`{name}`' for name in wanted)} only", key=f"{key}.{field}")


def _count(key: str, count: int, motion: Motion) -> None:
    """As many values as times."""
    if count != len(motion.time):
        raise SceneError(f"{number_of(count, 'value')} for {number_of(len(motion.time), 'time')}", key=key)
