"""What a sweep of many short optimisations takes beside its simulations: time a run, to gather, to repeat; memory.

python tools/bench_sweep.py [--runs 1000] [--scene fwalk] [--axis KEY=MIN:MAX]
python tools/bench_sweep.py --gather 100000    # only gathering: so many result files, of real runs under many names
python tools/bench_sweep.py --gather 400 --candidates 3000 --population 48 --keep best    # and of long searches
python tools/bench_sweep.py --runs 100000 --candidates 4 --population 4 --duration 0.02 --processes 24    # real runs

Runs differ in their seeds, or with --axis in a number of the scene. What counts as simulation is the time in which
batches step; all else, from the sweep file to the last byte of its output, is beside it.
"""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import msgspec
import typer

from warpmuscle.cli.ending import run_script
from warpmuscle.core.plain_text import number_of
from warpmuscle.results.result import read as read_result
from warpmuscle.results.sweeps import read_sweep
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.sweep import run as run_module
from warpmuscle.sweep.finished import FinishedJournal
from warpmuscle.sweep.folder import MANIFEST, Folder, RunEntry
from warpmuscle.sweep.lockstep import LEAST_WINDOW
from warpmuscle.sweep.plan import read
from warpmuscle.sweep.run import sweep

TEXT = """
scene = "{scene}"
keep = "{keep}"
[set]
duration = {duration}
[search]
candidates = {candidates}
population = {population}
[grid]
{axes}
"""
WARM_UP = 2  # runs
REAL = 4800  # candidates of the runs of which others are copies


class Clock:
    """Wall time, and processor time of the process, that is spent within functions."""

    def __init__(self) -> None:
        self.seconds = self.cpu = 0.0

    @contextmanager
    def of(self, owner: Any, name: str) -> Any:
        """Count the time in a function of an object or class meanwhile."""
        function: Callable[..., Any] = getattr(owner, name)

        def timed(*arguments: Any, **options: Any) -> Any:
            begin, cpu = time.perf_counter(), time.process_time()
            try:
                return function(*arguments, **options)
            finally:
                self.seconds += time.perf_counter() - begin
                self.cpu += time.process_time() - cpu

        setattr(owner, name, timed)
        try:
            yield
        finally:
            setattr(owner, name, function)


class Peak:
    """The largest resident memory of this process while it is watched, MB, above what there was before."""

    def __enter__(self) -> Peak:
        self.before = self.most = _resident()
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()
        return self

    def _watch(self) -> None:
        while not self._end.wait(0.05):
            self.most = max(self.most, _resident())

    def __exit__(self, *what: object) -> None:
        self._end.set()
        self._thread.join()


def _resident() -> float:
    """Resident memory now, MB; on systems that do not say, the largest one so far."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def swept(folder: Path, name: str, text: str, device: str | None) -> tuple[Clock, Clock, Clock, float]:
    """What a sweep took: in all, for simulation, to gather; and peak memory in MB."""
    (folder / f"{name}.toml").write_text(text)
    whole, simulation, gathering = Clock(), Clock(), Clock()

    class Work:
        @staticmethod
        def all_of_it() -> None:
            sweep(read(folder / f"{name}.toml"), folder / f"{name}.h5", device=device)

    counted = simulation.of(Rollout, "advance"), gathering.of(run_module, "gather"), whole.of(Work, "all_of_it")
    with Peak() as peak, counted[0], counted[1], counted[2]:
        Work.all_of_it()
    return whole, simulation, gathering, peak.most


def gathered(folder: Path, count: int, text: str, candidates: int, device: str | None) -> None:
    """Print what gathering so many runs takes: files of real runs, each under many names."""
    some = min(count, max(REAL // candidates, 8))
    swept(folder, "some", text.format(axes=f"seed = {list(range(some))}"), device)
    (folder / "many.toml").write_text("")
    source, target = Folder.of(folder / "some.h5"), Folder.of(folder / "many.h5")
    target.path.mkdir()
    manifest = source.manifest()
    entries = []
    for number in range(count):
        first = manifest.runs[number % some]
        shutil.copyfile(source.result(first.name), target.result(f"seed={number}"))
        entries.append(RunEntry(f"seed={number}", first.digest, first.candidates, number, {"seed": float(number)}))
    results = [read_result(source.result(entry.name)) for entry in manifest.runs]
    journal = FinishedJournal(target.path)
    for first in range(0, count, LEAST_WINDOW):
        numbers = range(first, min(first + LEAST_WINDOW, count))
        journal.keep([(f"seed={n}", target.result(f"seed={n}"), results[n % some]) for n in numbers])
    manifest = msgspec.structs.replace(manifest, name="many", runs=tuple(entries))
    (target.path / MANIFEST).write_bytes(msgspec.json.encode(manifest))
    begin = time.perf_counter()
    with Peak() as peak:
        states = target.states(manifest)
        looked = time.perf_counter()
        run_module.gather(target, manifest, states, folder / "many.h5", "")
        done = time.perf_counter()
        target.remember(manifest, states, folder / "many.h5", "")
    size = (folder / "many.h5").stat().st_size
    print(f"gathering {number_of(count, 'run')}: looking into the files {looked - begin:.1f} s, writing "
          f"{done - looked:.1f} s, {1e3 * (done - begin) / count:.2f} ms a run; {size / 1e6:.0f} MB; "
          f"at most {peak.most:.0f} MB of memory, {peak.before:.0f} MB of them before")  # fmt: skip
    begin = time.perf_counter()
    target.is_gathered(manifest, target.states(manifest), folder / "many.h5", "")
    print(f"finding that all is there: {time.perf_counter() - begin:.2f} s")
    begin = time.perf_counter()
    read_sweep(folder / "many.h5").to_xarray()
    print(f"reading the table: {time.perf_counter() - begin:.2f} s")


def in_parts(folder: Path, text: str, runs: int, processes: int, device: str | None) -> None:
    """Print what the parts of a sweep take in processes side by side, and what it takes to join them."""
    path = folder / "runs.toml"
    path.write_text(text)
    tool = [sys.executable, "-c", "from warpmuscle.cli.program import main; main()"]
    options = [] if device is None else ["--device", device]

    def took(commands: list[list[str]]) -> str:
        begin, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        started = [subprocess.Popen([*tool, *words], cwd=folder, stdout=subprocess.DEVNULL) for words in commands]
        if max(process.wait() for process in started):
            raise SystemExit("a process failed")
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        wall = time.perf_counter() - begin
        return f"{wall:.1f} s, {cpu:.1f} s of processor time, {1e3 * cpu / runs:.2f} ms a run; " + (
            f"at most {after.ru_maxrss / 1e3:.0f} MB of memory in any process so far"
        )

    parts = [["sweep", path.name, "--part", f"{k}/{processes}", "--threads", "1", *options]
             for k in range(1, processes + 1)]  # fmt: skip
    print(f"{number_of(runs, 'run')} in {processes} processes: {took(parts)}", flush=True)
    print(f"joining them: {took([['join', path.name]])}; "
          f"{path.with_suffix('.h5').stat().st_size / 1e6:.0f} MB", flush=True)  # fmt: skip
    begin = time.perf_counter()
    with Peak() as peak:
        table = read_sweep(path.with_suffix(".h5")).to_xarray()
    print(f"reading the table: {time.perf_counter() - begin:.1f} s, {peak.most:.0f} MB; {dict(table.sizes)}")


def main(
    runs: Annotated[int, typer.Option(help="How many.")] = 1000,
    scene: Annotated[str, typer.Option(help="Scene.")] = "fwalk",
    duration: Annotated[float, typer.Option(help="Of a simulation, s.")] = 0.1,
    candidates: Annotated[int, typer.Option(help="Of a run.")] = 24,
    population: Annotated[int, typer.Option(help="Of a generation.")] = 6,
    axis: Annotated[str, typer.Option(help="KEY=MIN:MAX, a number in which runs differ; by default their seeds.")] = "",
    keep: Annotated[str, typer.Option(help="Candidates of a run: all, or best.")] = "all",
    gather: Annotated[int, typer.Option(help="Only gather so many runs.")] = 0,
    processes: Annotated[int, typer.Option(help="That run parts of the sweep side by side; 0: in this one.")] = 0,
    folder: Annotated[Path | None, typer.Option(help="For the files, a temporary one by default.")] = None,
    device: Annotated[str | None, typer.Option(help="cpu, cuda:0.")] = "cpu",
) -> None:
    """Print what a sweep takes beside its simulations."""
    text = TEXT.replace("{axes}", "{{axes}}").format(
        scene=scene, duration=duration, candidates=candidates, population=population, keep=keep
    )
    with tempfile.TemporaryDirectory(dir=folder) as name:
        place = Path(name)
        swept(place, "warm", text.format(axes=f"seed = {list(range(WARM_UP))}"), device)
        if gather:
            gathered(place, gather, text, candidates, device)
            return
        axes = f"seed = {list(range(1, runs + 1))}"
        if axis:
            key, _, ends = axis.partition("=")
            low, high = map(float, ends.split(":"))
            axes = f'"{key}" = {[low + (high - low) * number / max(runs - 1, 1) for number in range(runs)]}'
        if processes:
            in_parts(place, text.format(axes=axes), runs, processes, device)
            return
        whole, simulated, written, memory = swept(place, "runs", text.format(axes=axes), device)
        print(f"{number_of(runs, 'run')} of {scene}, {candidates} candidates of {duration:g} s each, "
              f"at most {memory:.0f} MB of memory")  # fmt: skip
        for what, name in (("wall", "seconds"), ("processor", "cpu")):
            seconds, of_simulation, of_gathering = (getattr(clock, name) for clock in (whole, simulated, written))
            print(f"{what:>9} time: {seconds:7.1f} s; simulation {of_simulation:.1f} s; beside it "
                  f"{1e3 * (seconds - of_simulation) / runs:.1f} ms a run, of which gathering "
                  f"{1e3 * of_gathering / runs:.2f} ms ({of_gathering:.1f} s)")  # fmt: skip
        begin = time.perf_counter()
        sweep(read(place / "runs.toml"), place / "runs.h5", device=device)
        print(f"the finished command again: {time.perf_counter() - begin:.1f} s")


if __name__ == "__main__":
    run_script(main)
