"""The command that writes a scene in which a model learns to walk."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from warpmuscle.cli.common import SceneFile, Trust, command_line, writable
from warpmuscle.cli.console import out, suggest
from warpmuscle.core.plain_text import number_of


def walking_task(
    model: Annotated[
        Path,
        typer.Argument(
            metavar="MODEL", help="TOML file of a model with two legs, or the name of a shipped one, such as gait2392."
        ),
    ],
    output: SceneFile,
    trust: Trust = False,
) -> None:
    """Write a scene in which a model with two legs learns to walk: soles, springs, rewards, for you to change.

    Its feet are found, and get soles like people's where they have no shapes; joints that no muscle moves get springs.
    Example: warpmuscle convert model.osim -o model.toml --ball-joints --merge-welds --limit-stiffness 500; warpmuscle
    walking-task model.toml -o walks.toml; warpmuscle learn walks.toml
    """
    from warpmuscle.core.errors import Error
    from warpmuscle.core.files import replace_file
    from warpmuscle.core.shipped import shipped_file
    from warpmuscle.formats import toml
    from warpmuscle.walking.task import text_of, walking_task

    shipped = None if model.exists() else shipped_file(str(model))
    if shipped is None and model.suffix.lower() != ".toml":
        raise Error(
            f"{model}: a task is based on a scene's TOML file; write one with `warpmuscle convert {model} -o "
            f"{model.stem}.toml --ball-joints --merge-welds --limit-stiffness 500`"
        )
    if output.suffix != ".toml":
        raise Error(f"{output}: a scene is written as .toml")
    if output.resolve() == model.resolve():
        raise Error(f"{output} is the model itself; name another file")
    writable(output)
    task = walking_task(toml.read(shipped or model))
    base = shipped.name if shipped else os.path.relpath(model.resolve(), output.resolve().parent)
    text = text_of(task, output.stem, base, f"# By `{command_line()}`.\n")
    toml.loads(text, output.parent)
    replace_file(output, text)
    soled = f"soles for {', '.join(task.soles)}" if task.soles else "its feet have shapes"
    out.print(f"wrote {output}: {soled}; {number_of(len(task.springs), 'spring')}", markup=False)
    suggest(f'`warpmuscle learn {output}` learns to walk (extra "learn"; minutes on a GPU)')
