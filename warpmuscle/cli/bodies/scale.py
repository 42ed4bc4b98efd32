"""The command that gives a body another size."""

from __future__ import annotations

from typing import Annotated

import typer

from warpmuscle.cli.common import SceneFile, Settings, Sources, Trust, command_line, load_scene, writable_beside
from warpmuscle.cli.console import out, suggest

Factors = Annotated[
    list[str] | None,
    typer.Option("--length", metavar="BODY=FACTOR", help="Further factor on the length of bodies, such as *arm=1.2."),
]
Masses = Annotated[
    list[str] | None,
    typer.Option("--weight", metavar="BODY=FACTOR", help="Share of bodies in the mass, such as torso=1.3."),
]


def scale(
    sources: Sources,
    output: SceneFile,
    height: Annotated[float | None, typer.Option(help="Height of the body, m; by default unchanged.")] = None,
    mass: Annotated[float | None, typer.Option(help="Mass of the body, kg; by default that of the same build.")] = None,
    lengths: Factors = None,
    masses: Masses = None,
    gait: Annotated[
        bool, typer.Option("--gait/--no-gait", help="Whether gains, times and speeds grow with the body.")
    ] = True,
    settings: Settings = None,
    trust: Trust = False,
) -> None:
    """Give a body another height and mass, with its muscles and its gait.

    Lengths grow with the height, strengths with the mass, gains, times and speeds by dynamic similarity. Examples:
    warpmuscle scale fwalk --height 1.3 --mass 28 -o child.toml; warpmuscle scale fwalk --length '*arm=1.2' -o ape.toml
    """
    from warpmuscle.core.files import replace_file
    from warpmuscle.formats import toml
    from warpmuscle.scene.masses import body_mass
    from warpmuscle.scene.parameters import at_start
    from warpmuscle.scene.sizes.sized import height_of, sized
    from warpmuscle.scene.validation.scene import check_scene

    writable_beside(sources, output)
    scene = load_scene(sources, settings=settings)
    made = sized(
        scene, height, mass, lengths=_factors(lengths, "--length"), masses=_factors(masses, "--weight"), gait=gait
    )
    check_scene(made)
    replace_file(output, f"# By `{command_line()}`.\n\n{toml.dumps(made)}")
    plain = at_start(made)
    out.print(f"wrote {output}: {height_of(made):.3g} m, {body_mass(plain.character):.4g} kg", markup=False)
    suggest(f"`warpmuscle simulate {output}` runs it")


def _factors(given: list[str] | None, option: str) -> dict[str, float]:
    """Factors by pattern, from NAME=NUMBER each."""
    from warpmuscle.core.errors import Error

    found = {}
    for text in given or []:
        pattern, equals, number = (part.strip() for part in text.partition("="))
        try:
            found[pattern] = float(number)
        except ValueError:
            equals = ""
        if not (pattern and equals):
            raise Error(f"{option} takes BODY=FACTOR, such as '*arm=1.2', not {text!r}")
    return found
