"""Damages recordings as laboratories do, and demands that `warpmuscle inverse` says what is wrong and what follows.

Gaps, swapped labels, other units and axes, loads of another time, EMG at another rate, columns that stand twice, files
that end early, counts that are wrong, times out of order, bytes that are no text, blocks of C3D: each case must end
with one line of error that names the file, or a note that names the consequence, or a result that is as without the
damage. No traceback, no number that is not finite, no file half written, an end within 20 s. The same seed gives the
same cases. Sound recordings are OpenSim's walk, in the folder that WARPMUSCLE_REFERENCE_DATA names.

python tools/damage.py                             300 cases, a table by kind, what failed and how to repeat it
python tools/damage.py --kinds markers,c3d         of some kinds
python tools/damage.py --case loads:17 --keep out  one case, whose files stay in a folder
"""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path
from typing import Annotated

import typer
from damaging.cases import KINDS, Case, cases, run
from damaging.trial import Trial, read_trial
from fuzzing.judge import Verdict

from warpmuscle.cli.ending import run_script


def damage(
    count: Annotated[int, typer.Option("--cases", min=1, help="How many.")] = 300,
    seed: Annotated[int, typer.Option(help="Of all cases.")] = 1,
    kinds: Annotated[str, typer.Option(help=f"Some of {', '.join(KINDS)}, separated by commas.")] = ",".join(KINDS),
    case: Annotated[str | None, typer.Option(metavar="KIND:NUMBER", help="Only this case.")] = None,
    keep: Annotated[Path | None, typer.Option(help="An empty folder in which the files stay.")] = None,
    loud: Annotated[bool, typer.Option("--loud", help="Print what is said in each case.")] = False,
) -> None:
    """Run the cases; exit code 1 if any of them fails."""
    chosen = kinds.split(",")
    if wrong := sorted(set(chosen) - set(KINDS)):
        raise typer.BadParameter(f"no kind is called {wrong[0]!r}; there are {', '.join(KINDS)}")
    if case is not None:
        kind, _, number = case.partition(":")
        chosen = [kind]
    folder = Path(os.environ.get("WARPMUSCLE_REFERENCE_DATA", "../shared/data")) / "opensim_walk"
    if not folder.is_dir():
        raise typer.BadParameter(f"{folder} is no folder; let WARPMUSCLE_REFERENCE_DATA name that of reference data")
    sound = read_trial(
        folder / "subject01.osim", folder / "subject01_walk.trc", folder / "ik/subject01_walk_IK.mot",
        folder / "subject01_walk_grf.xml",
    )  # fmt: skip
    some = cases(count, chosen, seed) if case is None else [Case(chosen[0], int(number), seed)]
    with tempfile.TemporaryDirectory(prefix="damage-") as temporary:
        failed = _run(some, sound, Path(temporary) if keep is None else keep.resolve(), loud or case is not None)
    raise typer.Exit(int(failed > 0))


def _run(some: list[Case], sound: Trial, work: Path, loud: bool) -> int:
    """Run cases, tell of failures as they come, and print the table; how many failed."""
    wanted, verdicts, begin = {}, dict[Case, Verdict](), time.monotonic()
    for kind in dict.fromkeys(case.kind for case in some):
        verdict = run(Case(kind, 0, 0), sound, work / f"{kind}-sound", None)
        wanted[kind] = work / f"{kind}-sound" / "case" / "out.h5"
        if verdict.complaints or verdict.refused:
            raise SystemExit(f"the sound recordings fail: {verdict.complaints} {verdict.said}")
        if loud:
            print(f"{kind}, sound: {verdict.said.strip()}")
    for case in some:
        verdict = verdicts[case] = run(case, sound, work / f"{case.kind}-{case.number}", wanted[case.kind])
        name = f"{case.kind}:{case.number} {case.damage.name}"
        if verdict.complaints:
            print(f"FAILED --seed {case.seed} --case {name}", *verdict.complaints, sep="\n  ", flush=True)
        elif loud:
            print(f"{name}: {verdict.said.strip() or 'nothing, and it is as the sound one'}", flush=True)
    print("\nkind         cases  refused  noted  as sound  failed  slowest, s")
    for kind in wanted:
        mine = [verdict for case, verdict in verdicts.items() if case.kind == kind]
        failed = sum(bool(one.complaints) for one in mine)
        refused = sum(one.refused for one in mine)
        noted = sum(not one.refused and "note:" in one.said for one in mine)
        counts = (len(mine), refused, noted, len(mine) - refused - noted, failed)
        cells = "  ".join(f"{count:>{width}}" for count, width in zip(counts, (5, 7, 5, 8, 6), strict=True))
        print(f"{kind:11}  {cells}  {max(one.seconds for one in mine):10.1f}")
    failed = sum(bool(one.complaints) for one in verdicts.values())
    print(f"{len(verdicts)} cases in {time.monotonic() - begin:.0f} s, {failed} failed")
    return failed


if __name__ == "__main__":
    run_script(damage)
