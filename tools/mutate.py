"""Changes the source of the physics in small ways, and names the changes that no test sees.

A mutation is one small change in the kernels, the model, gait or studies: a constant times 1.25, a sum for a
difference, a term left out or doubled, sine for cosine, arguments swapped, a statement removed. It is tried in a copy
of the repository, without reference data: the test file that mirrors the module runs first, then those that import
it, until one fails. What no test sees is a hole in the tests, or makes no difference. A test counts only if it passes
without the mutation.

python tools/mutate.py                              50 mutations; survivors are named, with file, line and change
python tools/mutate.py --sample 300 --seed 2 -j 16 --minutes 9     stops after 9 minutes; the same command goes on
python tools/mutate.py --only gait/measures --sample 1000          all that can be thought of in one file
python tools/mutate.py --again                      survivors of the results once more, after tests were added
"""

from __future__ import annotations

import json
import multiprocessing
import os
import queue
import sys
import tempfile
import time
from pathlib import Path
from typing import Annotated, Any

import typer
from mutations.changes import Mutation, all_mutations, sample
from mutations.trial import Outcome, Trial

from warpmuscle.cli.ending import run_script

ROOT = Path(__file__).resolve().parents[1]


def mutate(
    count: Annotated[int, typer.Option("--sample", min=1, help="How many mutations.")] = 50,
    seed: Annotated[int, typer.Option(help="Of the choice.")] = 1,
    only: Annotated[str | None, typer.Option(help="Files whose path contains this.")] = None,
    workers: Annotated[int, typer.Option("-j", min=1, help="Mutations at a time.")] = os.cpu_count() or 1,
    limit: Annotated[float, typer.Option(min=1.0, help="Seconds for a mutation.")] = 300.0,
    minutes: Annotated[float | None, typer.Option(help="Stop by then; the same command goes on.")] = None,
    most: Annotated[int | None, typer.Option(min=1, help="Test files for a mutation; by default all.")] = None,
    output: Annotated[Path, typer.Option("-o", help="Results, which are gone on with; beside it a page.")] = Path(
        "mutations.json"
    ),
    listing: Annotated[bool, typer.Option("--list", help="Only print the mutations.")] = False,
    again: Annotated[bool, typer.Option("--again", help="Try once more what survived or had no time.")] = False,
    scratch: Annotated[
        Path | None, typer.Option(help="Folder to work in; its kernels are kept. By default it is removed.")
    ] = None,
) -> None:
    """Try mutations; exit code 1 if one survives, 3 if time was over before all were tried."""
    if only is not None and not (found := all_mutations(ROOT, only)):
        raise typer.BadParameter(f"no file of physics that can be mutated has {only!r} in its path")
    chosen = sample(found if only is not None else all_mutations(ROOT), count, seed)
    if listing:
        for mutation in chosen:
            print(_told(mutation))
        return
    results: dict[str, dict[str, Any]] = json.loads(output.read_text()) if output.exists() else {}
    wanted = ("survived", "unfinished") if again else (None,)
    waiting = [m for m in chosen if results.get(m.name, {}).get("status") in wanted]
    end = None if minutes is None else time.monotonic() + 60.0 * minutes
    with tempfile.TemporaryDirectory(prefix="mutations-") as temporary:
        folder = (scratch or Path(temporary)).resolve()
        _check(folder)
        for outcome in _tried(waiting, workers, folder, (limit, most, end)):
            results[outcome.mutation.name] = outcome.as_dict()
            _write(output, json.dumps(results, indent=1))
            cost = f"{outcome.seconds:.0f} s, {outcome.cpu:.0f} s CPU"
            print(f"{outcome.status:10} {_told(outcome.mutation)}  [{outcome.by}; {cost}]", flush=True)
    mine = [results[m.name] for m in chosen if m.name in results]
    _write(output.with_suffix(".md"), _page(mine))
    lived = [result for result in mine if result["status"] != "caught"]
    print(f"{len(mine)} of {len(chosen)} tried: {len(mine) - len(lived)} caught; {output.with_suffix('.md')}")
    raise typer.Exit(3 if len(mine) < len(chosen) else int(bool(lived)))


def _check(folder: Path) -> None:
    """Exit with one sentence if tests cannot run here at all: then every mutation would count as caught."""
    try:
        Trial(ROOT, folder / "worker0", folder / "kernels").check()
    except RuntimeError as error:
        print(error, file=sys.stderr)
        raise typer.Exit(2) from None


def _tried(waiting: list[Mutation], workers: int, folder: Path, bounds: tuple[float, int | None, float | None]) -> Any:
    """Outcomes, as they come, of mutations tried in several processes, each in a copy of its own."""
    context = multiprocessing.get_context("spawn")
    todo, done = context.Queue(), context.Queue()
    workers = min(workers, len(waiting))
    for mutation in waiting:
        todo.put(mutation)
    processes = [context.Process(target=_work, args=(todo, done, folder, k, *bounds)) for k in range(workers)]
    for process in processes:
        process.start()
    try:
        while any(process.is_alive() for process in processes) or not done.empty():
            try:
                yield done.get(timeout=1.0)
            except queue.Empty:
                continue
    finally:
        todo.cancel_join_thread()
        for process in processes:
            process.terminate()
            process.join()


def _work(todo: Any, done: Any, folder: Path, number: int, limit: float, most: int | None, end: float | None) -> None:
    """What a process does: take mutations until there are none, or no time. `time.monotonic` is the machine's."""
    os.nice(5)
    trial = Trial(ROOT, folder / f"worker{number}", folder / "kernels")
    while True:
        try:
            mutation = todo.get(timeout=1.0)
        except queue.Empty:
            return
        left = limit if end is None else min(limit, end - time.monotonic())
        if left <= 0.0:
            return
        outcome: Outcome = trial.try_one(mutation, left, most)
        if outcome.status != "unfinished" or left == limit:  # else it had not its time, and comes again
            done.put(outcome)


def _told(mutation: Mutation) -> str:
    before, after = (" ".join(text.split()) for text in (mutation.before, mutation.after))
    return f"{mutation.path}:{mutation.line} {mutation.kind}: {before} -> {after}"


def _page(results: list[dict[str, Any]]) -> str:
    """Survivors as a table in Markdown, after the sum."""
    lived = [r for r in results if r["status"] != "caught"]
    seconds = sum(r["cpu"] for r in results) / max(len(results), 1)
    lines = [f"{len(results)} mutations, {len(results) - len(lived)} caught, {seconds:.0f} s CPU each on average", ""]
    lines += ["| where | what | before | after | |", "|---|---|---|---|---|"]
    for result in lived:
        m = result["mutation"]
        texts = (" ".join(m[key].split()).replace("|", "\\|") for key in ("before", "after"))
        before, after = (f"`{text}`" for text in texts)
        note = result["status"] + (f" in `{result['by']}`" if result["by"] else "")
        lines.append(f"| `{m['path']}:{m['line']}` | {m['kind']} | {before} | {after} | {note} |")
    return "\n".join(lines) + "\n"


def _write(path: Path, text: str) -> None:
    """Write a file whole or not at all."""
    partial = path.with_name(path.name + ".partial")
    partial.write_text(text)
    partial.replace(path)


if __name__ == "__main__":
    run_script(mutate)
