"""Commands for a start: sample files, and the format of scenes for editors."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from warpmuscle.cli.console import marked, out


def _names_like(incomplete: str) -> list[str]:
    from warpmuscle.examples import EXAMPLES

    return [name for name in EXAMPLES if name.startswith(incomplete)]


def example(
    name: Annotated[
        str | None, typer.Argument(help="Which one; without it, all are listed.", autocompletion=_names_like)
    ] = None,
    folder: Annotated[Path, typer.Option("--folder", "-f", help="Where the files go.")] = Path(),
    replace: Annotated[bool, typer.Option("--replace", help="Write over files that exist.")] = False,
) -> None:
    """Write sample files of our own making: scenes, code, motions, EMG.

    Examples: warpmuscle example; warpmuscle example throws
    """
    from warpmuscle.examples import EXAMPLES, write

    if name is None:
        for known, of in EXAMPLES.items():
            out.print(marked(known, "bold", f"  {of.description}"))
        return
    written = write(name, folder, replace)
    out.print(f"wrote {', '.join(map(str, written))}", markup=False)


def schema(
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="File to write; by default it is printed.")
    ] = None,
) -> None:
    """Write the format of scenes as a JSON schema, from which editors complete and check TOML.

    Editors with the Taplo language server, such as Visual Studio Code with Even Better TOML, complete scenes whose
    first line is `#:schema ./warpmuscle.json`. Example: warpmuscle schema -o warpmuscle.json
    """
    import json

    from warpmuscle.core.files import replace_file
    from warpmuscle.formats.schema import scene_schema

    text = json.dumps(scene_schema(), indent=1) + "\n"
    if output is None:
        typer.echo(text, nl=False)
        return
    replace_file(output, text)
    out.print(f"wrote {output}", markup=False)
