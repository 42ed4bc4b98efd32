"""What the files of a very long search cost: size of its journal, time a candidate, and going on after a kill.

    python tools/bench_journal.py
    python tools/bench_journal.py --candidates 20000 --population 100

Candidates get their costs from a formula instead of a simulation, so that nothing but the search and its files takes
time. One process runs a search to its end. Another one runs the same search, and is killed (SIGKILL) after a part of
its generations; what it left is resumed. Both results must be the same to the bit, or this ends with exit code 1.
"""

from __future__ import annotations

import os
import resource
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
import typer

from warpmuscle.cli.ending import run_script
from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.optimization.evaluation import Generation
from warpmuscle.optimization.optimize import optimize
from warpmuscle.optimization.progress import Tracker
from warpmuscle.optimization.resume import resume
from warpmuscle.results.journal import journal_path
from warpmuscle.results.records import TABLE, Evaluations
from warpmuscle.results.result import read
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import free_parameters

TERM = "speed"


class Formula:
    """Costs without a simulation: the mean square distance from a point; it looks at the journal as it goes.

    Attributes:
        device, largest, at_once, term_names: as of `GenerationEvaluator`.
        most: bytes of the journal at most. appended: bytes that it grew by, in all. evaluated: candidates.
    """

    device, largest, at_once = "cpu", 1_000_000, 0
    term_names: tuple[str, ...] = (TERM,)

    def __init__(self, scene: Scene, output: Path, kill_after: int | None = None) -> None:
        """Prepare; `kill_after` so many generations the process kills itself."""
        parameters = free_parameters(scene)
        self._low = np.array([one.min for one in parameters])
        self._range = np.array([one.max - one.min for one in parameters])
        self._journal, self._kill_after = journal_path(output), kill_after
        self.most = self.appended = self._last = self.evaluated = 0

    def evaluate(self, generation: Generation, limit: int, tracker: Tracker, enough: Callable[[], Any]) -> None:
        """Give costs to what is missing of a generation."""
        self.look()
        if generation.number == self._kill_after:
            os.kill(os.getpid(), signal.SIGKILL)
        rows = generation.missing()[:limit]
        away = (generation.values[rows] - self._low) / self._range - 0.6
        generation.cost[rows] = generation.terms[rows, 0] = (away**2).mean(axis=1)
        generation.end_time[rows], generation.status[rows] = 1.0, Status.COMPLETED
        self.evaluated += len(rows)
        tracker.counted(len(rows), float(generation.cost[rows].min()), float(len(rows)))

    def look(self) -> None:
        """Note how large the journal is."""
        size = self._journal.stat().st_size if self._journal.exists() else 0
        self.most, self.appended = max(self.most, size), self.appended + max(size - self._last, 0)
        self._last = size

    def keep_motion(self, candidates: int) -> bool:
        """Nothing moves."""
        return False

    def motion(self, values: np.ndarray) -> None:
        """Nothing moves."""


def differing(one: Evaluations, other: Evaluations) -> list[str]:
    """Columns of two tables of candidates whose bits differ."""
    return [name for name in TABLE if getattr(one, name).tobytes() != getattr(other, name).tobytes()]


def killed(work: Callable[[], object]) -> None:
    """Do something in a process of its own, which must end by SIGKILL."""
    child = os.fork()
    if child == 0:
        work()
        os._exit(0)
    _, status = os.waitpid(child, 0)
    if not os.WIFSIGNALED(status) or os.WTERMSIG(status) != signal.SIGKILL:
        raise SystemExit(f"the search that was to be killed ended by itself: {status}")


def main(
    scene: Annotated[str, typer.Option(help="Whose parameters are searched.")] = "fwalk",
    candidates: Annotated[int, typer.Option(help="In all.")] = 1_000_000,
    search: Annotated[str, typer.Option(help="Strategy.")] = "islands",
    population: Annotated[int, typer.Option(help="Candidates of a generation.")] = 400,
    part: Annotated[float, typer.Option(help="Of the generations, after which the second search is killed.")] = 0.7,
) -> None:
    """Print sizes and times."""
    given = msgspec.structs.replace(load(scene), duration=0.01)  # of the best one, which is replayed
    asked: dict[str, Any] = {"search": search, "population": population, "device": "cpu"}
    with tempfile.TemporaryDirectory() as folder:
        plain, torn = Path(folder) / "plain.h5", Path(folder) / "killed.h5"
        optimize(given, 2 * population, 1, output=Path(folder) / "first.h5", **asked)  # compiles and imports
        formula = Formula(given, plain)
        begin, cpu = time.perf_counter(), time.process_time()
        optimize(given, candidates, 1, output=plain, batches=lambda _: formula, **asked)
        wall, cpu = time.perf_counter() - begin, time.process_time() - cpu
        count = formula.evaluated
        print(
            f"{count} candidates, {population} a generation: {wall:.1f} s, {1e6 * cpu / count:.1f} us of processor "
            f"time each; the journal had {formula.most / 1e6:.1f} MB at most, {formula.appended / count:.0f} bytes a "
            f"candidate; the file has {plain.stat().st_size / 1e6:.1f} MB"
        )
        after = int(part * candidates / population)
        sys.stdout.flush()
        killed(
            lambda: optimize(given, candidates, 1, output=torn, batches=lambda _: Formula(given, torn, after), **asked)
        )
        again, begin = Formula(given, torn), time.perf_counter()
        left = journal_path(torn).stat().st_size
        resume(torn, batches=lambda _: again)
        print(
            f"killed after {after} generations, with {left / 1e6:.1f} MB in the journal; {again.evaluated} candidates "
            f"were left, and all was done {time.perf_counter() - begin:.1f} s after going on"
        )
        begin = time.perf_counter()
        one, other = read(plain).evaluations, read(torn).evaluations
        print(f"a file is read in {(time.perf_counter() - begin) / 2.0:.1f} s")
        assert one is not None
        assert other is not None
        wrong = differing(one, other)
    print(f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB of memory at most")
    if wrong:
        raise SystemExit(f"after the kill other bits came out: {', '.join(wrong)}")
    print("both results are the same to the bit")


if __name__ == "__main__":
    run_script(main)
