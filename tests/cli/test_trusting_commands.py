"""Every command that takes a scene or a result of one lets code run that it names if told to, and only then."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.main import get_command

import command_line
from warpmuscle.cli.program import app

PARTS = """import warp as wp
from warpmuscle.kernels.objective.term_functions import MuscleWork
from warpmuscle.kernels.structs import Model

@wp.func
def effort(instance: int, m: int, w: MuscleWork, model: Model) -> float:
    return w.activation * w.activation

@wp.func
def bell(length: float) -> float:
    return wp.exp((length - 1.0) * (length - 1.0) * (-1.0 / 0.5))

open("ran", "w").close()
"""
SCENE = """base = "walk56"
name = "named"
duration = 0.2
[muscle_model]
active_force_length = "{module}:bell"
[objective.custom]
"{module}:effort" = 1.0
"""
WITHOUT_SCENES = {
    *("arm-angles", "creature build", "example", "scenes", "schema", "synergies cluster", "synergies extract"),
}
RUN = (
    "fit-muscles named.toml -o out.toml",
    "apply result.h5 -o out.toml --settle 0.1",
    "view result.h5 --candidates 1 --export out.html",
)
SHOW = (
    "info named.toml",
    "convert named.toml -o out.toml",
    "plot result.h5 --what moment_arms -o out.png",
    "walking-task named.toml -o walks.toml",
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, unoptimized_kernels: None) -> Path:
    """A folder with a scene that names code, the code, and what a search of the scene wrote."""
    place = tmp_path_factory.mktemp("named")
    (place / "their_own_parts.py").write_text(PARTS)
    (place / "named.toml").write_text(SCENE.format(module="their_own_parts"))
    words = "optimize named.toml --candidates 2 -o result.h5 --trust"
    done = command_line.run(*words.split(), folder=place)
    assert done.returncode == 0, done.stderr
    assert (place / "ran").exists()
    return place


@pytest.mark.parametrize("words", RUN)
def test_a_command_that_runs_a_scene_runs_its_code_if_trusted(words: str, folder: Path):
    (folder / "ran").unlink(missing_ok=True)
    refused = command_line.run(*words.split(), folder=folder)
    assert (refused.returncode, refused.stderr.count("\n")) == (2, 1), refused.stderr
    assert "--trust" in refused.stderr
    assert not (folder / "ran").exists()
    done = command_line.run(*words.split(), "--trust", folder=folder)
    assert done.returncode == 0, done.stderr
    assert (folder / "ran").exists()


@pytest.mark.parametrize("words", SHOW)
def test_a_command_that_shows_a_scene_runs_none_of_its_code(words: str, folder: Path):
    (folder / "ran").unlink(missing_ok=True)
    done = command_line.run(*words.split(), folder=folder)
    assert done.returncode == 0, done.stderr
    assert not (folder / "ran").exists()


def test_every_command_takes_the_option_but_those_that_never_meet_a_scene():
    found = dict(leaves(get_command(app)))
    having = {name for name, command in found.items() if "trust" in {one.name for one in command.params}}
    assert len(found) > len(app.registered_commands) > 20
    assert found.keys() - having == WITHOUT_SCENES


def leaves(group: Any, before: str = "") -> Iterator[tuple[str, Any]]:
    """Commands by what is typed for them, those of groups such as `throw fit` too."""
    for name, command in group.commands.items():
        if hasattr(command, "commands"):
            yield from leaves(command, f"{before}{name} ")
        elif not command.hidden:
            yield f"{before}{name}", command
