"""The command that makes a scene of a creature's description."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from warpmuscle.cli.common import SceneFile, command_line, writable
from warpmuscle.cli.console import out, suggest
from warpmuscle.core.plain_text import number_of, readable


def build(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="TOML file that describes a creature.")],
    output: SceneFile,
) -> None:
    """Make a scene of a short description: segments, joints, muscles by the boxes where they may attach, a gait.

    Attachments, wrapping radii, properties of muscles and numbers of the controller are free in it. Example:
    warpmuscle example creatures; warpmuscle creature build ostrich.toml -o ostrich_search.toml
    """
    from warpmuscle.core.errors import Error, SceneError
    from warpmuscle.core.files import replace_file
    from warpmuscle.creatures.build import creature_scene, read_creature
    from warpmuscle.formats import toml
    from warpmuscle.scene.parameters import free_parameters

    if output.suffix != ".toml":
        raise Error(f"{output}: a scene is written as .toml")
    if output.resolve() == file.resolve():
        raise Error(f"{output} is the description itself; name another file")
    writable(output)
    creature = read_creature(file)
    try:
        scene = creature_scene(creature, readable(output.stem))
    except SceneError as error:
        raise toml.Source.read(file).placed(error) from None
    replace_file(output, f"# By `{command_line()}`.\n\n{toml.dumps(scene)}")
    parts = scene.character
    muscles, free = number_of(len(parts.muscles), "muscle"), number_of(len(free_parameters(scene)), "free number")
    out.print(f"wrote {output}: {number_of(len(parts.bodies), 'body')}, {muscles}, {free}", markup=False)
    suggest(f"`warpmuscle optimize {output}` searches for a gait")
