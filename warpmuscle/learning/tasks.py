"""A task as it is given, and the scene as it is learned in."""

from __future__ import annotations

import msgspec

from warpmuscle.core.arguments import as_kind
from warpmuscle.core.decoding import to_type
from warpmuscle.core.errors import RolloutError
from warpmuscle.scene import Scene
from warpmuscle.scene.learning import Task


def checked_task(task: Task | None) -> Task | None:
    """A task of the right types; raises RolloutError if it is none, SceneError if one of its values is not."""
    if task is None:
        return None
    as_kind(Task, task, "task", error=RolloutError)
    plain = msgspec.to_builtins(task, enc_hook=lambda value: value.item() if hasattr(value, "item") else repr(value))
    return to_type(plain, Task, "learning")


def prepared(scene: Scene, task: Task) -> Scene:
    """The scene as it is learned in, with its task; who is to turn has not failed by turning."""
    failure = msgspec.structs.replace(scene.failure, heading=0.0) if any(task.turning_rate) else scene.failure
    return msgspec.structs.replace(scene, learning=task, failure=failure)
