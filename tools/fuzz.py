"""Gives mutated inputs of every kind to the command line, and demands that it bears them.

For every case the commands that a user would give run in a folder of their own. What is demanded: exit code 0 or 2, one
line of error with the latter, no traceback, no warning of Python's, no number in an output that is not finite, no file
left half written or outside of the folder, nothing read from other files, and an end within 20 s. Inputs are mutated
from what warpmuscle itself writes, and from files of the original program if WARPMUSCLE_REFERENCE_DATA names a folder
with them. The same seed gives the same cases.

python tools/fuzz.py                                     3000 cases, a table by kind, what failed and how to repeat it
python tools/fuzz.py --cases 300 --kinds simbicon        of one kind, or several separated by commas
python tools/fuzz.py --case simbicon:17                  one case, whose input stays in the folder `fuzz`
"""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path
from typing import Annotated

import typer
from fuzzing.judge import Verdict
from fuzzing.kinds import KINDS, WITHOUT_SEEDS, Setting, make, shares
from fuzzing.pool import Case, Settings, prepare, run_all, run_case
from fuzzing.seeds import make_seeds

from warpmuscle.cli.ending import run_script


def fuzz(
    cases: Annotated[int, typer.Option(min=1, help="How many, shared out among the kinds.")] = 3000,
    seed: Annotated[int, typer.Option(help="Of all cases.")] = 1,
    kinds: Annotated[str, typer.Option(help=f"Some of {', '.join(KINDS)}, separated by commas.")] = ",".join(KINDS),
    processes: Annotated[int, typer.Option(min=1, help="How many cases run at the same time.")] = os.cpu_count() or 1,
    case: Annotated[str | None, typer.Option(metavar="KIND:NUMBER", help="Only this case; its input is kept.")] = None,
    compiling: Annotated[
        bool, typer.Option("--compile", help="Compile kernels, rather than leave out the cases that need others.")
    ] = False,
    folder: Annotated[Path | None, typer.Option(help="Where to work; by default a folder that is removed.")] = None,
) -> None:
    """Run the cases; exit code 1 if any of them fails."""
    reference = Path(os.environ.get("WARPMUSCLE_REFERENCE_DATA", "")) / "simbicon"
    wrong = sorted(set(kinds.split(",")) - set(KINDS))
    if wrong:
        raise typer.BadParameter(f"no kind is called {wrong[0]!r}; there are {', '.join(KINDS)}")
    with tempfile.TemporaryDirectory(prefix="fuzz-") as temporary:
        work = Path(temporary) if folder is None else folder.resolve()
        seeds = work / "seeds"
        seeds.mkdir(parents=True, exist_ok=True)
        wanted = {case.partition(":")[0]} if case is not None else set(kinds.split(","))
        if not wanted <= WITHOUT_SEEDS:  # which takes minutes
            make_seeds(seeds)
        settings = Settings(seed, seeds, work, reference if reference.is_dir() else None, compiling)
        if case is not None:
            raise typer.Exit(_one(case, settings))
        numbers = shares(cases)
        chosen = [(kind, number) for kind in kinds.split(",") for number in range(numbers[kind])]
        raise typer.Exit(_many(chosen, settings, processes))


def _one(text: str, settings: Settings) -> int:
    """Run one case and keep its input."""
    kind, _, number = text.partition(":")
    kept = Path("fuzz").resolve()
    inputs = kept / "input"
    inputs.mkdir(parents=True, exist_ok=True)
    at = Setting(inputs, settings.seeds, settings.work / "secret.h5", settings.reference)
    for command in make(kind, int(number), settings.seed, at):
        print("warpmuscle", " ".join(command))
    print(f"in {inputs}")
    prepare(settings)
    verdict = run_case((kind, int(number)), settings)
    print("\n".join(verdict.complaints) or ("needs another kernel" if verdict.skipped else "as it should be"))
    return int(bool(verdict.complaints))


def _many(chosen: list[Case], settings: Settings, processes: int) -> int:
    """Run cases, tell of failures as they come, and print the table."""
    begin, verdicts = time.monotonic(), dict[Case, Verdict]()
    for (kind, number), verdict in run_all(chosen, settings, processes):
        verdicts[kind, number] = verdict
        if verdict.complaints:
            print(f"FAILED --seed {settings.seed} --case {kind}:{number}", *verdict.complaints, sep="\n  ", flush=True)
    print("\nkind              cases  refused  not run  failed   all, s  slowest, s")
    for kind in dict.fromkeys(kind for kind, _ in chosen):
        mine = [verdict for (other, _), verdict in verdicts.items() if other == kind]
        counts = [len(mine), *(sum(map(test, mine)) for test in (_refused, _skipped, _failed))]
        cells = "  ".join(f"{count:>{width}}" for count, width in zip(counts, (5, 7, 7, 6), strict=True))
        seconds = [verdict.seconds for verdict in mine]
        print(f"{kind:16}  {cells}  {sum(seconds):7.1f}  {max(seconds):10.1f}")
    failed = sum(map(_failed, verdicts.values()))
    print(f"{len(verdicts)} cases in {time.monotonic() - begin:.0f} s, {failed} failed")
    return int(failed > 0)


def _refused(verdict: Verdict) -> bool:
    return verdict.refused


def _skipped(verdict: Verdict) -> bool:
    return verdict.skipped


def _failed(verdict: Verdict) -> bool:
    return bool(verdict.complaints)


if __name__ == "__main__":
    run_script(fuzz)
