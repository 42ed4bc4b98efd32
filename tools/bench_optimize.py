"""Where the wall time of an optimisation goes: simulation, and what the host does before, between and after it.

    python tools/bench_optimize.py walk56 --search cma --population 5000 --generations 4 --device cuda:0
    python tools/bench_optimize.py fwalk --search random --population 500 --duration 1 --json bench.json

The real program runs, with a stopwatch around its parts. Compilation and imports come before the measurement. The
host's share is that of sampling, ranking and update of the covariance, files, and the parameters' way to the device.
"""

from __future__ import annotations

import contextlib
import functools
import json
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any

import msgspec
import typer
import warp as wp

from warpmuscle.cli.ending import run_script
from warpmuscle.formats import load
from warpmuscle.optimization import search_loop
from warpmuscle.optimization.optimize import optimize
from warpmuscle.optimization.replay import Replayer
from warpmuscle.results.checkpoint import Checkpoint
from warpmuscle.simulation.candidates import CandidateBatch

Seconds = dict[str, float]
PARTS: dict[str, list[tuple[Any, str]]] = {
    "sampling": [(search_loop, "ask_all"), (search_loop, "from_unit")],
    "ranking and update": [(search_loop, "tell_all")],
    "parameters to the device": [(CandidateBatch, "set_parameters")],
    "simulation": [(CandidateBatch, "run")],
    "files": [(Checkpoint, "put"), (Checkpoint, "finish")],
    "preparation": [(CandidateBatch, "__init__")],
    "replay of the best": [(Replayer, "replay")],
}
HOST = ("sampling", "ranking and update", "parameters to the device", "files", "everything else")


@contextlib.contextmanager
def stopwatch() -> Iterator[Seconds]:
    """Time spent in each of the parts, s; what one part does within another one counts for the inner one only."""
    spent: Seconds = defaultdict(float)
    running: list[float] = []  # time of the parts within those that run, innermost last

    def timed(part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(function)
        def call(*arguments: Any, **options: Any) -> Any:
            running.append(0.0)
            begin = time.perf_counter()
            try:
                return function(*arguments, **options)
            finally:
                took = time.perf_counter() - begin
                spent[part] += took - running.pop()
                if running:
                    running[-1] += took

        return call

    originals = [(part, owner, name, getattr(owner, name)) for part, places in PARTS.items() for owner, name in places]
    try:
        for part, owner, name, function in originals:
            setattr(owner, name, timed(part, function))
        yield spent
    finally:
        for _, owner, name, function in originals:
            setattr(owner, name, function)


def main(
    scene: str,
    search: Annotated[str, typer.Option(help="Strategy.")] = "cma",
    searches: Annotated[int, typer.Option(help="Independent ones.")] = 1,
    population: Annotated[int, typer.Option(help="Candidates a generation of each search.")] = 5000,
    generations: Annotated[int, typer.Option(help="How many.")] = 4,
    duration: Annotated[float | None, typer.Option(help="s of motion; by default the scene's.")] = None,
    device: Annotated[str | None, typer.Option(help="cpu, cuda:0, ...")] = None,
    json_path: Annotated[Path | None, typer.Option("--json", help="File for the figures.")] = None,
) -> None:
    """Print the parts of the wall time."""
    wp.config.log_level = wp.LOG_WARNING
    given = load(scene)
    given = msgspec.structs.replace(given, duration=duration or given.duration)
    short = msgspec.structs.replace(given, duration=0.1)
    candidates = population * searches * generations
    asked: dict[str, Any] = {"search": search, "searches": searches, "population": population}
    optimize(short, min(candidates, 2 * population * searches), 1, device, **asked)  # compiles and imports
    with tempfile.TemporaryDirectory() as folder, stopwatch() as spent:
        begin = time.perf_counter()
        result = optimize(given, candidates, 1, device, output=Path(folder) / "bench.h5", **asked)
        wall = time.perf_counter() - begin
        size = (Path(folder) / "bench.h5").stat().st_size
    assert result.evaluations is not None
    spent["everything else"] = wall - sum(spent.values())
    count, (rows, columns) = len(result.parameters.name), result.evaluations.params.shape
    print(
        f"{scene}: {rows} candidates of {count} parameters in {generations} generations, {result.device}, {wall:.2f} s"
    )
    for part, seconds in sorted(spent.items(), key=lambda item: -item[1]):
        print(f"  {seconds:9.3f} s {100 * seconds / wall:6.2f} %  {part}")
    host = sum(spent[part] for part in HOST) / wall
    motion = result.evaluations.end_time.sum()
    steps = motion / given.time_step / spent["simulation"]
    beyond = size / rows - 8 * columns
    print(f"host {100 * host:.1f} %; {motion:.0f} s of motion, {steps / 1e6:.3g} M steps/s while simulating")
    print(f"{beyond:.0f} bytes a candidate beyond its parameters' {8 * columns}; least cost {result.best.cost:.6g}")
    if json_path is not None:
        figures = {"scene": scene, "device": result.device, "candidates": rows, "wall_s": wall, "host": host}
        json_path.write_text(json.dumps(figures | {"seconds": dict(spent)}, indent=2) + "\n")


if __name__ == "__main__":
    run_script(main)
