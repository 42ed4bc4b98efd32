"""Time that searches take for themselves, without any evaluation: to sample a generation, and to learn from its costs.

    python tools/bench_ask_tell.py
    python tools/bench_ask_tell.py --parameters 148,300 --populations 50,500,5000 --json bench.json

Also the time of one evaluation's way into NLopt's thread and back, and of a generation of many small searches.
"""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from warpmuscle.cli.ending import run_script
from warpmuscle.core.array_types import Floats
from warpmuscle.search.batched import ask_all, tell_all
from warpmuscle.search.search import Search
from warpmuscle.search.strategies import make_search, make_searches


def ellipsoid(candidates: Floats) -> Floats:
    """A function whose axes differ by a factor of a hundred, so that the covariance matters."""
    weight = np.logspace(0.0, 4.0, candidates.shape[1])
    return np.asarray(np.sum(weight * (candidates - 0.3) ** 2, axis=1))


def times(searches: list[Search], generations: int) -> tuple[float, float]:
    """Milliseconds to ask and to tell a generation of all searches, on average: the covariance is decomposed lazily."""
    asking, telling = [], []
    for _ in range(generations):
        begin = time.perf_counter()
        batch = ask_all(searches)
        asked = time.perf_counter()
        costs = ellipsoid(batch.candidates)
        evaluated = time.perf_counter()
        tell_all(searches, batch, costs)
        asking.append(asked - begin)
        telling.append(time.perf_counter() - evaluated)
    return 1e3 * float(np.mean(asking[1:])), 1e3 * float(np.mean(telling[1:]))


def main(
    parameters: Annotated[str, typer.Option(help="Numbers of parameters, separated by commas.")] = "148,300",
    populations: Annotated[str, typer.Option(help="Candidates of a generation, separated by commas.")] = "50,500,5000",
    generations: Annotated[int, typer.Option(help="Generations to average over, after a first one.")] = 20,
    json_path: Annotated[Path | None, typer.Option("--json", help="File for the figures.")] = None,
) -> None:
    """Time the searches."""
    figures: dict[str, dict[str, float]] = {}

    def show(name: str, searches: list[Search], count: int) -> None:
        ask, tell = times(searches, count + 1)
        figures[name] = {"ask_ms": ask, "tell_ms": tell}
        print(f"{name:50s} ask {ask:9.3f} ms   tell {tell:9.3f} ms", flush=True)

    for dimensions in map(int, parameters.split(",")):
        for population in map(int, populations.split(",")):
            search = make_search("cma", dimensions, None, 1, population=population)
            show(f"cma, {dimensions} parameters, population {population}", [search], generations)
        show(f"64 cma searches, {dimensions} parameters", make_searches("cma", dimensions, None, 1, 64), generations)
        several = make_searches("cma", dimensions, None, 1, 5, population=128)
        show(f"5 cma searches, {dimensions} parameters, population 128", several, generations)
        islands = make_search("islands", dimensions, None, 1, population=640)
        show(f"islands, {dimensions} parameters, population 640", [islands], generations)
        show(f"nlopt:LN_SBPLX, {dimensions} parameters", [make_search("nlopt:LN_SBPLX", dimensions, None, 1)], 1000)
    if json_path is not None:
        json_path.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    run_script(main)
