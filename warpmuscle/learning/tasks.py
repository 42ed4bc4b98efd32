"""A task as it is given, and the scene as it is learned in."""

from __future__ import annotations

import msgspec

from warpmuscle.core.arguments import as_kind
from warpmuscle.core.decoding import to_type
from warpmuscle.core.errors import RolloutError
from warpmuscle.model.task_parts import rewards_of_steps
from warpmuscle.scene import Scene
from warpmuscle.scene.learning import Task
from warpmuscle.scene.validation.scene import check_scene


def checked_task(task: Task | None) -> Task | None:
    """A task of the right types; raises RolloutError if it is none, SceneError if one of its values is not."""
    if task is None:
        return None
    as_kind(Task, task, "task", error=RolloutError)
    plain = msgspec.to_builtins(task, enc_hook=lambda value: value.item() if hasattr(value, "item") else repr(value))
    return to_type(plain, Task, "learning")


def prepared(scene: Scene, task: Task) -> Scene:
    """The scene as it is learned in, with its task, whose rewards its steps sum up; who is to turn has not failed so.

    Raises:
        SceneError: the task names code that is not trusted, or that cannot be used.
    """
    replace = msgspec.structs.replace
    failure = replace(scene.failure, heading=0.0) if any(task.turning_rate) else scene.failure
    scene = replace(scene, learning=task, failure=failure)
    if not task.rewards.custom:
        return scene
    check_scene(scene)
    reported = dict.fromkeys((*scene.objective.reported, *rewards_of_steps(scene)))
    return replace(scene, objective=replace(scene.objective, reported=list(reported)))
