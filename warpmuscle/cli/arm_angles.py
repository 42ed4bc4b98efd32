"""The command that turns markers on an arm into the angles that `warpmuscle throw fit` reads."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, cast

import typer

from warpmuscle.cli.console import log, marked, out
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of


def arm_angles(
    files: Annotated[list[Path], typer.Argument(metavar="MARKERS...", help=".trc, .c3d, .json or .csv files.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder in which to write a .csv for each file.")],
    marker: Annotated[
        list[str] | None, typer.Option(metavar="ROLE=NAME", help="The marker of a role, or NAME+NAME, their middle.")
    ] = None,
    side: Annotated[str, typer.Option(help="The arm that throws: right or left.")] = "right",
    up: Annotated[str, typer.Option(help="Axis of the files that points up: x, y, z, -x, -y or -z.")] = "z",
    forward: Annotated[str, typer.Option(help="Axis along which the throw goes.")] = "x",
    unit: Annotated[
        str | None, typer.Option(help="Unit of positions: m, cm, mm, ft or in; by default the file's.")
    ] = None,
    rate: Annotated[float, typer.Option(help="Samples per second of the written files.")] = 100.0,
    low_pass: Annotated[
        float, typer.Option(help="Cut-off of the low-pass filter of positions, Hz; 0 filters nothing.")
    ] = 8.0,
    before: Annotated[float, typer.Option(help="Time to keep before the fastest extension of the elbow, s.")] = 1.0,
    after: Annotated[float, typer.Option(help="Time to keep after it, s.")] = 0.5,
    whole: Annotated[bool, typer.Option("--whole", help="Keep everything, not only the throw.")] = False,
) -> int:
    """Turn markers on an arm and the trunk into angles over time, as files for `warpmuscle throw fit`.

    Roles and their usual markers (R and L change places with --side left): shoulder R_SHOULDER, elbow R_ELBOW, wrist
    R_WRIST, hand_thumb R_1STFINGER and hand_little R_5THFINGER (the first joints of these fingers), other_shoulder
    L_SHOULDER, hip R_HIP, other_hip L_HIP.

    Examples: warpmuscle arm-angles trial.json -o throws; warpmuscle arm-angles trial.trc -o throws --up y --forward x
    --marker elbow=RELB+RELBM --marker wrist=RWRA+RWRB
    """
    from warpmuscle.markers.arm import ROLES, Choices, Side, write_angles
    from warpmuscle.markers.arm import arm_angles as angles_of
    from warpmuscle.markers.files import read_markers

    if side not in ("right", "left"):
        raise Error(f"--side is right or left, not {side!r}")
    chosen = {}
    for text in marker or []:
        role, equals, name = text.partition("=")
        if not equals or not name.strip():
            raise Error(f"--marker {text!r}: say ROLE=NAME; roles are {', '.join(ROLES)}")
        chosen[role.strip()] = name.strip()
    choices = Choices(cast("Side", side), chosen, up, forward, rate, low_pass, None if whole else before, after)
    names = [path.stem for path in files]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise Error(f"two files are called {twice}; their angles would be written to the same place")
    if output.exists() and not output.is_dir():
        raise Error(f"--output names {output}, which is not a folder")
    failed = 0
    for path in files:
        try:
            found = angles_of(read_markers(path, unit), choices)
        except Error as error:
            log.print(marked("left out:", "yellow", f" {error}"))
            failed += 1
            continue
        output.mkdir(parents=True, exist_ok=True)
        target = output / f"{path.stem}.csv"
        write_angles(target, found)
        note = "" if whole else f", the throw at {found.release:.2f} s"
        out.print(f"wrote {target}: {number_of(len(found.time), 'sample')}{note}")
    if failed:
        raise Error(f"left out: {failed} of {number_of(len(files), 'file')}")
    return 0
