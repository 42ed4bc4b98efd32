"""Commands for a start: sample files, the format of scenes for editors, and kernels compiled ahead of time."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import Device, Settings, Trust, load_scene, scene_names_like, start_warp
from warpmuscle.cli.console import log, marked, out
from warpmuscle.core.plain_text import number_of

if TYPE_CHECKING:
    from warpmuscle.scene import Scene
    from warpmuscle.simulation.rollout import Rollout


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
    """Write sample files: scenes, code, motions, EMG.

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


def compile(
    sources: Annotated[
        list[str],
        typer.Argument(metavar="SCENE...", help="Scenes, each a name or a file.", autocompletion=scene_names_like),
    ],
    instances: Annotated[
        int,
        typer.Option(min=1, help="How many instances a GPU will simulate at once; its code depends on this number."),
    ] = 1000,
    settings: Settings = None,
    device: Device = None,
    trust: Trust = False,
) -> None:
    """Compile what scenes need ahead of time, so that later commands start at once.

    Scenes of one kind share their code, which is kept in Warp's cache. Examples: warpmuscle compile walk56 fwalk;
    warpmuscle compile mine.toml --device cuda:0 --instances 5120
    """
    scenes = [load_scene([source], settings=settings) for source in sources]
    start_warp()
    begin, compiled = time.monotonic(), 0
    for place, (source, scene) in enumerate(zip(sources, scenes, strict=True), 1):
        since, needed = time.monotonic(), False
        with log.status(f"preparing {source}, {place} of {len(scenes)}"):
            for rollout in _rollouts(scene, instances, device):
                needed |= rollout.compiles
                rollout.load()
        compiled += needed
        seconds = time.monotonic() - since
        how = f"compiled in {seconds:.0f} s" if needed else "was compiled before"
        left = (time.monotonic() - begin) / place * (len(scenes) - place)
        out.print(f"{place} of {len(scenes)}: {source} {how}" + (f", about {left:.0f} s left" if left >= 1.0 else ""))
    if compiled:
        out.print(f"compiled {number_of(compiled, 'kind')} of scene in {time.monotonic() - begin:.0f} s", markup=False)


def _rollouts(scene: Scene, instances: int, device: str | None) -> Iterator[Rollout]:
    """What runs of a scene use: one that is recorded, and on a GPU many that are not."""
    from warpmuscle.simulation.rollout import Rollout

    recorded = Rollout(scene, 1, device, record=[0])
    yield recorded
    if not recorded.device.is_cpu:
        yield Rollout(scene, instances, device)
