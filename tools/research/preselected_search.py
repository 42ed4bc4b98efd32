"""Whether islands find more if a model of the cost chooses among candidates before they are simulated.

For docs/how-to/choose-a-strategy.md.

    python tools/research/preselected_search.py fwalk --until 30 --seeds 3 --device cpu
    python tools/research/preselected_search.py run56_search --until 40 --factors 1,2,4 --json preselected.json

Each island asks for so many times its candidates, and passes on those that a ridge regression on linear and square
terms ranks best; it is fitted to the ranks of the latest candidates of all islands, in the coordinates in which the
island's own candidates are spread equally in all directions. With a factor of 1 it is the search as it is.
"""

from __future__ import annotations

import json
import time
import warnings
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
import typer
import warp as wp
from numpy.typing import ArrayLike

from warpmuscle.cli.ending import run_script
from warpmuscle.core.array_types import Floats
from warpmuscle.formats import load
from warpmuscle.optimization.optimize import optimize
from warpmuscle.optimization.progress import Progress
from warpmuscle.search import islands
from warpmuscle.search.bounds import into_cube
from warpmuscle.search.one_thread import one_thread
from warpmuscle.search.search import frozen

LATEST = 1500  # candidates that a model is fitted to
RIDGE = 1e-2  # of their number
PARTS = (0.1, 0.5, 1.0)  # of the time, at which the best cost is told


class PreselectedIslands(islands.IslandSearch):
    """Islands that ask for more candidates than are simulated.

    Attributes:
        factor: how many times as many. spent: s, that models took.
    """

    factor, spent = 1, 0.0

    def __init__(self, *arguments: Any, **options: Any) -> None:
        """See `IslandSearch`."""
        super().__init__(*arguments, **options)
        self._known: Floats | None = None
        self._costs = np.zeros(0)

    def ask(self) -> Floats:
        """See `Search`."""
        if self._asked is not None or self.factor == 1 or self._known is None:
            return super().ask()
        many = np.concatenate([self._islands.ask(self._generator) for _ in range(self.factor)], axis=1)
        begin = time.perf_counter()
        with one_thread():
            self._sampled = np.array([self._chosen(island, points) for island, points in enumerate(many)])
        PreselectedIslands.spent += time.perf_counter() - begin
        self._asked = frozen(into_cube(self._sampled.reshape(-1, self._sampled.shape[2])))
        return self._asked

    def tell(self, costs: ArrayLike) -> None:
        """See `Search`."""
        self.ask()
        assert self._sampled is not None
        points = self._sampled.reshape(-1, self._sampled.shape[2])
        known = points if self._known is None else np.concatenate([self._known, points])
        self._known, self._costs = known[-LATEST:], np.concatenate([self._costs, np.asarray(costs)])[-LATEST:]
        super().tell(costs)

    def _chosen(self, island: int, points: Floats) -> Floats:
        """Those of an island's points (n, P) that look best, as many as it has candidates."""
        assert self._known is not None
        one = self._islands
        white = one._axes[island] / one._lengths[island] / one.sigma[island]

        def terms(x: Floats) -> Floats:
            z = np.clip((x - one.mean[island]) @ white, -10.0, 10.0)  # those of wider islands
            return np.hstack([np.ones((len(z), 1)), z, z**2])

        matrix = terms(self._known)
        ranks = np.argsort(np.argsort(self._costs, kind="stable"), kind="stable") / max(len(self._costs) - 1, 1)
        normal = matrix.T @ matrix + RIDGE * len(matrix) * np.eye(matrix.shape[1])
        predicted = terms(points) @ np.linalg.solve(normal, matrix.T @ (ranks - 0.5))
        best = np.argsort(predicted, kind="stable")[: one.population]
        return np.asarray(points[best])


class Best:
    """The best cost over time, s or candidates."""

    def __init__(self, by_candidates: bool) -> None:
        self.curve: list[tuple[float, float]] = []
        self.computed = 0.0
        self._by_candidates, self._begin = by_candidates, 0.0

    def __call__(self, progress: Progress) -> None:
        """Take what a search tells of itself."""
        now = time.monotonic()
        self._begin = now if not self._begin or progress.compiling else self._begin
        self.computed = progress.computed
        self.curve.append((float(progress.done) if self._by_candidates else now - self._begin, float(progress.best)))

    def at(self, moment: float) -> float:
        """The best cost by then."""
        return min((cost for when, cost in self.curve if when <= moment), default=np.inf)


def main(
    scene: str,
    until: Annotated[float | None, typer.Option(help="Wall time of each search, s.")] = None,
    candidates: Annotated[int | None, typer.Option(help="Of each search.")] = None,
    factors: Annotated[str, typer.Option(help="How many times as many are asked for, with commas.")] = "1,2",
    seeds: Annotated[int, typer.Option(help="Searches of each kind.")] = 3,
    population: Annotated[int | None, typer.Option(help="Of a generation.")] = None,
    sigma: Annotated[float | None, typer.Option(help="First step.")] = None,
    device: Annotated[str | None, typer.Option(help="cpu, cuda:0, ...")] = None,
    json_path: Annotated[Path | None, typer.Option("--json", help="File for the figures.")] = None,
) -> None:
    """Print a table: a line a factor."""
    wp.config.log_level = wp.LOG_WARNING
    warnings.simplefilter("ignore")
    given = load(scene)
    asked: dict[str, Any] = {"search": "islands", "population": population, "sigma": sigma}
    short = msgspec.structs.replace(given, duration=max(0.1, 4.0 * given.time_step))
    if population is None:  # that of the usual search
        usual = optimize(short, None, 1, device, until=0.5).searched
        assert usual is not None
        asked["population"] = usual.options.population if usual.options.strategy == "islands" else None
    optimize(short, None, 1, device, until=0.5, **asked)  # compiles
    islands.IslandSearch = PreselectedIslands  # type: ignore[misc]  # which strategies look up when they make one
    figures: dict[str, list[dict[str, Any]]] = {}
    whole = float(candidates) if candidates else float(until or 40.0)
    print("| factor | candidates | device at work | models, s | cost after a tenth | half | all |")
    print("|---|---|---|---|---|---|---|", flush=True)
    for factor in map(int, factors.split(",")):
        PreselectedIslands.factor = factor
        runs = figures[str(factor)] = []
        for seed in range(1, seeds + 1):
            best, PreselectedIslands.spent = Best(candidates is not None), 0.0
            result = optimize(given, candidates, seed, device, until=until, progress=best, **asked)
            assert result.evaluations is not None
            assert result.best is not None
            costs = [*(best.at(part * whole) for part in PARTS[:-1]), result.best.cost]
            runs.append({"seed": seed, "candidates": len(result.evaluations.cost), "computed": best.computed,
                         "models": PreselectedIslands.spent, "best": costs})  # fmt: skip
            if json_path is not None:
                json_path.write_text(json.dumps(figures) + "\n")
        medians = [float(np.median([run["best"][k] for run in runs])) for k in range(len(PARTS))]
        each = ", ".join(f"{run['best'][-1]:.4g}" for run in runs)
        count, models = (float(np.median([run[name] for run in runs])) for name in ("candidates", "models"))
        busy = 100.0 * float(np.median([run["computed"] for run in runs]))
        told = " | ".join(f"{cost:.4g}" for cost in medians)
        print(f"| {factor} | {count:.0f} | {busy:.0f} % | {models:.1f} | {told} ({each}) |", flush=True)


if __name__ == "__main__":
    run_script(main)
