"""What commands that judge are given: scenes with their own controllers, results of searches, and policies."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import load_scene, scene_names_like, with_commands
from warpmuscle.cli.console import print_warnings
from warpmuscle.core.errors import Error

if TYPE_CHECKING:
    from warpmuscle.results.learned import Learned
    from warpmuscle.results.records import Result
    from warpmuscle.scene import Scene
    from warpmuscle.scene.learning import Task
    from warpmuscle.studies.walkers import Walker

Walkers = Annotated[
    list[str],
    typer.Argument(
        metavar="SCENE...|FILE",
        help="Scene name, TOML file, .rbs .sbc [.rs], .osim or .xml; or a result file, of a search or of `learn`.",
        autocompletion=scene_names_like,
    ),
]


def walker_of(
    sources: list[str],
    *,
    policy: Path | None = None,
    settings: list[str] | None = None,
    commands: list[str] | None = None,
    device: str | None = None,
    threads: int | None = None,
) -> tuple[str, Walker]:
    """What walks, and the name of its scene: a scene, the best of a result file, or a policy in its scene or another.

    Raises:
        Error: what was given contradicts itself, or cannot be read.
    """
    from warpmuscle.learning.player import learned_in
    from warpmuscle.studies.walkers import SceneWalker
    from warpmuscle.view.sources import is_result

    if len(sources) == 1 and is_result(sources[0]):
        if policy is not None or settings:
            raise Error(f"{sources[0]}: a result file takes no {'--policy' if policy is not None else '--set'}")
        return _of_result(sources[0], commands, device, threads)
    scene = load_scene(sources, settings=settings, commands=commands if policy is None else None)
    if policy is None:
        return scene.name, SceneWalker(scene, device, threads)
    return scene.name, _of_policy(learned_in(policy), scene, commands, device, threads)


def _of_result(path: str, commands: list[str] | None, device: str | None, threads: int | None) -> tuple[str, Walker]:
    from warpmuscle.optimization.best_scene import recorded_scene, scene_in
    from warpmuscle.results.result import read
    from warpmuscle.studies.walkers import SceneWalker

    result = read(path, replay=0)
    if of_a_policy(result):
        raise Error(
            f"{path}: a policy moved this, and the file holds its motion alone; give the file of `warpmuscle learn`"
        )
    if result.learned is not None:
        scene = scene_in(result)
        return scene.name, _of_policy(result.learned, scene, commands, device, threads)
    scene = recorded_scene(result)
    return scene.name, SceneWalker(with_commands(scene, commands) if commands else scene, device, threads)


def of_a_policy(result: Result) -> bool:
    """Whether a policy moved what a file shows that does not hold the policy: its scene alone would go otherwise."""
    return any(word.partition("=")[0] == "--policy" for word in result.command.split())


def _of_policy(
    learned: Learned, scene: Scene, commands: list[str] | None, device: str | None, threads: int | None
) -> Walker:
    from warpmuscle.learning.player import beyond, commands_given, task_of
    from warpmuscle.studies.walkers import PolicyWalker

    task = task_of(learned)
    scene, to_policy = shared_out(scene, task, commands or [])
    print_warnings(beyond(task, to_policy))
    return PolicyWalker(learned, scene, device, threads, commands_given(task, to_policy))


def shared_out(scene: Scene, task: Task, commands: list[str]) -> tuple[Scene, list[str]]:
    """The scene with the commands that are its own, such as a slope that a policy must feel, and the policy's."""

    def is_of_controller(text: str) -> bool:
        name = text.partition("=")[0].strip()
        return name in scene.commands and name not in task.command_names

    own = [text for text in commands if is_of_controller(text)]
    return with_commands(scene, own) if own else scene, [text for text in commands if not is_of_controller(text)]


def commanded_in_words(scene: Scene, commands: list[str]) -> list[str]:
    """Commands of a scene that were given as NAME=VALUE, with their units."""
    words = []
    for text in commands:
        name, _, value = (part.strip() for part in text.partition("="))
        unit = scene.commands[name].unit
        words.append(f"{name} {value}" if unit in ("", "1") else f"{name} {value} {unit}")
    return words
