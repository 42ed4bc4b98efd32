"""The command that judges the muscles of a moving body."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import Device, JsonFile, Settings, Threads, Trust, start_warp, writable
from warpmuscle.cli.console import log, out, print_table
from warpmuscle.cli.walkers import Walkers, walker_of
from warpmuscle.core.plain_text import number_of

if TYPE_CHECKING:
    from warpmuscle.creatures.judge import Plausibility

SECONDS = 10.0


def judge(
    sources: Walkers,
    settings: Settings = None,
    duration: Annotated[float, typer.Option(min=0.1, help="Of the motion that is judged, s.")] = SECONDS,
    device: Device = None,
    threads: Threads = None,
    trust: Trust = False,
    output: JsonFile = None,
) -> None:
    """Judge whether the muscles of a body that moves could be those of an animal.

    No muscle goes through the centre of a joint, moment arms, fibre lengths and forces are within bounds. Examples:
    warpmuscle creature judge walker16; warpmuscle creature judge found.h5
    """
    writable(output)
    start_warp()
    from warpmuscle.core.files import replace_file
    from warpmuscle.core.status import Status
    from warpmuscle.creatures.judge import plausibility
    from warpmuscle.simulation.perturbations import none

    name, walker = walker_of(sources, settings=settings, device=device, threads=threads)
    with log.status("simulating, which may compile for some seconds"):
        walks = walker.walk(duration, none(1), record=True)
    found = plausibility(walker.scene(), walks.recordings[0])
    end = "lasted" if walks.upright[0] else f"ended by {Status(int(walks.status[0])).name.lower()}"
    out.print(f"{name}: {end}, {float(walks.end_time[0]):.3g} s", markup=False)
    _print(found)
    if output is not None:
        replace_file(output, json.dumps(asdict(found), indent=1).encode() + b"\n")
        out.print(f"wrote {output}", markup=False)


def _print(found: Plausibility) -> None:
    """Tables of joints and muscles, and what is in doubt."""
    rows = [
        (one.muscle, one.joint, f"{1e3 * one.least:.1f}", f"{1e3 * one.greatest:.1f}", f"{1e3 * one.longest:.0f}")
        for one in found.crossings
    ]
    print_table(("muscle", "joint", "arm from, mm", "to, mm", "at most, mm"), rows, ("muscle", "joint"))
    uses = [
        (one.muscle, f"{one.shortest:.2f}", f"{one.longest:.2f}", f"{one.force:.2f}", f"{one.strength:.1f}")
        for one in found.muscles
    ]
    print_table(("muscle", "fibre from, l_opt", "to, l_opt", "force, f_max", "f_max, body weights"), uses, ("muscle",))
    out.print(f"muscles are {100.0 * found.muscle_share:.1f} % of the body", markup=False)
    for doubt in found.doubts:
        out.print(doubt, style="yellow", markup=False)
    out.print(
        f"{number_of(len(found.doubts), 'thing')} that no animal has" if found.doubts else "nothing that no animal has",
        style="" if found.doubts else "green",
    )
