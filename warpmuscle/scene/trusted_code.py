"""Code that a scene names: which it is, and whether the user lets it run.

A part is named as `module:function`. Reading, checking and showing a scene runs nothing of it; a simulation does, and
refuses to unless the user trusts what is named. Trust is a matter of the process and never part of a scene.
"""

from __future__ import annotations

import re
from os import PathLike
from pathlib import Path

import msgspec

from warpmuscle.core.arguments import as_path, in_words
from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Scene
from warpmuscle.scene.learning import Task

ENTRY = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*")
CURVE_FIELDS = ("active_force_length", "passive_force_length", "force_velocity")

_trusted: set[str] = set()
_folders: list[Path] = []
_everything = False


def named_code(scene: Scene) -> dict[str, str]:
    """What a scene names, `module:function` by key."""
    found = {f"objective.custom.{entry}": entry for entry in scene.objective.custom}
    found |= {f"objective.reported.{k}": name for k, name in enumerate(scene.objective.reported) if ":" in name}
    found |= {f"failure.custom.{entry}": entry for entry in scene.failure.custom}
    curves = {f"muscle_model.{field}": getattr(scene.muscle_model, field) for field in CURVE_FIELDS}
    found |= curves | {"custom_controller": scene.custom_controller}
    if scene.controller is not None and ":" in scene.controller.type:
        found["controller.type"] = scene.controller.type
    found |= {f"recorded.{index}": entry for index, entry in enumerate(scene.recorded)}
    found |= _of_task(scene.learning) if scene.learning is not None else {}
    found |= {f"forces.{name}.type": force.type for name, force in scene.forces.items() if ":" in force.type}
    return {key: entry for key, entry in found.items() if entry}


def _of_task(task: Task) -> dict[str, str]:
    """The same of what a policy learns."""
    rewards = {f"learning.rewards.custom.{name}": name for name in task.rewards.custom}
    senses = {f"learning.observations.{name}": name for name in task.observations}
    found = {key: name for key, name in (rewards | senses).items() if ":" in name}
    found |= {f"learning.goals.{name}.draw": goal.draw for name, goal in task.goals.items()}
    found |= {f"learning.ends.{index}": entry for index, entry in enumerate(task.ends)}
    return found | {"learning.curriculum": task.curriculum, "learning.variation.start": task.variation.start}


def without_code(scene: Scene) -> Scene:
    """The scene without what it names, for those who ask for its geometry only; nothing has to be trusted then."""
    replace = msgspec.structs.replace
    model = replace(scene.muscle_model, **dict.fromkeys(CURVE_FIELDS, ""))
    objective = replace(scene.objective, custom={}, reported=_shipped(scene.objective.reported))
    forces = {name: force for name, force in scene.forces.items() if ":" not in force.type}
    failure = replace(scene.failure, custom=[])
    without = replace(scene, muscle_model=model, objective=objective, forces=forces, failure=failure)
    if scene.controller is not None and ":" in scene.controller.type:
        without = replace(without, controller=None)
    if scene.learning is not None and any(_of_task(scene.learning).values()):
        without = replace(without, learning=None)
    return replace(without, custom_controller="", custom_controller_parameters={}, custom={}, recorded=[])


def _shipped(names: list[str]) -> list[str]:
    return [name for name in names if ":" not in name]


def check_entries(scene: Scene) -> None:
    """SceneError unless all that a scene names is named as `module:function`, and once in a list."""
    for key, entry in named_code(scene).items():
        if not ENTRY.fullmatch(entry):
            raise SceneError(f"{entry!r} is not the name of a function as in 'module:function'", key=key)
    ends = scene.learning.ends if scene.learning is not None else []
    lists = {"failure.custom": scene.failure.custom, "recorded": scene.recorded, "learning.ends": ends}
    for key, entries in lists.items():
        for entry in entries:
            if entries.count(entry) > 1:
                raise SceneError(f"{entry!r} is named more than once", key=key)


def trust(scene: Scene, folder: str | PathLike[str] | None = None) -> None:
    """Allow the code that a scene names to run in this process.

    Args:
        folder: where its modules are looked for, besides Python's own places and the current folder.

    Raises:
        SceneError: no scene. ArgumentError: no path of a folder.
    """
    if not isinstance(scene, Scene):
        raise SceneError(f"scene must be a scene as wm.load gives it, not {in_words(scene)}")
    if folder is not None:
        folder = as_path(folder, "folder").absolute()
    _trusted.update(named_code(scene).values())
    if folder is not None and folder not in _folders:
        _folders.append(folder)


def trust_everything() -> None:
    """Let all code run that scenes name, in this process."""
    global _everything
    _everything = True


def trusts_everything() -> bool:
    """Whether all code may run."""
    return _everything


def folders() -> list[Path]:
    """Where modules are looked for, besides Python's own places."""
    return [*_folders, Path.cwd()]


def check_trusted(scene: Scene) -> None:
    """SceneError if a scene names code that the user has not said to trust."""
    wanted = {key: entry for key, entry in named_code(scene).items() if not _everything and entry not in _trusted}
    if wanted:
        raise SceneError(
            f"scene {scene.name!r} wants to run code of {', '.join(map(repr, wanted.values()))}; "
            "if you trust it, say so: --trust, or trust=True",
            key=next(iter(wanted)),
        )
