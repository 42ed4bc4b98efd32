"""The command that says what joints transmit in a simulated run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from warpmuscle.cli.common import Device, Trust, command_line, start_warp, writable, writable_folder
from warpmuscle.cli.console import log, out
from warpmuscle.cli.results import Replay, Run
from warpmuscle.core.plain_text import number_of

if TYPE_CHECKING:
    from warpmuscle.inverse.reactions.joint_reactions import JointReactions


def reactions(
    result: Annotated[Path, typer.Argument(help="HDF5 file with a recorded motion of a simulation.")],
    on: Annotated[str, typer.Option(help="Body that joints act on: child or parent.")] = "child",
    frame: Annotated[str, typer.Option(help="Axes of forces and moments: child, parent or ground.")] = "child",
    sto: Annotated[Path | None, typer.Option("--sto", help="Folder for a .sto file with OpenSim's names.")] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="HDF5 file of all frames.")] = None,
    replay: Replay = 0,
    run: Run = None,
    device: Device = None,
    trust: Trust = False,
) -> None:
    """Find the forces that bones put on each other in a simulated run, while its muscles pull and the ground pushes.

    The table has the force of each joint over body weight: in the mean, and its greatest with its time. Examples:
    warpmuscle simulate gait2392_stand -o stand.h5; warpmuscle reactions stand.h5 --frame child --sto .
    """
    writable(output)
    writable_folder(sto, "--sto")
    start_warp()
    import numpy as np

    from warpmuscle.inverse.output import Trial, write_result, write_storages
    from warpmuscle.inverse.reactions.run_reactions import run_reactions
    from warpmuscle.inverse.trial import Coordinates
    from warpmuscle.optimization.best_scene import scene_in
    from warpmuscle.results.partial_motion import motion_of
    from warpmuscle.results.result import read

    content = read(result, run, replay=replay)
    motion, scene = motion_of(content, str(result), replay), scene_in(content)
    with log.status("computing; kernels that are new are compiled first"):
        found = run_reactions(scene, motion, on=on, frame=frame, device=device, trust=trust)
    _tell(found.reactions, found.weight, float(found.residual.max(initial=0.0)))
    own = found.reactions
    trials = [Trial(result.stem, Coordinates((), own.times, np.zeros((len(own.times), 0))), reactions=own)]
    if output is not None:
        write_result(output, trials, {"command": command_line(), "model": str(result), "steps": "jr"})
        out.print(f"wrote {output}", markup=False)
    if sto is not None:
        out.print(f"wrote {number_of(len(write_storages(sto, trials)), 'file')} to {sto}", markup=False)


def _tell(found: JointReactions, weight: float, residual: float) -> None:
    """Print a line a joint, and what the root lacks if that is much."""
    import numpy as np

    share = np.linalg.norm(found.force, axis=2) / weight
    wide = max(map(len, found.joints), default=0)
    out.print(f"{'joint':{wide}}  mean  greatest, body weights", markup=False, highlight=False)
    for k, joint in enumerate(found.joints):
        top = int(share[:, k].argmax())
        line = f"{joint:{wide}}  {share[:, k].mean():4.2f}  {share[top, k]:4.2f} at {found.times[top]:.2f} s"
        out.print(line, markup=False, highlight=False)
    if residual > 0.01 * weight:
        out.print(
            f"note: up to {residual:.3g} N at the root come from what frames do not tell, such as water, objects, "
            "pushes, or bodies that touch each other",
            markup=False,
        )
